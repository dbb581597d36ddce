"""Edges that run into a mirror, seen by a phone opposite the very place where they do, against images."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, trace_paths

HZ = np.linspace(18e3, 23e3, 21)
PLACE_M = np.array([0.0, 0.0, 1.3])
HEIGHT_M = 2.0
AHEAD_M = 1.5
UPSIDE_DOWN = trimesh.transformations.rotation_matrix(np.pi, [1.0, 0.0, 0.0])
ACROSS = np.array([[0.0, 0.07, 0.0], [0.0, -0.07, 0.0], [0.0, -0.07, 0.02]])
ALONG = np.array([[-0.07, 0.0, 0.0], [0.07, 0.0, 0.0], [0.07, 0.0, 0.02]])


def _ground() -> trimesh.Trimesh:
    return trimesh.creation.box(bounds=[[-8.0, -8.0, -1.0], [8.0, 8.0, 0.0]])


def _sheet(low_m: float) -> trimesh.Trimesh:
    corners = [[AHEAD_M, y, z] for y, z in ((0.0, low_m), (4.0, low_m), (4.0, HEIGHT_M), (0.0, HEIGHT_M))]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


def _wall(low_m: float) -> trimesh.Trimesh:
    return trimesh.creation.box(bounds=[[AHEAD_M, 0.0, low_m], [AHEAD_M + 0.2, 4.0, HEIGHT_M]])


def _echo(meshes: dict[str, trimesh.Trimesh], points_m: np.ndarray, steps_m: np.ndarray, level: str) -> np.ndarray:
    """(N, F) at the first microphone, of paths that meet all obstacles and are about as long as that to the corner."""
    scene = Scene([Obstacle(mesh, Material.rigid(), name) for name, mesh in meshes.items()], Air.lossless(343.0))
    still = Rotation.concatenate([Rotation.identity()] * len(steps_m))
    paths = trace_paths(scene, Phone.ideal(points_m[0], points_m[1:]), Pose(steps_m, still), Fidelity(level=level))
    near = np.abs(343.0 * paths.delay_s - 2.0 * np.hypot(AHEAD_M, PLACE_M[2])) < 0.05
    all_met = np.array([set(met) == set(meshes) for met in paths.obstacles_met()])
    paths = paths[near & all_met & (paths.mic == 0)]
    echo = np.zeros((len(steps_m), len(HZ)), dtype=np.complex128)
    np.add.at(echo, paths.pose, paths.gain_at(HZ) * np.exp(-2j * np.pi * HZ * paths.delay_s[:, None]))
    return echo


@pytest.mark.parametrize("level", ["standard", "auto", "reference"])
@pytest.mark.parametrize("upside_down", [False, True])
@pytest.mark.parametrize("standing", [_sheet, _wall])
@pytest.mark.parametrize("transducers", [ACROSS, ALONG])
def test_opposite_the_foot_of_an_edge_it_echoes_as_with_its_image(transducers, standing, upside_down, level):
    """Cause: the apex of the path over ground and edge lay exactly where the edge and its image meet, and an edge does
    not own its start: neither took its half of the mirror's echo back (+6 dB), and 1e-12 m beside it either did.

    Held against the same without the ground: the obstacle with its image, the speaker below. A transducer in the plane
    of a face is taken for one 20 um before it, which moves the echo by a thousandth.
    """
    steps_m = np.array([[0.0] * 3, [0.0, 1e-12, 0.0], [0.0, 0.0, 1e-12], [0.0, 0.0, -1e-12], [0.0, 0.0, -1e-10]])
    points_m = PLACE_M + transducers
    with_ground, beside_m = {"ground": _ground(), "wall": standing(0.0)}, points_m
    if upside_down:  # the edge has its other end there
        beside_m = points_m * [1.0, -1.0, -1.0]
        for mesh in with_ground.values():
            mesh.apply_transform(UPSIDE_DOWN)
    echo = _echo(with_ground, beside_m, steps_m, level)
    below_m = np.concatenate([points_m[:1] * [1.0, 1.0, -1.0], points_m[1:]])
    exact = _echo({"wall": standing(-HEIGHT_M)}, below_m, np.zeros((1, 3)), level)
    assert np.abs(exact).mean() == pytest.approx(0.5 / (2.0 * np.hypot(AHEAD_M, PLACE_M[2])), rel=0.05)
    np.testing.assert_allclose(echo, np.repeat(exact, len(echo), axis=0), atol=2e-3 * np.abs(exact).mean())
