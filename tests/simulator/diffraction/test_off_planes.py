"""A phone in the plane of a face has the echo that it has a hair beside it, wherever that face runs into a corner."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 26)
AWAY_M = 1.5
BESIDE_M = 1e-4


def _box(*bounds):
    return trimesh.creation.box(bounds=bounds)


WALL = _box([0.2, -2.0, -1.0], [0.5, 2.0, 1.0])
SHEET = trimesh.Trimesh([[0, 0, -1], [0.5, 0, -1], [0.5, 0, 1], [0, 0, 1]], [[0, 1, 2], [0, 2, 3]], process=False)
SCENES = {
    "step": ([trimesh.util.concatenate([_box([0, -1, -1], [0.5, 0, 1]), _box([0.03, 0, -1], [0.5, 1, 1])])], 1),
    "pillar": ([WALL, _box([0, 0, -1], [0.2, 0.3, 1])], 1),
    "niche": ([WALL, _box([0, -0.6, -1], [0.2, -0.3, 1]), _box([0, 0, -1], [0.2, 0.3, 1])], 1),
    "walls in a T": ([_box([0, -1, -1], [0.2, 1, 1]), _box([-0.5, 0, -1], [0, 0.1, 1])], 1),
    "shelf": ([_box([0.3, -1, -1], [0.4, 1, 1]), _box([0, -1, -0.02], [0.3, 1, 0])], 2),
    "sheet on a wall": ([SHEET, _box([0.5, -1, -1], [0.6, 1, 1])], 1),
}  # fmt: skip


def _echoes(name: str, off_m: np.ndarray, level: str) -> np.ndarray:
    """(N, F) from so far off the plane, (N,), at the speaker's height or in line with it."""
    meshes, axis = SCENES[name]
    mics = [[0.03, 0.0, 0.0], [0.03, 0.0, 0.11]] if axis == 1 else [[0.0, 0.0, 0.0], [0.0, 0.11, 0.0]]
    place = np.tile([-AWAY_M, 0.13, -0.17], (len(off_m), 1))
    place[:, axis] = off_m
    scene = Scene([Obstacle(mesh, Material.rigid(), str(n)) for n, mesh in enumerate(meshes)], Air.lossless(343.0))
    phone = Phone.ideal([0.0, 0.0, 0.0 if axis == 1 else 1e-3], mics)
    paths = trace_paths(scene, phone, Pose(place, held_rotation(np.zeros(len(off_m)))), Fidelity(level=level))
    return paths[(paths.mic == 0) & (paths.order > 0)].transfer_function(FREQUENCY_HZ)[:, 0]


@pytest.mark.parametrize("level", ["standard", "auto"])
@pytest.mark.parametrize("name", SCENES)
def test_in_a_plane_is_as_beside_it(name, level):
    """Cause: rounding said which of the paths that meet in a corner are there: +4 dB re a wall too much.

    From 3 to 200 um beside the plane the shares of waves over two edges were rounded: -20 dB.
    """
    nearer_m = (0.0, 1e-12, -1e-9, 1e-9, -1e-6, 1e-6, -5e-6, 5e-6, -1e-5, 1e-5, -3e-5, 3e-5)
    echoes = _echoes(name, np.array([-BESIDE_M, BESIDE_M, *nearer_m]), level)
    assert len(echoes) == 2 + len(nearer_m)
    for off_m, echo in zip(nearer_m, echoes[2:], strict=True):
        off = min(float(np.sqrt(np.mean(np.abs(echo - each) ** 2))) for each in echoes[:2])
        assert 2.0 * AWAY_M * off < 10.0 ** (-40.0 / 20.0), off_m
