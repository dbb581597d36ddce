"""The detector's own speed of sound against Cramer's polynomial (1993, JASA 93:2510-2516, equation 15), written out."""

import numpy as np
import pytest

from obstaclewatch.sound_speed import assumed_sound_speed


def cramer(temperature_c, humidity, pressure_pa=101_325.0, carbon_dioxide=4e-4):
    t, kelvin, p, xc = temperature_c, temperature_c + 273.15, pressure_pa, carbon_dioxide
    enhancement = 1.00062 + 3.14e-8 * p + 5.6e-7 * t**2
    saturated = np.exp(1.2811805e-5 * kelvin**2 - 1.9509874e-2 * kelvin + 34.04926034 - 6.3536311e3 / kelvin)
    xw = humidity * enhancement * saturated / p
    return (
        331.5024 + 0.603055 * t - 0.000528 * t**2
        + (51.471935 + 0.1495874 * t - 0.000782 * t**2) * xw
        + (-1.82e-7 + 3.73e-8 * t - 2.93e-10 * t**2) * p
        + (-85.20931 - 0.228525 * t + 5.91e-5 * t**2) * xc
        - 2.835149 * xw**2 - 2.15e-13 * p**2 + 29.179762 * xc**2 + 0.000486 * xw * p * xc
    )  # fmt: skip


@pytest.mark.parametrize("humidity", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("temperature_c", [0.0, 10.0, 20.0, 30.0])
def test_within_a_thousandth_of_cramer(temperature_c, humidity):
    assert assumed_sound_speed(temperature_c, humidity) == pytest.approx(cramer(temperature_c, humidity), rel=5e-4)


def test_warmth_and_moisture_speed_it_up_and_pressure_matters_by_moisture_alone():
    assert assumed_sound_speed(-20.0) < assumed_sound_speed(0.0) < assumed_sound_speed(40.0)
    assert assumed_sound_speed(20.0, 0.0) < assumed_sound_speed(20.0, 1.0)
    assert assumed_sound_speed(20.0, 0.0, 8e4) == assumed_sound_speed(20.0, 0.0, 1e5)


@pytest.mark.parametrize(
    ("values", "message"),
    [((90.0,), "temperature_c must .* got 90"), ((20.0, 50.0), "relative_humidity must .* got 50"),
     ((20.0, 0.5, 0.0), "pressure_pa must .* got 0"), ((float("nan"),), "temperature_c must .* got nan")],
)  # fmt: skip
def test_out_of_range(values, message):
    with pytest.raises(ValueError, match=message):
        assumed_sound_speed(*values)
