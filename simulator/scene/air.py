"""Air: speed of sound and absorption at a temperature, humidity and pressure.

Speed: an ideal mixture of dry air and water vapour, c^2 = gamma R T / M with constant molar heats. Over 0-30 C it stays
0.01-0.06 m/s below the polynomial of Cramer (1993, JASA 93, 2510-2516), which holds there only and claims 0.1 m/s.
Absorption: ISO 9613-1:1993, equations (3) to (5), its validity (section 7) enforced.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.argument_types import as_floats, as_number, check_types, hold_numbers
from obstaclewatch.support.arrays import Floats

KELVIN = 273.15
GAS_CONSTANT_J_MOL_K = 8.314462618
DRY_AIR_KG_MOL, WATER_KG_MOL = 0.028_965_46, 0.018_015_28
DRY_AIR_HEAT, WATER_HEAT = 3.496, 4.04  # molar heat at constant pressure over the gas constant, near 20 C
REFERENCE_TEMPERATURE_K = 293.15  # T0 of ISO 9613-1, 4.2
REFERENCE_PRESSURE_PA = 101_325.0  # p_r of ISO 9613-1, 4.2
TRIPLE_POINT_K = 273.16  # T01 of ISO 9613-1, annex B

TEMPERATURE_RANGE_C = (-73.0, 60.0)  # the standard's 200 K, and 10 K above its 323.15 K
MAX_PRESSURE_PA = 200_000.0
FIXED_SPEED_M_S = (1.0, 10_000.0)  # nothing that sound passes is as slow; solids come to the other end
FREQUENCY_TO_PRESSURE_HZ_PA = (4e-4, 10.0)


@dataclass(frozen=True)
class Air:
    """A homogeneous atmosphere at rest.

    ISO 9613-1 claims its absorption to 10 % from -20 to 50 C with 0.05 to 5 % of water vapour, to 20 % outside that
    humidity, and to 50 % down to -73 C. Its formulas are accepted here up to 60 C: beyond 50 C they are extrapolated,
    and no accuracy is claimed.

    Attributes:
        temperature_c: -73 to 60.
        relative_humidity: fraction, 0 to 1.
        pressure_pa: above 0, below 200 kPa, and above the vapour pressure.
        fixed_sound_speed_m_s: replaces the speed that follows from the other three, 1 to 10,000; None derives it.
        absorbs: False sets the absorption to exactly zero.

    Raises:
        ValueError: what is not a number, or one outside its range.

    Example:
        >>> from simulator import Air
        >>> air = Air(temperature_c=20.0, relative_humidity=0.5)
        >>> print(f"{air.sound_speed_m_s:.2f} m/s, {air.absorption_db_m(20e3):.2f} dB/m at 20 kHz")
        343.94 m/s, 0.52 dB/m at 20 kHz
    """

    temperature_c: float = 20.0
    relative_humidity: float = 0.5
    pressure_pa: float = REFERENCE_PRESSURE_PA
    fixed_sound_speed_m_s: float | None = None
    absorbs: bool = True

    def __post_init__(self) -> None:
        hold_numbers(self, "temperature_c", "relative_humidity", "pressure_pa")
        if self.fixed_sound_speed_m_s is not None:
            hold_numbers(self, "fixed_sound_speed_m_s")
        check_types(absorbs=(self.absorbs, bool))
        low, high = TEMPERATURE_RANGE_C
        if not low <= self.temperature_c <= high:
            raise ValueError(f"temperature_c must be {low} to {high} (ISO 9613-1, 7), got {self.temperature_c}")
        if not 0.0 <= self.relative_humidity <= 1.0:
            raise ValueError(f"relative_humidity must be a fraction from 0 to 1, got {self.relative_humidity}")
        if not 0.0 < self.pressure_pa < MAX_PRESSURE_PA:
            raise ValueError(f"pressure_pa must be above 0 and below {MAX_PRESSURE_PA:g}, got {self.pressure_pa}")
        if self.vapour_fraction >= 1.0:
            raise ValueError(
                f"pressure_pa must exceed the vapour pressure, got {self.pressure_pa} "
                f"against {self.vapour_fraction * self.pressure_pa:.0f}"
            )
        speed = self.fixed_sound_speed_m_s
        low, high = FIXED_SPEED_M_S
        if speed is not None and not (np.isfinite(speed) and speed > 0.0):
            raise ValueError(f"fixed_sound_speed_m_s must be positive, got {speed}")
        if speed is not None and not low <= speed <= high:
            raise ValueError(f"fixed_sound_speed_m_s must be {low:g} to {high:g}, got {speed}")

    @classmethod
    def lossless(cls, sound_speed_m_s: float = 343.0) -> Air:
        """Air of exactly that speed that absorbs nothing: for checks against exact solutions."""
        return cls(fixed_sound_speed_m_s=float(as_number("sound_speed_m_s", sound_speed_m_s)), absorbs=False)

    @property
    def temperature_k(self) -> float:
        """Absolute temperature, K."""
        return self.temperature_c + KELVIN

    @property
    def vapour_fraction(self) -> float:
        """Molar fraction of water vapour, 0 to 1 (ISO 9613-1, equations B.1 to B.3)."""
        exponent = -6.8346 * (TRIPLE_POINT_K / self.temperature_k) ** 1.261 + 4.6151
        return self.relative_humidity * 10.0**exponent * REFERENCE_PRESSURE_PA / self.pressure_pa

    @property
    def sound_speed_m_s(self) -> float:
        """Speed of sound, m/s; 343.94 at 20 C, 50 % and sea level."""
        if self.fixed_sound_speed_m_s is not None:
            return self.fixed_sound_speed_m_s
        water = self.vapour_fraction
        molar_mass = (1.0 - water) * DRY_AIR_KG_MOL + water * WATER_KG_MOL
        heat = (1.0 - water) * DRY_AIR_HEAT + water * WATER_HEAT
        return float(np.sqrt(heat / (heat - 1.0) * GAS_CONSTANT_J_MOL_K * self.temperature_k / molar_mass))

    def absorption_db_m(self, frequency_hz: ArrayLike) -> Floats:
        """Attenuation of a pure tone, dB/m, at any array of frequencies (ISO 9613-1, equation 5).

        Raises:
            ValueError: a frequency outside 4e-4 to 10 Hz per pascal (41 Hz to 1.01 MHz at sea level), where the
                standard does not hold. Air that absorbs nothing takes any frequency.
        """
        frequency = as_floats("frequency_hz", frequency_hz)
        if not self.absorbs:
            return np.zeros_like(frequency)
        _check_frequency(frequency, self.pressure_pa)
        return _iso_9613_absorption_db_m(frequency, self.temperature_k, self.vapour_fraction, self.pressure_pa)


def _iso_9613_absorption_db_m(
    frequency_hz: Floats, temperature_k: float, vapour_fraction: float, pressure_pa: float
) -> Floats:
    temperature = temperature_k / REFERENCE_TEMPERATURE_K
    pressure = pressure_pa / REFERENCE_PRESSURE_PA
    h = 100.0 * vapour_fraction  # the standard counts in per cent
    squared = frequency_hz**2
    oxygen_hz = pressure * (24.0 + 4.04e4 * h * (0.02 + h) / (0.391 + h))  # (3)
    cooling = np.exp(-4.170 * (temperature ** (-1.0 / 3.0) - 1.0))
    nitrogen_hz = pressure / np.sqrt(temperature) * (9.0 + 280.0 * h * cooling)  # (4)
    classical = 1.84e-11 / pressure * np.sqrt(temperature)
    oxygen = 0.01275 * np.exp(-2239.1 / temperature_k) / (oxygen_hz + squared / oxygen_hz)
    nitrogen = 0.1068 * np.exp(-3352.0 / temperature_k) / (nitrogen_hz + squared / nitrogen_hz)
    return 8.686 * squared * (classical + temperature**-2.5 * (oxygen + nitrogen))  # (5)


def _check_frequency(frequency_hz: Floats, pressure_pa: float) -> None:
    low, high = (limit * pressure_pa for limit in FREQUENCY_TO_PRESSURE_HZ_PA)
    bad = ~((frequency_hz >= low) & (frequency_hz <= high))
    if bad.any():
        raise ValueError(
            f"frequency_hz must be {low:.1f} to {high:.0f} at {pressure_pa:g} Pa (ISO 9613-1, 7), "
            f"got {frequency_hz[bad].flat[0]:g}"
        )
