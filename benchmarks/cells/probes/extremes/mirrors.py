"""Rigid mirrors and their images, in extended precision, by arithmetic that shares nothing with the simulator."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from benchmarks.cells.probes.extremes.verdict import DELAY_SAMPLES, ECHOES, LEVEL_DB, Error, Errors
from obstaclewatch.support.arrays import Floats
from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, trace_paths
from simulator.paths import Paths
from simulator.scene.pose import held_rotation

Long = NDArray[np.longdouble]
SOUND_M_S = 343.0
RATE_HZ = 192_000.0
SPEAKER_M = np.array([0.0, 0.04, 0.0])
MICS_M = np.array([[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
AHEAD = held_rotation(0.0)
"""The phone's top edge points along +x."""


def slab(low_m: ArrayLike, high_m: ArrayLike, name: str = "wall", velocity_m_s: ArrayLike = (0, 0, 0)) -> Obstacle:
    """A rigid box between two corners."""
    box = trimesh.creation.box(bounds=np.array([low_m, high_m], dtype=np.float64))
    return Obstacle(box, Material.rigid(), name, velocity_m_s=np.asarray(velocity_m_s, dtype=np.float64))


def wall(distance_m: float, half_m: float | None = None) -> Obstacle:
    """A rigid slab across +x; so large, unless said otherwise, that its rim does not matter for a mirror."""
    half = 10.0 * max(1.0, distance_m) if half_m is None else half_m
    return slab([distance_m, -half, -half], [distance_m + max(0.1, 0.01 * distance_m), half, half])


def echoes(
    obstacles: Sequence[Obstacle],
    pose: Pose,
    max_range_m: float,
    phone: Phone | None = None,
    mechanisms: tuple[str, ...] = ("specular", "curved"),
    max_order: int = 1,
    air: Air | None = None,
) -> Paths:
    """The traced paths that meet an obstacle."""
    fidelity = Fidelity(max_order=max_order, max_range_m=max_range_m, mechanisms=mechanisms)
    scene = Scene(list(obstacles), air or Air.lossless(SOUND_M_S))
    paths = trace_paths(scene, phone or Phone.ideal(SPEAKER_M, MICS_M), pose, fidelity=fidelity)
    return paths[paths.order > 0]


def moved(obstacle: Obstacle, shift_m: Floats, turn: Rotation) -> Obstacle:
    """The same rotated about the origin, then shifted."""
    vertices = turn.apply(np.asarray(obstacle.mesh.vertices)) + shift_m
    mesh = trimesh.Trimesh(vertices, obstacle.mesh.faces, process=False)
    return Obstacle(mesh, obstacle.material, obstacle.name, surface=obstacle.surface)


def image_lengths_m(distance_m: float, speaker_m: ArrayLike = SPEAKER_M, mics_m: ArrayLike = MICS_M) -> Long:
    """(M,) path from a speaker by the mirror x = distance to each microphone, all with the phone's top along +x."""
    speaker, mics = (np.asarray(place, dtype=np.longdouble)[..., [1, 0, 2]] for place in (speaker_m, mics_m))
    image = np.array([2 * np.longdouble(distance_m) - speaker[0], speaker[1], speaker[2]])
    return length_m(mics - image)


def length_m(vector: ArrayLike) -> Long:
    """(...,) Euclidean length of (..., 3) in extended precision."""
    squares = np.asarray(vector, dtype=np.longdouble) ** 2
    return np.sqrt(squares.sum(axis=-1))


def against(
    found: Paths,
    mic: Sequence[int],
    length: Long,
    level: ArrayLike | None = None,
    speed_m_s: float = SOUND_M_S,
    limits: tuple[float, float] = (DELAY_SAMPLES, LEVEL_DB),
) -> Errors:
    """Worst errors of found paths, each held against the expected one of its microphone and rank by length.

    Args:
        found: what was traced.
        mic: (K,) microphone of each expected path.
        length: (K,) its length, m.
        level: (K,) its pressure; None is that of a mirror, 1 / length.
        speed_m_s: speed of sound.
        limits: of delay, samples, and of level, dB.
    """
    microphone = np.asarray(mic, dtype=np.int64)
    wanted = np.lexsort((length.astype(np.float64), microphone))
    got = np.lexsort((found.delay_s, found.mic))
    wrong = sum(abs(int(np.sum(found.mic == k)) - int(np.sum(microphone == k))) for k in (0, 1))
    errors = {"echoes": Error(float(wrong), ECHOES)}
    if wrong or len(wanted) == 0:
        return errors
    expected = 1 / length if level is None else np.asarray(level, dtype=np.longdouble)
    late = found.delay_s[got].astype(np.longdouble) - length[wanted] / np.longdouble(speed_m_s)
    louder = 20.0 * np.log10(np.abs(found.gain[got]) / expected[wanted].astype(np.float64))
    return errors | {
        "delay_samples": Error(float(np.abs(late).max()) * RATE_HZ, limits[0]),
        "level_db": Error(float(np.abs(louder).max()), limits[1]),
    }
