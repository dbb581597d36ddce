"""An endless rigid wall: one image, whose length gives delay and level."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import trimesh
from numpy.typing import NDArray

from benchmarks.gates.physics.measured import Measured
from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

SOUND_M_S = 343.0
RATE_HZ = 192_000.0
POSES = 40
MIRRORS = Fidelity(max_order=1, mechanisms=("specular",))
SPEAKER_M, MICS_M = [0.01, 0.05, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]]


def wall_level_db(seed: int) -> Measured:
    """Greatest |20 log10(gain x length)| of the wall's echo at 0.3-7 m, any incidence up to 70 degrees."""
    delay, gain, length = _echoes(seed)
    worst = np.max(np.abs(20.0 * np.log10(np.abs(gain) * length)), initial=0.0)
    return Measured(float(worst), "dB", len(delay))


def wall_delay_samples(seed: int) -> Measured:
    """Greatest |delay - length / c| of the same echoes, in samples at 192 kHz."""
    delay, _, length = _echoes(seed)
    worst = np.max(np.abs(delay - length / SOUND_M_S), initial=0.0)
    return Measured(float(RATE_HZ * worst), "samples", len(delay))


@lru_cache(maxsize=4)
def _echoes(seed: int) -> tuple[NDArray, NDArray, NDArray]:
    """Delay and gain of every traced echo, and the length of its image path worked out by hand."""
    rng = np.random.default_rng(seed)
    mesh = trimesh.creation.box((0.2, 400.0, 400.0), trimesh.transformations.translation_matrix((0.1, 0.0, 0.0)))
    scene = Scene([Obstacle(mesh, Material.rigid(), "wall")], Air.lossless(SOUND_M_S))
    phone = Phone.ideal(SPEAKER_M, MICS_M)
    rows = []
    for distance, heading, pitch in zip(
        rng.uniform(0.3, 6.8, POSES), np.radians(rng.uniform(-70, 70, POSES)), rng.uniform(0.0, 0.8, POSES), strict=True
    ):
        pose = Pose(np.array([-distance, *rng.uniform(-3, 3, 2)]), held_rotation(heading, pitch))
        paths = trace_paths(scene, phone, pose, fidelity=MIRRORS)
        for k in np.flatnonzero(paths.order == 1):
            speaker, mic = (pose.to_world(np.array(place)).ravel() for place in (SPEAKER_M, MICS_M[paths.mic[k]]))
            image = speaker * [-1.0, 1.0, 1.0]
            rows.append((paths.delay_s[k], paths.gain[k], np.linalg.norm(image - mic)))
    delay, gain, length = np.array(rows, dtype=np.complex128).reshape(-1, 3).T
    return delay.real, gain, length.real
