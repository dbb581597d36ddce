"""The speed of sound that a detector may assume when it is given the weather.

That of a sonic anemometer (Kaimal and Gaynor 1991, Boundary-Layer Meteorol. 56:401-410), with the vapour pressure e by
Magnus' formula: c^2 = 1.4 R T (1 + 0.32 e / p). Against the ideal gas of ISO 9613's air, at any humidity: within 0.03 %
from 0 to 30 C (0.02 % at 20 C and 50 %: 1 mm at 5 m), 0.05 % from -20 to 40 C, 0.3 % from -40 to 60 C.
"""

from __future__ import annotations

import math

from obstaclewatch.support.argument_types import as_numbers

DRY_AIR_J_KG_K = 287.05
KELVIN = 273.15


def assumed_sound_speed(temperature_c: float, relative_humidity: float = 0.5, pressure_pa: float = 101_325.0) -> float:
    """Speed of sound in air, m/s.

    Args:
        temperature_c: of the air, -80 to 70 degrees Celsius.
        relative_humidity: fraction, 0 to 1.
        pressure_pa: of the air, 10 to 200 kPa.

    Raises:
        ValueError: a value out of range.

    >>> print(f"{assumed_sound_speed(20.0):.1f} m/s at 20 C, {assumed_sound_speed(0.0):.1f} m/s at 0 C")
    343.9 m/s at 20 C, 331.5 m/s at 0 C
    """
    temperature_c, relative_humidity, pressure_pa = as_numbers(
        temperature_c=temperature_c, relative_humidity=relative_humidity, pressure_pa=pressure_pa
    )
    if not -80.0 <= temperature_c <= 70.0:
        raise ValueError(f"temperature_c must lie within -80..70, got {temperature_c}")
    if not 0.0 <= relative_humidity <= 1.0:
        raise ValueError(f"relative_humidity must lie within 0..1, got {relative_humidity}")
    if not 1e4 <= pressure_pa <= 2e5:
        raise ValueError(f"pressure_pa must lie within 10000..200000 Pa, got {pressure_pa}")
    vapour_pa = relative_humidity * 611.2 * math.exp(17.62 * temperature_c / (243.12 + temperature_c))
    moist = 1.0 + 0.32 * vapour_pa / pressure_pa
    return math.sqrt(1.4 * DRY_AIR_J_KG_K * (temperature_c + KELVIN) * moist)
