"""Free pillars one of whose sides drops out of view, against boundary elements of their cross-sections.

They are stored by tests/references/make_grazed_face_values.

Cause: an edge was asked for only where speaker or microphone was before both of its faces. Where both were behind the
plane of a face, what ran along that face from the edge before it and back was missing: -45 dB re a wall came and went
within a millimetre, before a box of 2 to 10 cm as before a triangular pillar.
"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, PreparedScene, Scene, trace_paths
from tests.references import make_grazed_face_values as made

TALL_M = 3.0  # half of the pillar's height: its ends return much later


@pytest.mark.parametrize("level", ["standard", "auto"])
@pytest.mark.parametrize(("name", "most"), [("triangle", 2.5e-3), ("box", 1.5e-3)])
def test_what_runs_along_a_side_that_drops_out_of_view(name, most, level):
    """Of a wall's echo; it was up to 0.006. What is left are waves over both edges of a face that is well in view."""
    corner, source = made.CASES[name]
    with np.load(made.STORED) as values:
        exact = values[name]
    away = np.linalg.norm(source, axis=1) if name == "triangle" else -source[:, 0]
    wall = np.exp(-made.DAMPING_1_S * 2.0 * away / made.SPEED_M_S) / np.sqrt(2.0 * away)
    scene = PreparedScene(Scene([Obstacle(_pillar(corner), Material.rigid(), name)], Air.lossless(made.SPEED_M_S)))
    ours = np.array([_echo(scene, *ends, level) for ends in zip(source, made.microphones(source), strict=True)])
    error = np.sqrt((np.abs(ours - exact) ** 2).mean(axis=1)) / wall
    assert error.max() < most


def _pillar(corner: np.ndarray) -> trimesh.Trimesh:
    n, low = len(corner), np.arange(len(corner))
    after = (low + 1) % n
    vertices = np.concatenate([np.column_stack([corner, np.full(n, z)]) for z in (-TALL_M, TALL_M)])
    sides = [np.column_stack([low, after, n + after]), np.column_stack([low, n + after, n + low])]
    fan = np.arange(1, n - 1)
    ends = [np.column_stack([0 * fan, fan + 1, fan]), n + np.column_stack([0 * fan, fan, fan + 1])]
    return trimesh.Trimesh(vertices, np.concatenate([*sides, *ends]))


def _echo(scene: PreparedScene, speaker_m: np.ndarray, mic_m: np.ndarray, level: str) -> np.ndarray:
    speaker, mic = np.append(speaker_m, 0.0), np.append(mic_m, 0.0)
    phone = Phone.ideal(speaker, [mic, mic + [0.0, 0.0, 0.11]])
    paths = trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], Rotation.identity()), Fidelity(level=level))
    in_plane = np.abs(paths.points_m[:, :, 2]).max(axis=1) < 0.05
    paths = paths[(paths.order > 0) & (paths.mic == 0) & in_plane]
    delay = paths.delay_s[:, None]
    wave = np.exp(-(2j * np.pi * made.FREQUENCY_HZ + made.DAMPING_1_S) * delay)
    return (paths.gain_at(made.FREQUENCY_HZ) * wave * np.sqrt(delay * made.SPEED_M_S)).sum(axis=0)
