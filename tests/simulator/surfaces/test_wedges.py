"""Which edges of a mesh diffract: bodies whose edges can be counted, in any tessellation."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Material, Obstacle
from simulator.surfaces.reflectors import read_mesh, reflectors_in
from simulator.surfaces.wedges import Wedges, wedges_of

SHEET = [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]]


def _wedges(mesh: trimesh.Trimesh, **rest) -> Wedges:
    return wedges_of(read_mesh(Obstacle(mesh, Material.rigid(), "body", **rest)))


def _folded(x: float, y: float) -> trimesh.Trimesh:
    """Two unit squares that meet along z; the second leans towards (x, y)."""
    vertices = SHEET + [[x, y, 0], [x, y, 1]]
    return trimesh.Trimesh(vertices, [[0, 1, 2], [0, 2, 3], [0, 5, 4], [0, 3, 5]], process=False)


def test_box_has_twelve_right_angles_however_it_is_cut():
    whole = trimesh.creation.box((1.0, 2.0, 3.0))
    fine = whole.subdivide().subdivide().subdivide()
    soup = trimesh.Trimesh(whole.triangles.reshape(-1, 3), np.arange(36).reshape(-1, 3), process=False)
    for mesh in (whole, fine, soup):
        wedges = _wedges(mesh)
        assert len(wedges) == 12
        np.testing.assert_allclose(wedges.open_angle_rad, 1.5 * np.pi)
        np.testing.assert_allclose(np.sort(wedges.length_m), np.repeat([1.0, 2.0, 3.0], 4))
        assert (wedges.obstacle == 0).all()
        assert sorted(np.unique(wedges.patch)) == list(range(6))
        assert np.isinf(wedges.sheet_m).all()


def test_irregular_tessellation_of_a_box_changes_nothing():
    assert len(_wedges(trimesh.creation.box((1.0, 2.0, 3.0)).subdivide_to_size(0.3))) == 12


def test_faces_turn_from_the_first_to_the_last_through_the_open():
    # a point at a small angle from either face lies outside the box, one beyond it inside
    wedges = _wedges(trimesh.creation.box((1.0, 2.0, 3.0)))
    middle = 0.5 * (wedges.start_m + wedges.end_m)
    for angle, inside in ((0.01, False), (1.5 * np.pi - 0.01, False), (-0.01, True), (1.5 * np.pi + 0.01, True)):
        point = middle + 0.1 * (np.cos(angle) * wedges.inwards + np.sin(angle) * wedges.normal)
        assert ((np.abs(point) < [0.5, 1.0, 1.5]).all(axis=1) == inside).all()


def test_sheet_has_four_borders():
    wedges = _wedges(trimesh.Trimesh(SHEET, [[0, 1, 2], [0, 2, 3]]))
    np.testing.assert_allclose(wedges.open_angle_rad, [2.0 * np.pi] * 4)
    assert (wedges.patch[:, 0] == wedges.patch[:, 1]).all()


@pytest.mark.parametrize("fold", [0.3, 1.0, np.pi / 2, 2.5])
def test_folded_sheet_opens_to_its_convex_side(fold):
    wedges = _wedges(_folded(np.sin(fold), np.cos(fold)))
    crease = wedges[wedges.patch[:, 0] != wedges.patch[:, 1]]
    assert len(wedges) == 7
    np.testing.assert_allclose(crease.open_angle_rad, 2.0 * np.pi - fold)
    np.testing.assert_allclose(crease.length_m, 1.0)


def test_almost_flat_fold_is_no_edge():
    assert len(_wedges(_folded(np.sin(np.pi - 2e-3), np.cos(np.pi - 2e-3)), surface="flat")) == 6
    # less than rounding bends a face by: one plane, whose sides go on straight over the fold
    assert len(_wedges(_folded(np.sin(np.pi - 1e-3), np.cos(np.pi - 1e-3)), surface="flat")) == 4


def test_three_sheets_that_meet_open_to_the_widest_gap():
    vertices = SHEET + [[1, 0, 0], [1, 0, 1], [1, 1, 0], [1, 1, 1]]
    faces = [[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 3], [0, 6, 7], [0, 7, 3]]
    wedges = _wedges(trimesh.Trimesh(vertices, faces, process=False))
    crease = wedges[wedges.patch[:, 0] != wedges.patch[:, 1]]
    np.testing.assert_allclose(crease.open_angle_rad, 1.5 * np.pi)


def test_concave_crease_of_a_closed_body_is_no_wedge():
    side = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    corner = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in side])
    flat = [[0, 1, 2], [0, 2, 3], [0, 3, 5], [3, 4, 5]]
    walls = [[[i, (i + 1) % 6, (i + 1) % 6 + 6], [i, (i + 1) % 6 + 6, i + 6]] for i in range(6)]
    faces = [f[::-1] for f in flat] + [[6 + v for v in f] for f in flat] + [f for pair in walls for f in pair]
    mesh = trimesh.Trimesh(corner, faces)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(3.0)
    assert len(_wedges(mesh)) == 17


@pytest.mark.parametrize("thickness", [0.002, 0.004])
def test_thin_plate_is_a_sheet_with_a_border_on_either_face(thickness):
    plate = Obstacle(trimesh.creation.box((thickness, 0.4, 0.6)).subdivide(), Material.rigid(), "plate")
    wedges = wedges_of(read_mesh(plate))
    assert len(wedges) == 8
    np.testing.assert_allclose(wedges.open_angle_rad, 2.0 * np.pi)
    np.testing.assert_allclose(wedges.sheet_m, thickness)
    np.testing.assert_allclose(wedges.inwards[:, 0], 0.0, atol=1e-12)
    assert len(reflectors_in(read_mesh(plate))[0]) == 2  # the rim is no mirror


def test_plate_thicker_than_a_quarter_wavelength_is_a_box():
    assert len(_wedges(trimesh.creation.box((0.005, 0.4, 0.6)))) == 12


def test_round_thin_sign_is_a_polygon_of_borders():
    wedges = _wedges(trimesh.creation.cylinder(0.3, 0.003, sections=32))
    assert len(wedges) == 64
    np.testing.assert_allclose(wedges.sheet_m, 0.003)


def test_smooth_bodies_have_none():
    assert len(_wedges(trimesh.creation.icosphere(3))) == 0
    assert len(_wedges(trimesh.creation.cylinder(0.3, 2.0, sections=32))) == 0
