"""Fringe waves at creases: where they are found, and the limits in which Kirchhoff's integral needs none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from simulator import Material, Obstacle
from simulator.kirchhoff.fringe_waves import _about, _fringe, add_fringe_waves
from simulator.kirchhoff.illuminating_images import Ends
from simulator.kirchhoff.path_length_grid import Grid
from simulator.surfaces.creases import Creases, creases_of
from simulator.surfaces.facets import facets_of
from simulator.surfaces.reflectors import read_mesh, reflectors_in


def skin(mesh, size_m=0.012):
    reading = read_mesh(Obstacle(mesh, Material.rigid(), "body"))
    return facets_of(reading, reflectors_in(reading)[1], 0, size_m)


def bin_of(sections):
    return trimesh.creation.cylinder(radius=0.25, height=0.9, sections=sections)


@pytest.mark.parametrize("sections", [16, 32, 64])
def test_a_cylinder_has_two_round_rims_of_right_angles(sections):
    creases = skin(bin_of(sections)).creases
    length = np.linalg.norm(creases.along_m, axis=1)
    assert length.sum() == pytest.approx(2.0 * 2.0 * np.pi * 0.25, rel=1e-3)
    assert length.max() <= 0.0061
    np.testing.assert_allclose(creases.open_angle_rad, 1.5 * np.pi, atol=2e-3)
    np.testing.assert_allclose(np.linalg.norm(creases.middle_m[:, :2], axis=1), 0.25, atol=4e-4)


def test_the_facets_beside_a_rim_lie_on_its_two_faces():
    facets = skin(bin_of(32))
    creases = facets.creases
    assert len(creases) > 0
    for face, inwards in ((0, creases.inwards), (1, -creases.normal)):
        beside = creases.beside[:, face]
        offset = facets.middle_m[beside] - creases.middle_m
        assert np.linalg.norm(offset, axis=1).max() < 0.012
        assert (np.sum(offset * inwards, axis=1) > 0.0).all()
    on_side = facets.normal[creases.beside[:, 0]]
    assert np.abs(on_side[:, 2]).max() < 1e-6
    assert np.abs(facets.normal[creases.beside[:, 1]][:, 2]).min() > 1.0 - 1e-9


@pytest.mark.parametrize("mesh", [trimesh.creation.box([0.5, 0.4, 0.9]), trimesh.creation.icosphere(3, 0.3)])
def test_planes_and_spheres_have_none(mesh):
    assert len(skin(mesh).creases) == 0


def test_an_open_tube_has_none():
    tube = bin_of(32)
    sheet = trimesh.Trimesh(tube.vertices, tube.faces[np.abs(tube.face_normals[:, 2]) < 0.5])
    assert len(skin(sheet).creases) == 0


@pytest.mark.parametrize("sections", [16, 32])
def test_a_cap_reaches_to_the_rounded_rim(sections):
    facets = skin(bin_of(sections))
    cap = facets.normal[:, 2] > 0.99
    assert facets.area_m2[cap].sum() == pytest.approx(np.pi * 0.25**2, rel=1e-3)
    assert facets.corner_m[cap, :, 2] == pytest.approx(0.45, abs=1e-12)


def at(distance, angle, along):
    return np.array([distance, angle, along])


def bracket(s, t, open_angle, first=True, second=True):
    l, m = np.hypot(s[0], s[2]), np.hypot(t[0], t[2])
    return _fringe(s, t, l, m, open_angle, first, second)


def test_a_flat_wedge_adds_nothing():
    rng = np.random.default_rng(1)
    for _ in range(100):
        s, t = (at(rng.uniform(0.5, 3.0), rng.uniform(0.1, 3.0), rng.normal()) for _ in range(2))
        assert bracket(s, t, np.pi) == pytest.approx(0.0, abs=1e-9)


def test_swapping_source_and_receiver_changes_nothing():
    rng = np.random.default_rng(2)
    for _ in range(100):
        s, t = (at(rng.uniform(0.5, 3.0), rng.uniform(1.6, 3.1), rng.normal()) for _ in range(2))
        assert bracket(s, t, 1.5 * np.pi) == pytest.approx(bracket(t, s, 1.5 * np.pi), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("face", [0, 1])
def test_it_stays_finite_and_smooth_where_a_reflection_runs_off_the_rim(face):
    """Both parts grow as 1 over the angle from the border; at the border itself and at 1e-9 rad there is no jump."""
    border = np.pi if face == 0 else 2.0 * np.pi
    near = [
        bracket(at(2.0, 0.5 * border, 0.0), at(2.0, 0.5 * border + off, 0.0), 1.5 * np.pi)
        for off in (-1e-3, -1e-5, 0.0, 1e-5, 1e-3)
    ]
    assert np.isfinite(near).all()
    assert np.ptp(near) < 2e-3
    assert abs(near[2]) < 2.0


def fringe_sum(facets, source, receiver, lit, wavenumber):
    """Fringe waves of all creases on a grid of path length, transformed to wavenumbers."""
    grid = Grid.over(facets.radius_m, wavenumber)
    point = np.stack([source, receiver])
    ends = Ends(point, 0.0 * point, 0.0 * point, *np.zeros((2, 2), dtype=np.int64), np.full((1, len(facets)), lit))
    total = np.zeros((1, 1, grid.points, 2))
    one = np.array([0]), np.array([1])
    rigid = np.ones((1, 3), dtype=complex)
    add_fringe_waves(facets.creases, facets.center_m, ends, *one, rigid, grid, total)
    every = np.arange(grid.cells)
    sums = grid.cell_sums(total.view(np.complex128)[..., 0], 0 * every, every)[:, 0]
    centre = grid.centre_m(ends.over(facets.center_m)[0].sum(keepdims=True), every)
    return np.sum(sums * np.exp(-1j * np.outer(centre, wavenumber)), axis=0)


def test_nothing_is_added_where_no_face_is_seen():
    facets, wavenumber = skin(bin_of(32)), np.array([350.0, 370.0])
    ends = np.array([1.25, -0.05, 0.9]), np.array([1.25, 0.05, 0.9])
    assert not fringe_sum(facets, *ends, False, wavenumber).any()
    assert np.abs(fringe_sum(facets, *ends, True, wavenumber)).max() > 1e-5


def by_quadrature(source, receiver, wavenumber):
    """Fringe waves of the upper rim, both faces lit all round, by Gauss-Legendre on 160 arcs of the circle."""
    node, weight = np.polynomial.legendre.leggauss(25)
    turn = (np.arange(160)[:, None] + 0.5 * (node + 1.0)).ravel() * np.pi / 80.0
    weight = np.tile(weight, 160) * np.pi / 160.0
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])
    point, along = 0.25 * out + [0.0, 0.0, 0.45], np.cross([0.0, 0.0, 1.0], out)

    def seen_from(end):
        d = end - point
        beside, down, z = np.sum(d * out, axis=1), -d[:, 2], np.sum(d * along, axis=1)
        return np.hypot(beside, down), np.mod(np.arctan2(beside, down), 2.0 * np.pi), z, np.linalg.norm(d, axis=1)

    (r, t, z, l), (rr, tt, zz, m) = seen_from(source), seen_from(receiver)
    cosh, nu = (l * m + z * zz) / (r * rr), 2.0 / 3.0
    eta = np.arccosh(np.maximum(cosh, 1.0))
    exact = sum(
        nu * np.sin(nu * (np.pi + a * t + b * tt)) / (np.cosh(nu * eta) - np.cos(nu * (np.pi + a * t + b * tt)))
        for a in (-1, 1) for b in (-1, 1)
    )  # fmt: skip
    kirchhoff = sum(np.sin(x) / (cosh + np.cos(x)) for x in (t + tt, 3.0 * np.pi - t - tt))
    shared = (exact - kirchhoff) * 0.25 * weight / (-4.0 * np.pi * l * m)
    return np.exp(-1j * np.outer(wavenumber, l + m)) @ shared


def test_elements_add_up_to_the_line_integral_over_the_exact_circle():
    """From high above, so that both ends see the side and the cap of each element."""
    facets = skin(bin_of(64))
    creases = facets.creases
    upper = creases.middle_m[:, 2] > 0.0
    facets = replace(facets, creases=Creases(*(getattr(creases, n)[upper] for n in Creases.__dataclass_fields__)))
    source, receiver = np.array([0.05, 0.0, 2.4]), np.array([-0.02, 0.1, 2.45])
    wavenumber = np.array([330.0, 380.0, 420.0])
    exact = by_quadrature(source, receiver, wavenumber)
    ours = fringe_sum(facets, source, receiver, True, wavenumber)
    np.testing.assert_allclose(ours, exact, atol=0.01 * np.abs(exact).max())


def test_angles_run_from_the_face_through_the_open_space():
    along, inwards, normal = np.eye(3)[1], -np.eye(3)[2], np.eye(3)[0]
    distance, angle, place = _about(np.array([1.0, 0.3, 1.0]), np.zeros(3), along, 1.0, inwards, normal)
    assert (distance, angle, place) == pytest.approx((np.sqrt(2.0), 0.75 * np.pi, 0.3))


def test_creases_of_a_flat_body_are_none():
    reading = read_mesh(Obstacle(trimesh.creation.box([0.3, 0.3, 0.3]), Material.rigid(), "box"))
    assert len(creases_of(reading, None, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), 0.01)) == 0
