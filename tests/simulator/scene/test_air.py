"""Air against the table of ISO 9613-1, an independent coding of it, Cramer's formula, and limits."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simulator.scene.air import Air

# ISO 9613-1:1993, table 1: temperature C, relative humidity %, nominal frequency Hz, dB/km. The table is computed at
# exact third-octave frequencies 1000 * 10^(k/10) and printed to three figures.
TABLE_1 = [
    (-20, 10, 1000, 1.65), (-20, 70, 8000, 27.8), (-10, 10, 8000, 14.2), (-10, 70, 8000, 86.2), (0, 10, 1000, 14.0),
    (0, 10, 8000, 26.4), (0, 100, 1000, 3.37), (10, 10, 8000, 69.4), (10, 70, 4000, 32.8), (15, 10, 4000, 87.3),
    (20, 10, 4000, 109.0), (20, 15, 6300, 175.0), (20, 50, 125, 0.445), (20, 70, 1000, 4.98), (20, 80, 10000, 105.0),
    (25, 100, 1000, 6.47), (30, 70, 4000, 23.1), (40, 10, 1000, 7.68), (50, 10, 8000, 155.0), (50, 70, 8000, 80.3),
]  # fmt: skip


def exact_midband_hz(nominal_hz: float) -> float:
    return 1000.0 * 10.0 ** (round(10.0 * math.log10(nominal_hz / 1000.0)) / 10.0)


def iso_9613_1_by_hand(frequency_hz: float, temperature_k: float, humidity_percent: float, pressure_kpa: float):
    """dB/m, coded from relaxation strengths and loss per wavelength (annex A), not from equation (5)."""
    t, p = temperature_k / 293.15, pressure_kpa / 101.325
    h = humidity_percent * 10.0 ** (4.6151 - 6.8346 * (273.16 / temperature_k) ** 1.261) / p
    relaxation_o = p * (24.0 + 4.04e4 * h * (0.02 + h) / (0.391 + h))
    relaxation_n = p * t**-0.5 * (9.0 + 280.0 * h * math.exp(-4.170 * (t ** (-1.0 / 3.0) - 1.0)))
    speed = 343.2 * math.sqrt(t)
    classical_and_rotational = 15.895e-11 * t**0.5 * frequency_hz**2 / p
    total = classical_and_rotational
    for theta, mole_fraction, relaxation in ((2239.1, 0.209, relaxation_o), (3352.0, 0.781, relaxation_n)):
        strength = 2.0 * math.pi / 35.0 * 10.0 * math.log10(math.e**2)
        per_wavelength = strength * mole_fraction * (theta / temperature_k) ** 2 * math.exp(-theta / temperature_k)
        ratio = frequency_hz / relaxation
        total += per_wavelength * frequency_hz / speed * 2.0 * ratio / (1.0 + ratio**2)
    return total


def cramer_1993_m_s(t: float, humidity: float, p: float = 101_325.0, carbon: float = 4e-4) -> float:
    """Equation (15) of O. Cramer, JASA 93 (1993) 2510, valid over 0-30 C."""
    kelvin = t + 273.15
    enhancement = 1.00062 + 3.14e-8 * p + 5.6e-7 * t**2
    vapour_pa = math.exp(1.2811805e-5 * kelvin**2 - 1.9509874e-2 * kelvin + 34.04926034 - 6.3536311e3 / kelvin)
    x = humidity * enhancement * vapour_pa / p
    return (
        331.5024 + 0.603055 * t - 0.000528 * t**2
        + (51.471935 + 0.1495874 * t - 0.000782 * t**2) * x
        + (-1.82e-7 + 3.73e-8 * t - 2.93e-10 * t**2) * p
        + (-85.20931 - 0.228525 * t + 5.91e-5 * t**2) * carbon
        - 2.835149 * x**2 - 2.15e-13 * p**2 + 29.179762 * carbon**2 + 0.000486 * x * p * carbon
    )  # fmt: skip


@pytest.mark.parametrize(("temperature_c", "humidity_percent", "nominal_hz", "table_db_km"), TABLE_1)
def test_table_of_the_standard(temperature_c, humidity_percent, nominal_hz, table_db_km):
    got = 1000.0 * Air(temperature_c, humidity_percent / 100.0).absorption_db_m(exact_midband_hz(nominal_hz))
    assert float(f"{got:.3g}") == pytest.approx(table_db_km, rel=0.0051)  # one unit of the third figure, at most


@pytest.mark.parametrize("frequency_hz", [18_000.0, 20_500.0, 23_000.0])
@pytest.mark.parametrize(("temperature_c", "humidity"), [(-10, 0.8), (5, 0.3), (20, 0.5), (35, 0.2), (40, 0.9)])
def test_independent_coding_in_the_beep_band(frequency_hz, temperature_c, humidity):
    got = Air(temperature_c, humidity, 95_000.0).absorption_db_m(frequency_hz)
    by_hand = iso_9613_1_by_hand(frequency_hz, temperature_c + 273.15, 100.0 * humidity, 95.0)
    assert got == pytest.approx(by_hand, abs=1e-3)


def test_quoted_values():
    np.testing.assert_allclose(Air().absorption_db_m([18e3, 20.5e3, 23e3]), [0.443, 0.545, 0.648], atol=5e-4)
    assert Air().sound_speed_m_s == pytest.approx(343.94, abs=0.005)


@pytest.mark.parametrize("temperature_c", [0, 10, 20, 30])
@pytest.mark.parametrize("humidity", [0.0, 0.5, 1.0])
def test_speed_against_cramer(temperature_c, humidity):
    # Cramer claims 300 ppm, 0.1 m/s
    got = Air(temperature_c, humidity).sound_speed_m_s
    assert got == pytest.approx(cramer_1993_m_s(temperature_c, humidity), abs=0.06)


def test_dry_air_speed_goes_like_the_root_of_temperature():
    cold, warm = Air(-40.0, 0.0), Air(60.0, 0.0)
    assert warm.sound_speed_m_s / cold.sound_speed_m_s == pytest.approx(math.sqrt(333.15 / 233.15), rel=1e-12)


@settings(max_examples=50)
@given(st.floats(-40, 60), st.floats(0, 1), st.floats(60e3, 110e3))
def test_every_climate_is_finite_and_ordered(temperature_c, humidity, pressure_pa):
    air = Air(temperature_c, humidity, pressure_pa)
    absorption = air.absorption_db_m(np.linspace(15e3, 25e3, 11))
    assert 300.0 < air.sound_speed_m_s < 390.0
    assert (absorption > 0.0).all()
    assert (np.diff(absorption) > 0.0).all()
    assert air.sound_speed_m_s >= Air(temperature_c, 0.0, pressure_pa).sound_speed_m_s


def test_lossless_air_is_exact():
    air = Air.lossless(340.25)
    assert air.sound_speed_m_s == 340.25
    np.testing.assert_array_equal(air.absorption_db_m([0.0, 2e4, 1e7]), 0.0)
    assert Air.lossless().sound_speed_m_s == 343.0


def test_shape_is_kept():
    assert Air().absorption_db_m(20e3).shape == ()
    assert Air().absorption_db_m(np.full((3, 1, 4), 20e3)).shape == (3, 1, 4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"temperature_c": 60.1}, "temperature_c must be -73.0 to 60.0.*got 60.1"),
        ({"temperature_c": float("nan")}, "temperature_c.*got nan"),
        ({"relative_humidity": 50.0}, "relative_humidity must be a fraction from 0 to 1, got 50.0"),
        ({"pressure_pa": 0.0}, "pressure_pa must be above 0.*got 0.0"),
        ({"temperature_c": 60.0, "relative_humidity": 1.0, "pressure_pa": 15_000.0}, "vapour pressure, got 15000.0"),
        ({"fixed_sound_speed_m_s": -1.0}, "fixed_sound_speed_m_s must be positive, got -1.0"),
        ({"fixed_sound_speed_m_s": 1e300}, r"fixed_sound_speed_m_s must be 1 to 10000, got 1e\+300"),
        ({"fixed_sound_speed_m_s": 1e-300}, "fixed_sound_speed_m_s must be 1 to 10000, got 1e-300"),
    ],
)
def test_bad_air_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        Air(**arguments)


@pytest.mark.parametrize("frequency_hz", [0.0, 40.0, 1.02e6, float("nan")])
def test_frequency_outside_the_standard_is_refused(frequency_hz):
    rule = f"frequency_hz must be 40.5 to 1013250 at 101325 Pa (ISO 9613-1, 7), got {frequency_hz:g}"
    with pytest.raises(ValueError, match=re.escape(rule)):
        Air().absorption_db_m([20e3, frequency_hz])
