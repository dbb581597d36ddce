"""Air against formulas of other sources: heats by temperature, Buck's vapour pressure, ISO 9613-1 by relaxations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.cells.probes.extremes.mirrors import AHEAD, against, echoes, image_lengths_m, wall
from benchmarks.cells.probes.extremes.verdict import LEVEL_DB, Error, Errors
from obstaclewatch.support.arrays import Floats
from simulator import Air, Pose

OXYGEN, NITROGEN = (2239.1, 0.209), (3352.0, 0.781)
"""Characteristic temperature of vibration, K, and mole fraction (ISO 9613-1, annex A)."""
HEAT_K, AIR_J_KG_K, WATER_J_KG_K = (250.0, 300.0, 350.0), (1003.0, 1005.0, 1008.0), (1852.0, 1864.0, 1880.0)
AIR_KG_MOL, WATER_KG_MOL, GAS_J_MOL_K = 28.9655e-3, 18.0153e-3, 8.31446
SPEED_SHARE = 1e-3
"""The tables' last digit is 1e-3 of a heat, 2e-4 of the speed; the simulator's heats do not change with temperature."""
GAIN_HZ = 20_000.0


def weather(temperature_c: float, relative_humidity: float) -> Errors:
    """A wall at 3 m in real air: its speed of sound, its absorption, and the echo of both."""
    air = Air(temperature_c=temperature_c, relative_humidity=relative_humidity)
    speed = sound_speed_m_s(temperature_c, relative_humidity)
    loss = iso_9613_1_db_m(GAIN_HZ, temperature_c + 273.15, 100.0 * relative_humidity)
    length = image_lengths_m(3.0)
    found = echoes([wall(3.0)], Pose(np.zeros(3), AHEAD), 9.0, air=air)
    level = 10.0 ** (-loss * length.astype(np.float64) / 20.0) / length
    return against(found, [0, 1], length, level, air.sound_speed_m_s) | {
        "speed": Error(air.sound_speed_m_s / speed - 1.0, SPEED_SHARE),
        "absorption_db_m": Error(float(air.absorption_db_m(GAIN_HZ) - loss), 0.1 * LEVEL_DB),
    }


def sound_speed_m_s(temperature_c: float, relative_humidity: float) -> float:
    """c^2 = gamma R T / M of air and water vapour: heats of Cengel and Boles, table A-2b, vapour after Buck (1981)."""
    kelvin = temperature_c + 273.15
    saturated_pa = 611.21 * math.exp((18.678 - temperature_c / 234.5) * temperature_c / (257.14 + temperature_c))
    water = relative_humidity * saturated_pa / 101_325.0
    air_heat, water_heat = (float(np.interp(kelvin, HEAT_K, heats)) for heats in (AIR_J_KG_K, WATER_J_KG_K))
    heat = (1.0 - water) * air_heat * AIR_KG_MOL + water * water_heat * WATER_KG_MOL
    kg_mol = (1.0 - water) * AIR_KG_MOL + water * WATER_KG_MOL
    return math.sqrt(heat / (heat - GAS_J_MOL_K) * GAS_J_MOL_K * kelvin / kg_mol)


def iso_9613_1_db_m(frequency_hz: ArrayLike, temperature_k: float, humidity_percent: float) -> Floats:
    """(F,) attenuation at one standard atmosphere: classical and rotational, and two relaxations per wavelength."""
    frequency = np.asarray(frequency_hz, dtype=np.float64)
    warm = temperature_k / 293.15
    water = humidity_percent * 10.0 ** (4.6151 - 6.8346 * (273.16 / temperature_k) ** 1.261)
    relaxation_oxygen = 24.0 + 4.04e4 * water * (0.02 + water) / (0.391 + water)
    relaxation_nitrogen = warm**-0.5 * (9.0 + 280.0 * water * np.exp(-4.170 * (warm ** (-1.0 / 3.0) - 1.0)))
    speed = 343.2 * np.sqrt(warm)
    total = 15.895e-11 * warm**0.5 * frequency**2
    for (vibration_k, fraction), relaxation in ((OXYGEN, relaxation_oxygen), (NITROGEN, relaxation_nitrogen)):
        excited = (vibration_k / temperature_k) ** 2 * np.exp(-vibration_k / temperature_k)
        per_wavelength = 2.0 * np.pi / 35.0 * 20.0 * np.log10(math.e) * fraction * excited
        ratio = frequency / relaxation
        total = total + per_wavelength * frequency / speed * 2.0 * ratio / (1.0 + ratio**2)
    return np.asarray(total)
