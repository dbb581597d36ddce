"""Materials: limits, symmetry, the quoted values, and the roughness loss against a scattering integral."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simulator.scene.materials import Material, limp_sheet_reflection, list_materials

BAND_HZ = np.linspace(15e3, 25e3, 5)


def db(value):
    return 20.0 * np.log10(np.abs(value))


@pytest.mark.parametrize("name", list_materials())
def test_named_materials_are_passive_sourced_and_shaped(name):
    material = Material.named(name)
    reflection = material.reflection(BAND_HZ, np.linspace(0.0, 1.0, 9)[:, None])
    assert material.name == name
    assert material.source
    assert reflection.shape == (9, 5)
    assert reflection.dtype == np.complex128
    assert (np.abs(reflection) <= 1.0 + 1e-12).all()


def test_rigid_is_exactly_one():
    got = Material.rigid().reflection([10.0, 20e3, 1e6], np.array([[0.0], [1e-300], [0.3], [1.0]]))
    np.testing.assert_array_equal(got, np.ones((4, 3)))


@pytest.mark.parametrize("name", ["metal", "glass", "sign-sheet", "plastic"])
def test_sheets_reflect_nearly_everything(name):
    assert (np.abs(Material.named(name).reflection(BAND_HZ, 1.0)) >= 0.998).all()


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [("painted-brick", 0.96, 0.99), ("concrete", 0.96, 0.99), ("brick", 0.87, 0.87), ("clothed-person", 0.56, 0.563)],
)
def test_quoted_levels(name, low, high):
    got = abs(Material.named(name).reflection(20e3, 1.0))
    assert low - 1e-9 <= got <= high + 1e-9


def test_sealed_asphalt_at_85_degrees():
    smooth = Material.uniform("sealed", 0.986)
    assert smooth.reflection(20e3, np.cos(np.radians(85.0))).real == pytest.approx(0.850, abs=5e-4)


@pytest.mark.parametrize(("roughness_mm", "loss_db"), [(0.5, -0.61), (1.0, -2.45), (2.0, -9.8)])
def test_quoted_roughness_loss(roughness_mm, loss_db):
    rough = Material("rough", (15e3, 25e3), (1.0, 1.0), roughness_m=roughness_mm * 1e-3)
    assert db(rough.reflection(20.5e3, 1.0)) == pytest.approx(loss_db, rel=0.01)


def test_roughness_loss_against_an_average_over_heights():
    # slow reference: the coherent field of a surface of Gaussian heights z is the mean of exp(2 j k z cos t)
    roughness, cosine, wavenumber = 0.7e-3, 0.8, 2.0 * np.pi * 20e3 / 343.0
    height = np.linspace(-8.0, 8.0, 4001) * roughness
    weight = np.exp(-0.5 * (height / roughness) ** 2)
    mean = np.sum(weight * np.exp(2j * wavenumber * height * cosine)) / weight.sum()
    rough = Material("rough", (15e3, 25e3), (1.0, 1.0), roughness_m=roughness)
    assert rough.reflection(20e3, cosine) == pytest.approx(mean, abs=1e-12)


def test_limp_sheet_against_the_oblique_mass_law():
    # exact at an angle: jX cos t / (1 + jX cos t); locally reacting agrees to second order in 1 / (X cos t)
    ratio = np.pi * 20e3 * 5.4 / 413.0
    cosine = np.array([1.0, 0.7, 0.3])
    exact = 1j * ratio * cosine / (1.0 + 1j * ratio * cosine)
    assert limp_sheet_reflection(5.4, 20e3) == pytest.approx(exact[0], abs=1e-15)
    np.testing.assert_allclose(Material.named("sign-sheet").reflection(20e3, cosine), exact, atol=(ratio * 0.3) ** -2)


@settings(max_examples=60)
@given(
    st.floats(0.0, 1.0), st.floats(-np.pi, np.pi), st.floats(0.0, 3e-3), st.floats(15e3, 25e3), st.floats(0.0, 1.0)
)  # fmt: skip
def test_no_surface_gains_energy(magnitude, phase, roughness_m, frequency_hz, cosine):
    material = Material.uniform("any", magnitude * np.exp(1j * phase) * (1.0 - 1e-12), roughness_m)
    got = material.reflection(frequency_hz, cosine)
    assert abs(got) <= 1.0 + 1e-9
    assert got == material.reflection(frequency_hz, -cosine)


def test_grazing_turns_the_sign_of_all_but_rigid():
    assert Material.named("concrete").reflection(20e3, 0.0) == -1.0


def test_normal_incidence_returns_the_table():
    material = Material("steps", (15e3, 20e3, 25e3), (0.5, 0.7j, -0.2))
    np.testing.assert_allclose(material.reflection([15e3, 17.5e3, 25e3], 1.0), [0.5, 0.25 + 0.35j, -0.2], atol=1e-15)


def test_equal_by_value_and_after_a_trip_to_a_worker():
    material = Material.named("glass")
    assert pickle.loads(pickle.dumps(material)) == material
    assert hash(Material.rigid()) == hash(Material.rigid())


def test_nan_of_a_rejected_path_passes():
    assert np.isnan(Material.named("brick").reflection(20e3, [np.nan, 0.5])).tolist() == [True, False]


def test_unknown_name_lists_the_known():
    with pytest.raises(ValueError, match=r"asphalt, bark, brick, .* got 'granite'"):
        Material.named("granite")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Material.named("brick").reflection(30e3, 1.0), "table of 'brick', 15000 to 25000, got 30000"),
        (lambda: Material.named("brick").reflection(20e3, 1.1), "cos_incidence must be -1 to 1, got 1.1"),
        (lambda: Material.uniform("loud", 1.01), "normal_reflection of 'loud' must not exceed 1"),
        (lambda: Material.uniform("nan", complex("nan")), "normal_reflection of 'nan' must not exceed 1"),
        (lambda: Material.uniform("rough", 1.0, -1e-3), "roughness_m of 'rough' must not be negative, got -0.001"),
        (lambda: replace(Material.rigid(), uncertainty=np.nan), "uncertainty of 'rigid' must not be negative, got nan"),
        (lambda: Material("short", (15e3, 25e3), (1.0,)), r"one reflection per frequency, got shape \(1,\) for \(2,\)"),
        (lambda: Material("back", (25e3, 15e3), (1.0, 1.0)), "frequency_hz of 'back' must increase"),
    ],
)
def test_bad_material_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("height_m", [0.0, 0.002, 0.02, 0.1, 0.5, 1.5])
@pytest.mark.parametrize("normal_reflection", [0.975, 0.87, 0.4, 0.99 + 0.05j])
def test_a_spherical_wave_reflects_as_the_line_of_complex_images(normal_reflection, height_m):
    """Exact: an image and a line of sources at complex heights (Di and Gilbert, J. Acoust. Soc. Am. 93 (1993) 714-720).

    Cause: what runs along the face of a pillar was taken for plane waves at grazing incidence, which turn their sign.
    """
    wavenumber, along_m = 2.0 * np.pi * 20e3 / 343.0, 2.0
    path_m = np.hypot(along_m, height_m)
    admittance = (1.0 - normal_reflection) / (1.0 + normal_reflection)
    q = np.exp(0.25j * np.pi) * np.linspace(1e-9, 4.0, 400_001)
    distance = np.sqrt(along_m**2 + (height_m - 1j * q) ** 2)
    line = np.exp(-wavenumber * (admittance * q + 1j * (distance - path_m))) * path_m / distance
    exact = 1.0 - 2.0 * wavenumber * admittance * np.trapezoid(line, q)
    material = Material.uniform("uniform", normal_reflection)
    got = material.reflection(20e3, height_m / path_m, wavenumber * path_m)
    assert abs(got - exact) < 1e-3


def test_a_surface_without_pressure_is_the_limit_of_soft_ones():
    """Cause: -1 was divided by 1 + -1, and the echo was dropped as NaN."""
    soft, softest = (
        Material.uniform("soft", value).reflection(20e3, [0.05, 1.0], 700.0) for value in (-0.999999, -1.0)
    )
    np.testing.assert_allclose(softest, soft, atol=1e-4)


def test_plane_waves_are_the_limit_of_long_paths():
    brick = Material.named("brick")
    cosine = np.linspace(0.0, 1.0, 9)[:, None]
    np.testing.assert_array_equal(brick.reflection(BAND_HZ, cosine, np.inf), brick.reflection(BAND_HZ, cosine))
    np.testing.assert_allclose(brick.reflection(20e3, 0.3, 1e6), brick.reflection(20e3, 0.3), atol=1e-5)
    assert Material.rigid().reflection(20e3, 0.0, 700.0) == 1.0
