"""Echoes of rigid spheres against the exact series: level, time and waveform at the matched filter's peak."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import spherical_jn, spherical_yn

from simulator.field.gains import bending_phase
from tests.references import chirp, meshes, rigid_sphere, traced

C = traced.SPEED_M_S
GAP_M = np.array([0.3, 0.6, 1.5, 3.0, 5.0, 7.0])
MIC_M = np.array([0.05, -0.16])  # on either side of the speaker


def _positions(radius, seed=0):
    rng = np.random.default_rng(seed)
    away, line = rng.normal(size=(2, len(GAP_M), 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    line /= np.linalg.norm(line, axis=1, keepdims=True)
    speaker = (radius + GAP_M)[:, None] * away
    return speaker, speaker[:, None] + MIC_M[:, None] * line[:, None]


def _differences(mesh, radius, factor=1.0, seed=0):
    speaker, mics = _positions(radius, seed)
    exact = rigid_sphere.scattered(radius, speaker[:, None], mics, chirp.nodes_hz(), C)
    found = traced.differences(traced.echoes(mesh, speaker, mics), exact / factor)
    assert len(found) == 2 * len(GAP_M)
    return found


def test_series_coefficients_against_library_functions():
    n, x = np.arange(60), np.array([5.0, 18.3, 42.0])
    derivative = np.array([spherical_jn(n, each, True) for each in x]).T
    hankel = derivative + 1j * np.array([spherical_yn(n, each, True) for each in x]).T
    np.testing.assert_allclose(rigid_sphere.reflection_coefficients(x, 60), derivative / hankel, atol=1e-13)


def test_series_does_not_let_the_surface_move():
    # the normal derivative of incident plus scattered pressure vanishes on a rigid sphere
    radius, source, k = 0.1, np.array([0.9, 0.0, 0.0]), 2.0 * np.pi * 20_000.0 / C
    n = np.arange(rigid_sphere.series_orders(np.array([k * radius]))[0])
    for angle in (0.1, 1.0, 2.5):
        x = radius * np.array([np.cos(angle), np.sin(angle), 0.0])
        distance = np.linalg.norm(x - source)
        along = (x - source) @ x / (radius * distance)
        incident = np.conj((1j * k - 1.0 / distance) * np.exp(1j * k * distance) / distance * along)
        terms = (2 * n + 1) * spherical_jn(n, k * radius, True) * rigid_sphere.hankel(np.array(k * 0.9), len(n))
        scattered = np.conj(-1j * k * k * np.sum(terms * rigid_sphere.legendre(np.array(np.cos(angle)), len(n))))
        assert abs(incident) > 1.0
        assert abs(incident + scattered) < 1e-9 * k / distance


@pytest.mark.parametrize("radius", [0.1, 0.2, 0.5])
def test_large_spheres_meet_the_target(radius):
    for mesh in (meshes.uv_sphere(radius, 32), meshes.icosphere(radius, 3)):
        worst = traced.worst(_differences(mesh, radius))
        assert worst.level_db <= 0.1
        assert worst.delay_samples <= 0.07
        assert worst.correlation >= 0.999


@pytest.mark.parametrize("radius", [0.05, 0.07])
def test_small_spheres_meet_the_target(radius):
    worst = traced.worst(_differences(meshes.icosphere(radius, 3), radius))
    assert worst.level_db <= 0.1
    assert worst.delay_samples <= 0.15


@pytest.mark.parametrize("segments", [24, 32, 64])
def test_irregular_triangles_cost_nothing_on_a_sphere(segments, rng):
    found = _differences(meshes.jittered_sphere(0.15, segments, rng), 0.15)
    rms = np.sqrt(np.mean([each.level_db**2 for each in found]))
    assert rms <= 0.02  # the target for surfaces in general is 0.5 dB
    assert traced.worst(found).delay_samples <= 0.07


def test_rounded_to_float32_and_far_from_the_origin_of_its_file(rng):
    mesh = meshes.icosphere(0.2, 4)
    shift = np.array([20.0, -30.0, 5.0])
    mesh.vertices = (mesh.vertices + shift).astype(np.float32).astype(np.float64) - shift
    assert np.abs(np.linalg.norm(mesh.vertices, axis=1) - 0.2).max() > 1e-7
    worst = traced.worst(_differences(mesh, 0.2))
    assert worst.level_db <= 0.05
    assert worst.correlation >= 0.999


def test_level_does_not_depend_on_the_number_of_facets():
    level = [[each.level_db for each in _differences(meshes.uv_sphere(0.2, n), 0.2)] for n in (16, 32, 96)]
    assert np.ptp(level, axis=0).max() <= 0.02


@pytest.mark.parametrize(("radius", "delay"), [(0.05, 0.01), (0.1, 0.005), (0.4, 0.002)])
def test_bending_phase_removes_what_rays_lack(radius, delay):
    wavenumber = 2.0 * np.pi * chirp.nodes_hz() / C
    sphere = np.diag([1.0, 1.0, 0.0])[None, None] / radius
    mesh = meshes.icosphere(radius, 4)
    with_phase = traced.worst(_differences(mesh, radius))
    without = traced.worst(_differences(mesh, radius, 1.0 / bending_phase(sphere, wavenumber)[0]))
    assert without.delay_samples > 3.0 * with_phase.delay_samples
    assert with_phase.delay_samples <= delay
    assert with_phase.correlation > without.correlation
