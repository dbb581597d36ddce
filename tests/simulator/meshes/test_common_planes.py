"""Flush boxes of one mesh keep their echoes where a file has rounded their corners.

Cause: what stood flush had steps, slits and kinks of a tenth of a millimetre, and each was an edge, a corner or a
mirror: an open crate of five boxes had echoes of -21 dB re 1 m beside its own of -35.
"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Pose, held_rotation
from simulator.meshes.common_planes import WITHIN_M, on_common_planes
from tests.simulator.meshes.one_body import echo_on_ground


def _crate(size_m: tuple[float, float, float], wall_m: float, yaw_rad: float) -> trimesh.Trimesh:
    """A floor and four sides, each a box, open above."""
    (a, b, c), t = size_m, wall_m
    bounds = [
        [[0, 0, 0], [a, b, t]], [[0, 0, t], [t, b, c]], [[a - t, 0, t], [a, b, c]], [[t, 0, t], [a - t, t, c]],
        [[t, b - t, t], [a - t, b, c]],
    ]  # fmt: skip
    crate = trimesh.util.concatenate([trimesh.creation.box(bounds=each) for each in bounds])
    return crate.apply_transform(trimesh.transformations.rotation_matrix(yaw_rad, [0.0, 0.0, 1.0]))


def _rounded(mesh: trimesh.Trimesh, to_m: float) -> trimesh.Trimesh:
    return trimesh.Trimesh(np.round(mesh.vertices / to_m) * to_m, mesh.faces, process=False)


@pytest.mark.parametrize(("to_m", "share"), [(1e-4, 0.1), (1e-3, 0.75)])
@pytest.mark.parametrize(
    ("size_m", "wall_m", "yaw_rad", "ahead_m", "height_m"),
    [
        ((0.435, 0.5926, 0.4531), 0.0318, 4.1583, 1.19, 0.42),
        ((0.6884, 0.3182, 0.5533), 0.0263, 4.0309, 1.92, 1.70),
        ((0.7533, 0.6297, 0.3918), 0.0202, 1.0111, 0.93, 0.48),
    ],
)
def test_a_crate_of_boxes_echoes_alike_with_rounded_corners(size_m, wall_m, yaw_rad, ahead_m, height_m, to_m, share):
    crate = _crate(size_m, wall_m, yaw_rad)
    middle = crate.bounds.mean(axis=0)
    crate.apply_translation([ahead_m - middle[0], -0.1 - middle[1], 0.0])
    place = Pose([0.0, 0.0, height_m], held_rotation(0.05, pitch_rad=0.5))
    exact = echo_on_ground(crate, place)
    assert np.abs(echo_on_ground(_rounded(crate, to_m), place) - exact).max() < share * np.abs(exact).max()


def test_flush_faces_come_into_one_plane_and_corners_hardly_move(rng):
    crate = _crate((0.5, 0.4, 0.45), 0.03, 0.7)
    rounded = _rounded(crate, 1e-3)
    level = on_common_planes(rounded, "auto")
    along = np.round(crate.face_normals, 6)
    for normal in np.unique(along, axis=0):
        corners = np.flatnonzero((along == normal).all(axis=1))
        height = [(mesh.vertices[mesh.faces[corners]] @ normal).ravel() for mesh in (crate, level)]
        for plane in np.unique(np.round(height[0], 6)):
            assert np.ptp(height[1][np.abs(height[0] - plane) < 1e-6]) < 2e-3
    moved = np.linalg.norm(level.vertices[level.faces] - rounded.vertices[rounded.faces], axis=2)
    assert 0.0 < moved.max() < 2.0 * WITHIN_M


def test_what_fits_already_is_the_same_object():
    crate = _crate((0.5, 0.4, 0.45), 0.03, 0.7)
    assert on_common_planes(crate, "auto") is crate


def test_a_bend_within_one_piece_is_meant():
    """The sides of a litter bin bend by a quarter of a degree half-way up, half a millimetre off one plane."""
    foot, waist, top = 0.22, 0.2515, 0.281
    rings = [[[-r, -r, z], [r, -r, z], [r, r, z], [-r, r, z]] for r, z in ((foot, 0.0), (waist, 0.45), (top, 0.9))]
    bin_ = trimesh.convex.convex_hull(np.concatenate(rings))
    assert on_common_planes(bin_, "auto") is bin_


def test_facets_that_would_turn_over_keep_their_planes():
    """A label of a fifth of a millimetre on a box: its rim would have no width."""
    box = trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [0.4, 0.4, 0.4]])
    label = trimesh.creation.box(bounds=[[-2e-4, 0.1, 0.1], [0.0, 0.3, 0.3]])
    both = trimesh.util.concatenate([box, label])
    assert on_common_planes(both, "auto") is both


def test_what_closes_upon_itself_is_no_face():
    """Cause: the side of this post has no mean normal, and every corner lies in the plane of such a normal."""
    post = trimesh.creation.cylinder(0.15, 1.5, sections=32).apply_translation([1.35, -0.55, 0.75])
    assert on_common_planes(post, "auto") is post
