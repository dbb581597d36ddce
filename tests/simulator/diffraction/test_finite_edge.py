"""One edge: the split line integral against direct quadrature, its limits, symmetries and zone boundaries."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from simulator.diffraction.edge_view import APEX, END, START, EdgeView
from simulator.diffraction.finite_edge import FACE_0, edge_terms
from simulator.waves import band

C = 343.0
WAVENUMBER = 2.0 * np.pi * np.array([15_500.0, 20_000.0, 24_500.0]) / C


def _view(source, receiver, length, open_angle) -> EdgeView:
    """One edge; source and receiver as (radius, angle, height)."""
    values = (*source, *receiver, length, open_angle)
    return EdgeView(*(np.array([v], dtype=float) for v in values))


def _whole(view: EdgeView, wavenumber=WAVENUMBER):
    """(K,) sum over the parts that exist, and the strongest of them."""
    total, strongest = np.zeros(len(wavenumber), complex), 0.0
    for part in (APEX, START, END):
        if view.has(part)[0]:
            index = np.array([part])
            term = edge_terms(view, index, wavenumber)[0].sum(axis=0)
            strongest = max(strongest, np.abs(term).max())
            total += term * np.exp(-1j * wavenumber * view.path_m(index))
    return total, strongest


def _quadrature(view: EdgeView, k: float) -> complex:
    """The line integral over z as Svensson writes it, adaptively, cut at the apex."""
    values = [float(getattr(view, name)[0]) for name in EdgeView.__dataclass_fields__]
    rs, ts, zs, rr, tr, zr, length, turn = values
    nu = np.pi / turn

    def integrand(z):
        m, l = np.hypot(rs, z - zs), np.hypot(rr, z - zr)
        eta = np.arccosh(max((m * l + (z - zs) * (z - zr)) / (rs * rr), 1.0))
        angles = [np.pi + a * ts + b * tr for a in (1, -1) for b in (1, -1)]
        beta = sum(np.sin(nu * f) / (np.cosh(nu * eta) - np.cos(nu * f)) for f in angles)
        return beta * np.exp(-1j * k * (m + l)) / (m * l)

    apex = zs + (zr - zs) * rs / (rs + rr)
    spread = apex + np.concatenate([-np.geomspace(1e-6, 3.0, 40), [0.0], np.geomspace(1e-6, 3.0, 40)])
    cuts = np.unique(np.concatenate([[0.0, length], spread[(spread > 0.0) & (spread < length)]]))
    pieces = [
        quad(integrand, a, b, epsabs=1e-11, epsrel=1e-9, limit=400, complex_func=True)[0]
        for a, b in itertools.pairwise(cuts)
    ]
    return -nu / (4.0 * np.pi) * sum(pieces)


@pytest.mark.filterwarnings("ignore:The occurrence of roundoff")  # 1e-11 beside a pole is beyond quad
@pytest.mark.parametrize(
    ("source", "receiver", "length", "open_angle"),
    [
        ((1.5, 1.2, 0.3), (1.6, 1.1, 0.35), 0.9, 2 * np.pi),  # both in front of a sheet, apex on the edge
        ((1.5, 1.2, -0.4), (1.6, 1.1, -0.35), 0.9, 2 * np.pi),  # apex below the edge
        ((3.0, 2.9, 0.8), (2.9, 2.8, 0.8), 0.6, 1.5 * np.pi),  # apex above it, a box seen from its side
        ((0.8, 1.5, 0.1), (0.7, np.pi - 1.5 + 1e-4, 0.1), 0.5, 1.5 * np.pi),  # beside a zone boundary
        ((0.8, 1.5, 0.001), (0.7, np.pi - 1.5 - 1e-4, 0.001), 0.5, 1.5 * np.pi),  # the same next to a corner
        ((0.8, 0.4, 0.2), (0.7, 5.1, 0.3), 0.5, 2 * np.pi),  # into the shadow
        ((0.05, 1.0, 0.2), (0.12, 0.9, 0.25), 0.5, 1.5 * np.pi),  # almost touching
        ((6.5, 2.0, 0.2), (6.6, 2.1, 0.2), 0.05, 1.1 * np.pi),  # short, far, blunt
        ((2.0, 3.0, 2.6), (2.2, 2.8, -1.5), 1.0, 1.7 * np.pi),  # skew
    ],
)
def test_parts_add_up_to_the_line_integral(source, receiver, length, open_angle):
    view = _view(source, receiver, length, open_angle)
    for k in WAVENUMBER[[0, 2]]:
        total, strongest = _whole(view, np.array([k, 1.2 * k]))
        exact = _quadrature(view, k)
        assert abs(exact) > 0.0
        # 0.01 dB is 1.2e-3; the quadratures' own truncation is 1e-7 of the strongest part
        assert abs(total[0] - exact) < 1e-6 * strongest
        assert abs(total[0] - exact) < 1.1e-3 * abs(exact)


_radius = st.floats(0.1, 7.0)
_height = st.floats(-1.0, 2.0)
_share = st.floats(0.0, 1.0)


@settings(max_examples=60, deadline=None)
@given(_radius, _share, _height, _radius, _share, _height, st.floats(0.02, 3.0), st.floats(1.01, 2.0), _share)
def test_reciprocity_and_additivity(rs, ts, zs, rr, tr, zr, length, turn, cut):
    turn *= np.pi
    there = _view((rs, ts * turn, zs), (rr, tr * turn, zr), length, turn)
    back = _view((rr, tr * turn, zr), (rs, ts * turn, zs), length, turn)
    (first, scale), (second, _) = _whole(there), _whole(back)
    np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-9 * scale)
    middle = length * (0.1 + 0.8 * cut)
    low = replace(there, length_m=np.array([middle]))
    high = _view((rs, ts * turn, zs - middle), (rr, tr * turn, zr - middle), length - middle, turn)
    (one, s1), (two, s2) = _whole(low), _whole(high)
    np.testing.assert_allclose(one + two, first, rtol=0.0, atol=1e-7 * max(scale, s1, s2))


def test_flat_wedge_diffracts_nothing():
    total, _ = _whole(_view((1.0, 1.0, 0.2), (1.3, 0.8, 0.4), 0.7, np.pi))
    np.testing.assert_allclose(total, 0.0, atol=1e-12)


@pytest.mark.parametrize("open_angle", [1.5 * np.pi, 2.0 * np.pi])
@pytest.mark.parametrize("height", [0.4, 0.02, 1e-5, 0.0])
@pytest.mark.parametrize("lean", [0.3, 1.5])
def test_sum_with_the_mirror_path_is_continuous_across_its_zone(open_angle, height, lean):
    # the apex at a given height above the edge's start: on a corner the mirror path is worth a quarter
    rs, rr, wide = 1.4, 1.5, 1e-8
    sums = []
    for step in (-wide, -1e-10, 0.0, 1e-10, wide):
        receiver_angle = np.pi - lean - step  # step > 0: the mirror path meets face 0
        view = _view((rs, lean, height), (rr, receiver_angle, height), 0.8, open_angle)
        image = np.sqrt(rs**2 + rr**2 + 2.0 * rs * rr * np.cos(step))
        lit = step > -5e-10  # the mirrors' search keeps a point that lies on the border to within 1e-9 m
        on_patch = (np.exp(-1j * WAVENUMBER * image) / image if lit else 0.0) if height > 0.0 else None
        total, _ = _whole(view)
        sums.append(total if on_patch is None else total + on_patch)
    if height == 0.0:  # the other edge of the corner would supply the rest: alone, this one steps by half an image
        assert abs(np.abs(sums[4] - sums[0])[0] - 0.5 / (rs + rr)) < 1e-5
        return
    for total in sums[1:]:
        # beside a corner the field turns within an angle of height / radius, of which the steps are a part
        np.testing.assert_allclose(total, sums[0], rtol=0.0, atol=(1e-5 + wide / height) / (rs + rr))


def test_on_the_boundary_the_mirror_counts_half():
    # a half-plane's straight edge, long both ways: on the zone boundary the mirrored field is half the image
    view = _view((1.4, 1.0, 4.0), (1.4, np.pi - 1.0, 4.0), 8.0, 2.0 * np.pi)
    apex = edge_terms(view, np.array([APEX]), WAVENUMBER)[0, FACE_0]
    np.testing.assert_allclose(apex, -0.5 / 2.8, rtol=1e-9)


def test_gains_are_smooth_over_the_band(rng):
    # a row carries six Chebyshev nodes: a Laplace transform in k is then interpolated to 4e-6 (7.9^-6)
    count = 300
    turn = rng.choice([1.5 * np.pi, 2.0 * np.pi], count)
    view = EdgeView(
        rng.uniform(0.2, 6.0, count), turn * rng.uniform(0.0, 1.0, count), rng.uniform(-0.5, 1.0, count),
        rng.uniform(0.2, 6.0, count), turn * rng.uniform(0.0, 1.0, count), rng.uniform(-0.5, 1.0, count),
        rng.uniform(0.1, 1.0, count), turn,
    )  # fmt: skip
    between = np.linspace(16_000.0, 24_000.0, 5)
    for part in (APEX, START, END):
        parts = np.full(count, part)
        nodes = edge_terms(view, parts, 2.0 * np.pi * band.nodes_hz(6) / C).sum(axis=1)
        there = edge_terms(view, parts, 2.0 * np.pi * between / C).sum(axis=1)
        carried = band.evaluate(band.coefficients(nodes), between)
        scale = np.abs(there).max(axis=1, keepdims=True)
        assert (np.abs(carried - there) < 1e-4 * scale).all()


def test_bad_views_name_value_and_rule():
    with pytest.raises(ValueError, match=r"off the edge.* 0\.0 m"):
        edge_terms(_view((0.0, 1.0, 0.2), (1.3, 0.8, 0.4), 0.7, 2 * np.pi), np.array([APEX]), WAVENUMBER)
    with pytest.raises(ValueError, match="open_angle_rad must be pi to 2 pi"):
        edge_terms(_view((1.0, 1.0, 0.2), (1.3, 0.8, 0.4), 0.7, 2.0), np.array([APEX]), WAVENUMBER)
