"""Absorption of air against ISO 9613-1, coded a second time from its annex A: per relaxation, not equation (5)."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.gates.physics.measured import Measured
from simulator import Air

CLIMATES = [(t, h) for t in (-10.0, 0.0, 10.0, 20.0, 30.0, 40.0) for h in (0.1, 0.3, 0.5, 0.9)]
FREQUENCY_HZ = np.linspace(15_000.0, 25_000.0, 11)
OXYGEN, NITROGEN = (2239.1, 0.209), (3352.0, 0.781)
"""Characteristic temperature of vibration, K, and mole fraction (annex A)."""


def air_error_db_m(seed: int) -> Measured:
    """Greatest difference over climates, 15-25 kHz. Nothing is random: the seed is not used."""
    del seed
    differences = [
        np.abs(Air(t, h).absorption_db_m(FREQUENCY_HZ) - iso_9613_1_db_m(FREQUENCY_HZ, t + 273.15, 100.0 * h))
        for t, h in CLIMATES
    ]
    return Measured(float(np.max(differences)), "dB/m", len(CLIMATES) * len(FREQUENCY_HZ))


def iso_9613_1_db_m(frequency_hz: np.ndarray, temperature_k: float, humidity_percent: float) -> np.ndarray:
    """(F,) attenuation at one standard atmosphere: classical and rotational, and two relaxations per wavelength."""
    warm = temperature_k / 293.15
    water = humidity_percent * 10.0 ** (4.6151 - 6.8346 * (273.16 / temperature_k) ** 1.261)
    relaxation_oxygen = 24.0 + 4.04e4 * water * (0.02 + water) / (0.391 + water)
    relaxation_nitrogen = warm**-0.5 * (9.0 + 280.0 * water * np.exp(-4.170 * (warm ** (-1.0 / 3.0) - 1.0)))
    speed = 343.2 * np.sqrt(warm)
    total = 15.895e-11 * warm**0.5 * frequency_hz**2
    for (vibration_k, fraction), relaxation in ((OXYGEN, relaxation_oxygen), (NITROGEN, relaxation_nitrogen)):
        excited = (vibration_k / temperature_k) ** 2 * np.exp(-vibration_k / temperature_k)
        per_wavelength = 2.0 * np.pi / 35.0 * 20.0 * np.log10(math.e) * fraction * excited
        ratio = frequency_hz / relaxation
        total += per_wavelength * frequency_hz / speed * 2.0 * ratio / (1.0 + ratio**2)
    return total
