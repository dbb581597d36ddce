"""Echoes of rigid cylinders against the exact wavenumber integral, stored by tests/references/make_cylinder_values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from simulator.field.gains import bending_phase
from tests.references import chirp, meshes, rigid_cylinder, traced

C = traced.SPEED_M_S
HEIGHT_M = 3.0  # both ends are far outside the mirror zone, and the edges of the ends are not modelled here


@pytest.fixture(scope="module")
def stored():
    with np.load(Path(rigid_cylinder.__file__).with_name("cylinder_values.npz")) as values:
        return {name: values[name] for name in values.files}


def _differences(stored, mesh, radius, factor=1.0):
    row = int(np.flatnonzero(stored["radius_m"] == radius)[0])
    found = traced.echoes(mesh, stored["source_m"][row], stored["receiver_m"][row])
    out = traced.differences(found, stored["transfer"][row] / factor)
    assert len(out) == 12
    return out


def _capped(radius, segments):
    return trimesh.creation.cylinder(radius, HEIGHT_M, sections=segments)


def test_stored_values_are_those_of_the_integral(stored):
    for row, position, mic in ((1, 0, 0), (4, 2, 1)):
        again = rigid_cylinder.scattered(
            stored["radius_m"][row], stored["source_m"][row, position], stored["receiver_m"][row, position, mic],
            stored["frequency_hz"][:1], C,
        )  # fmt: skip
        np.testing.assert_allclose(again, stored["transfer"][row, position, mic, :1], rtol=1e-9)
    np.testing.assert_array_equal(stored["frequency_hz"], chirp.nodes_hz())


@pytest.mark.parametrize("height", [0.0, 0.15, 0.4])
def test_integral_does_not_let_the_surface_move(height):
    # sources and points at different heights are what betrays a contour across creeping-wave poles
    radius, source, step = 0.1, np.array([0.6, 0.0, 0.0]), 1e-5
    k = 2.0 * np.pi * 20_000.0 / C

    def pressures(distance):
        x = np.array([distance * np.cos(0.2), distance * np.sin(0.2), height])
        leg = np.linalg.norm(x - source)
        return np.array([np.exp(-1j * k * leg) / leg, rigid_cylinder.scattered(radius, source, x, [20_000.0], C)[0]])

    slope = (pressures(radius + step) - pressures(radius - step)) / (2.0 * step)
    assert abs(slope[0]) > 100.0
    assert abs(slope.sum()) < 1e-6 * abs(slope[0])  # (k step)^2 / 6 of the central difference


@pytest.mark.parametrize("radius", [0.15, 0.25, 0.35])
@pytest.mark.parametrize("segments", [32, 64])
def test_large_cylinders_meet_the_target(stored, radius, segments):
    worst = traced.worst(_differences(stored, _capped(radius, segments), radius))
    assert worst.level_db <= 0.1
    assert worst.delay_samples <= 0.07
    assert worst.correlation >= 0.999


@pytest.mark.parametrize("radius", [0.05, 0.1])
def test_thin_cylinders_meet_the_target(stored, radius):
    worst = traced.worst(_differences(stored, _capped(radius, 32), radius))
    assert worst.level_db <= 0.1
    assert worst.delay_samples <= 0.15


@pytest.mark.parametrize("rows", [1, 2, 12])
def test_irregular_triangles_cost_nothing_on_a_cylinder(stored, rows, rng):
    mesh = meshes.tube(0.25, HEIGHT_M, 32, rows, rng=rng)
    worst = traced.worst(_differences(stored, mesh, 0.25))
    assert worst.level_db <= 0.02  # the target for surfaces in general is 0.5 dB rms
    assert worst.delay_samples <= 0.07


def test_level_does_not_depend_on_the_number_of_facets(stored):
    level = [[each.level_db for each in _differences(stored, _capped(0.25, n), 0.25)] for n in (16, 48, 512, 4096)]
    assert np.ptp(level, axis=0).max() <= 0.02


@pytest.mark.parametrize("radius", [0.05, 0.1, 0.25])
def test_bending_phase_removes_what_rays_lack(stored, radius):
    wavenumber = 2.0 * np.pi * chirp.nodes_hz() / C
    factor = bending_phase(np.diag([1.0, 0.0, 0.0])[None, None] / radius, wavenumber)[0]
    mesh = _capped(radius, 256)
    with_phase = traced.worst(_differences(stored, mesh, radius))
    without = traced.worst(_differences(stored, mesh, radius, 1.0 / factor))
    assert without.delay_samples > 5.0 * with_phase.delay_samples
    assert with_phase.delay_samples <= 0.003
