"""The uniform theory of diffraction against its published form, the exact integral, borders and full-wave plates."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from scipy.special import fresnel

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, trace_paths
from simulator.diffraction.btm import edge_terms
from simulator.diffraction.edge_view import APEX, END, START, EdgeView
from simulator.diffraction.utd import utd_terms
from tests.references import fullwave

C = 343.0
WAVENUMBER = 2.0 * np.pi * np.array([18_000.0, 20_500.0, 23_000.0]) / C


def _views(rng: np.random.Generator, count: int, reach_m: float, clear_rad: float = 0.0) -> EdgeView:
    """Random edges; every zone's border at least `clear_rad` away."""
    turn = rng.uniform(1.1 * np.pi, 2.0 * np.pi, 20 * count)
    angle = rng.uniform(0.05, 0.95, (2, len(turn))) * turn
    radius = reach_m * rng.uniform(0.8, 1.2, (2, len(turn)))
    height = rng.uniform(-0.3, 0.3, (2, len(turn))) * reach_m
    f = np.pi + np.stack([angle[0] - angle[1], angle[1] - angle[0], -angle.sum(axis=0), angle.sum(axis=0)])
    f -= 2.0 * turn * np.round(f / (2.0 * turn))
    rows = np.flatnonzero((np.abs(f) > clear_rad).all(axis=0))[:count]
    assert len(rows) == count
    ends = radius[0], angle[0], height[0], radius[1], angle[1], height[1], np.ones(len(turn)), turn
    return EdgeView(*(value[rows] for value in ends))


def _kouyoumjian_pathak(view: EdgeView, k: float) -> complex:
    """Eq. 25 as printed, for hard faces: four cotangents times Fresnel integrals, N the nearest integers."""
    rs, ps, zs, rr, pr, zr, _, turn = (float(getattr(view, name)[0]) for name in EdgeView.__dataclass_fields__)
    n, apex = turn / np.pi, zs + (zr - zs) * rs / (rs + rr)
    s, s_in = np.hypot(rr, zr - apex), np.hypot(rs, zs - apex)
    sine = rs / s_in

    def part(beta, sign):
        whole = round((beta + sign * np.pi) / (2.0 * np.pi * n))
        a = 2.0 * np.cos(0.5 * (2.0 * n * np.pi * whole - beta)) ** 2
        x = k * s * s_in * sine**2 / (s + s_in) * a
        root = np.sqrt(2.0 * x / np.pi)
        sine_integral, cosine_integral = fresnel(root)
        tail = np.sqrt(np.pi / 2.0) * ((0.5 - cosine_integral) - 1j * (0.5 - sine_integral))
        return 2j * np.sqrt(x) * np.exp(1j * x) * tail / np.tan((np.pi + sign * beta) / (2.0 * n))

    terms = [part(pr - ps, 1), part(pr - ps, -1), part(pr + ps, 1), part(pr + ps, -1)]
    d = -np.exp(-0.25j * np.pi) / (2.0 * n * np.sqrt(2.0 * np.pi * k) * sine) * sum(terms)
    return d * np.sqrt(s_in / (s * (s_in + s))) / s_in


def test_is_the_published_coefficient(rng):
    view = _views(rng, 40, 1.5, 1e-3)
    ours = utd_terms(view, np.full(40, APEX), WAVENUMBER).sum(axis=1)
    for i in range(40):
        expected = [_kouyoumjian_pathak(view[[i]], k) for k in WAVENUMBER]
        np.testing.assert_allclose(ours[i], expected, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(("reach_m", "error"), [(1.0, 2e-3), (4.0, 5e-4), (16.0, 1.25e-4)])
def test_tends_to_the_exact_integral_of_an_endless_edge(rng, reach_m, error):
    view, part = _views(rng, 200, reach_m), np.full(200, APEX)
    exact, ours = (terms(view, part, WAVENUMBER) for terms in (edge_terms, utd_terms))
    scale = np.abs(exact).max(axis=(1, 2), keepdims=True)
    assert (np.abs(ours - exact) / scale).max() < error


def test_ends_are_silent(rng):
    view = _views(rng, 5, 1.0)
    for part in (START, END):
        np.testing.assert_array_equal(utd_terms(view, np.full(5, part), WAVENUMBER), 0.0)


def test_reciprocity(rng):
    view = _views(rng, 50, 1.0)
    swapped = EdgeView(
        view.receiver_radius_m, view.receiver_angle_rad, view.receiver_height_m, view.source_radius_m,
        view.source_angle_rad, view.source_height_m, view.length_m, view.open_angle_rad,
    )  # fmt: skip
    part = np.full(50, APEX)
    np.testing.assert_allclose(utd_terms(view, part, WAVENUMBER), utd_terms(swapped, part, WAVENUMBER), rtol=1e-12)


@pytest.mark.parametrize("open_angle", [1.5 * np.pi, 2.0 * np.pi, 1.2 * np.pi])
@pytest.mark.parametrize("border", ["incident", "face 0", "face n"])
def test_field_is_continuous_across_the_borders_of_zones(open_angle, border):
    # just lit: the direct or mirror path and the edge; just dark: the edge alone
    source = 0.3 if border != "face n" else open_angle - 0.3
    edge_of_zone = {"incident": np.pi + source, "face 0": np.pi - source, "face n": 2 * open_angle - np.pi - source}
    beyond = -1.0 if border == "face n" else 1.0  # the dark side
    if not 0.0 < edge_of_zone[border] < open_angle:
        pytest.skip("the zone's border lies inside the wedge")
    fields, step = [], 1e-7
    for side in (-1.0, 0.0, 1.0):
        angle = edge_of_zone[border] + side * beyond * step
        values = (1.2, source, 0.0, 0.9, angle, 0.2, 1.0, open_angle)
        view = EdgeView(*(np.array([float(v)]) for v in values))
        lit = side <= 0.0
        edge = utd_terms(view, np.array([APEX]), WAVENUMBER)[0].sum(axis=0)
        edge = edge * np.exp(-1j * WAVENUMBER * view.apex_path_m[0])
        gap = np.pi - side * step
        length = np.sqrt(1.2**2 + 0.9**2 - 2.0 * 1.2 * 0.9 * np.cos(gap) + 0.2**2)
        fields.append(edge + lit * np.exp(-1j * WAVENUMBER * length) / length)
    for field in (fields[0], fields[2]):
        assert (np.abs(field - fields[1]) < 1e-5 * np.abs(fields[1])).all()


@pytest.mark.parametrize("name", ["45x45", "20x30"])
def test_plates_against_full_wave_lack_their_corners(name):
    # the image and the apexes alone: 1.3 dB above -20 dB re wall, 1.6 dB to -30 dB
    stored = fullwave.stored(f"plate_{name}")
    y, z = 0.5 * float(stored["w"]), 0.5 * float(stored["h"])
    corners = [[0.0, -y, -z], [0.0, y, -z], [0.0, y, z], [0.0, -y, z]]
    plate = Obstacle(trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]]), Material.rigid(), "plate")
    errors, f = [], stored["f"]
    for i, distance in enumerate(stored["d"]):
        phone = Phone.ideal(stored["S"][i], [stored["R"][i], stored["R"][i] + [0.0, 0.0, 0.11]])
        pose = Pose(np.zeros(3), Rotation.identity())
        paths = trace_paths(Scene([plate], Air.lossless(C)), phone, pose, Fidelity(max_order=1, diffraction="utd"))
        echo = paths[paths.order > 0].transfer_function(f)[0]
        ours, exact = (fullwave.correlation_peak(h, f, 2.0 * distance / C)[0] for h in (echo, stored["H"][i, 0]))
        below_wall_db = exact + 20.0 * np.log10(2.0 * distance)
        errors.append(abs(ours - exact))
        assert errors[-1] <= (2.2, 1.7, 1.4)[np.searchsorted([-30.0, -20.0], below_wall_db)]
    assert max(errors) > 1.0  # it is the uniform theory that answered
