"""Bodies that touch echo alike whether or not their file has joined their vertices or turned a triangle over."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import trimesh
from numpy.typing import ArrayLike, NDArray

from simulator import Pose, held_rotation
from simulator.meshes.clean_meshes import cleaned
from simulator.meshes.touching_bodies import read_apart
from tests.simulator.meshes.one_body import echo_on_ground

BLOCK_M = np.array([0.3, 0.45, 0.5])


def _blocks(there: NDArray[np.bool_]) -> trimesh.Trimesh:
    """Blocks of a grid, 1.8 m ahead, each with corners of its own."""
    corner = np.array([1.8, -0.45, 0.0]) + BLOCK_M * np.argwhere(there)
    return _boxes(np.stack([corner, corner + BLOCK_M], axis=1))


def _boxes(bounds: Sequence[ArrayLike]) -> trimesh.Trimesh:
    """Boxes (B, 2, 3), each with corners of its own."""
    return trimesh.util.concatenate([trimesh.creation.box(bounds=each) for each in bounds])


def _joined(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    copy = mesh.copy()
    copy.merge_vertices()
    return copy


def _one_turned_over(mesh: trimesh.Trimesh, which: int) -> trimesh.Trimesh:
    faces = mesh.faces.copy()
    faces[which] = faces[which, ::-1]
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


@pytest.mark.parametrize("draw", range(20))
def test_blocks_with_joined_corners_are_read_apart(draw: int) -> None:
    # Four facets on one edge belong to no closed surface: such blocks were taken for sheets.
    rng = np.random.default_rng(draw)
    there = rng.random((2, 3, 3)) < 0.6
    there[0, 0, 0] = True
    blocks = _blocks(there)
    found, closed = cleaned(_joined(blocks))
    assert closed
    bodies = found.split(only_watertight=True)
    assert len(bodies) == there.sum()
    assert sorted(np.round([body.volume for body in bodies], 9)) == pytest.approx([np.prod(BLOCK_M)] * there.sum())


@pytest.mark.parametrize("which", range(0, 48, 5))
def test_a_triangle_that_is_turned_over_is_turned_back(which: int) -> None:
    blocks = _blocks(np.ones((2, 1, 2), dtype=bool))
    found, closed = cleaned(_one_turned_over(blocks, which))
    assert closed
    assert found.volume == pytest.approx(blocks.volume)


@pytest.mark.parametrize(
    "there", [[[[1, 1, 0], [1, 0, 1]], [[1, 0, 0], [0, 1, 1]]], [[[1, 0], [1, 1]], [[1, 1], [0, 1]]]]
)
def test_joined_blocks_echo_as_loose_ones(there: list[list[list[int]]]) -> None:
    # Edges between two bodies were missing, and others wrong by up to -33 dB re 1 m.
    blocks = _blocks(np.array(there, dtype=bool))
    expected = echo_on_ground(blocks)
    for other in (_joined(blocks), _one_turned_over(blocks, 7)):
        np.testing.assert_allclose(echo_on_ground(other), expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("ahead_m", "heading_rad", "pitch_rad"), [((0.0, 0.2, 1.39), 0.0, 0.0), ((0.0, -0.03, 1.39), 0.1, 0.5)]
)
def test_a_tower_of_two_blocks_echoes_as_one_of_a_piece(
    ahead_m: tuple[float, float, float], heading_rad: float, pitch_rad: float
) -> None:
    # The top of the lower block, which the upper one hides, counted as a sheet upon the level top of the block beside
    # it. So the corner of that top, the tower's side and a wall lost its echo of -13 dB re 1 m where a level phone sees
    # it along the border of the top, and -23 dB where the tower's edge hides it.
    low, back = [[1.8, 0.0, 0.0], [2.1, 0.45, 0.5]], [[2.1, -0.45, 0.0], [2.4, 0.45, 1.5]]
    place = Pose(ahead_m, held_rotation(heading_rad, pitch_rad=pitch_rad))

    def echo(*tower: list[list[float]]) -> NDArray[np.complex128]:
        return echo_on_ground(_boxes([*tower, low, back]), place)

    whole = echo([[1.8, -0.45, 0.0], [2.1, 0.0, 1.0]])
    stacked = echo([[1.8, -0.45, 0.0], [2.1, 0.0, 0.5]], [[1.8, -0.45, 0.5], [2.1, 0.0, 1.0]])
    assert np.abs(stacked - whole).max() < 2e-3


def test_what_is_not_clear_stays_one_mesh() -> None:
    """A free border, facets wound against each other on a shared edge, and three sheets on one edge."""
    fan = np.array([[0.0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]])
    for faces in ([[0, 1, 2]], [[0, 1, 2], [0, 1, 3]], [[0, 1, 2], [1, 0, 3], [0, 1, 4]]):
        mesh = trimesh.Trimesh(fan, faces, process=False)
        assert read_apart(mesh) is mesh


def test_overlapping_bodies_with_a_common_edge_stay_one_mesh() -> None:
    """Round the edge two solids begin before either ends."""
    low = trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    turned = low.copy().apply_transform(trimesh.transformations.rotation_matrix(0.5, [0.0, 0.0, 1.0]))
    mesh = _joined(trimesh.util.concatenate([low, turned]))
    assert read_apart(mesh) is mesh
