"""Absorption of air against ISO 9613-1, coded a second time from its annex A: per relaxation, not equation (5)."""

from __future__ import annotations

import numpy as np

from benchmarks.cells.probes.extremes.air import iso_9613_1_db_m
from benchmarks.gates.physics.measured import Measured
from simulator import Air

CLIMATES = [(t, h) for t in (-10.0, 0.0, 10.0, 20.0, 30.0, 40.0) for h in (0.1, 0.3, 0.5, 0.9)]
FREQUENCY_HZ = np.linspace(15_000.0, 25_000.0, 11)


def air_error_db_m(seed: int) -> Measured:
    """Greatest difference over climates, 15-25 kHz. Nothing is random: the seed is not used."""
    del seed
    differences = [
        np.abs(Air(t, h).absorption_db_m(FREQUENCY_HZ) - iso_9613_1_db_m(FREQUENCY_HZ, t + 273.15, 100.0 * h))
        for t, h in CLIMATES
    ]
    return Measured(float(np.max(differences)), "dB/m", len(CLIMATES) * len(FREQUENCY_HZ))
