"""Which cycle of the carrier a path difference lies in: about where by the envelopes, then exactly by the phase.

At 20.5 kHz a cycle is 16.7 mm of path. Of a phone held still every candidate is asked by itself, with the beeps'
noise averaged away; where a trajectory is followed over beeps, no cycle needs to be chosen (`carrier_phase`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled

CYCLES = np.arange(-4, 5)
"""Around the one nearest to the envelopes' difference."""
OVERLAP_STD_M = 0.0035
"""Deviation of the envelopes' difference by what is not noise, as echoes that overlap: 3 to 4 mm over walls and signs
40 dB above it (development split of the suite `ranging`)."""
PHASE_STD_RAD = 0.4
"""The same of the phase: 1 mm there, microphones that look past each other's near field included."""
BEYOND_STD_M = 0.003
"""How far a difference may pass that of a thing straight ahead at the phone's height: 2 degrees of pitch."""
SURE = 0.5
"""Posterior of the likeliest cycle below which the envelopes are left to say what they say."""


class DifferenceReadings(NamedTuple):
    """What is read of n path differences, path 2 - path 1.

    Attributes:
        envelope_m, envelope_std_m: (n,) by the envelopes, and its deviation; NaN where microphone 1 receives nothing.
        phase_rad, phase_std_rad: (n,) of microphone 1 over microphone 0, freed of what its channel adds, and its
            deviation; NaN where it has no information.
        cycle_m: wavelength at the profile's reference frequency.
    """

    envelope_m: Floats
    envelope_std_m: Floats
    phase_rad: Floats
    phase_std_rad: Floats
    cycle_m: float


def within_cycle(readings: DifferenceReadings, longest_m: Floats) -> tuple[Floats, Floats]:
    """Path differences by phase in the likeliest cycle, and their deviations, the chance of other cycles included.

    Cycles are weighed by the envelopes and by what is possible: nothing at the phone's height is further behind at
    microphone 1 than straight ahead. Where none is likelier than the sum of all others, the envelopes' values stay.

    Args:
        readings: of n candidates.
        longest_m: (n,) path 2 - path 1 straight ahead.

    Returns:
        (n,) path differences and (n,) deviations.
    """
    return likeliest_cycle(readings, _weights(readings, longest_m))


@compiled
def nearest_place(phase_rad: float, envelope_m: float, cycle_m: float) -> float:
    """Path difference of that phase that is nearest to the envelopes'."""
    off = -phase_rad / (2.0 * np.pi) * cycle_m - envelope_m
    return envelope_m + off - cycle_m * float(np.round(off / cycle_m))


@compiled
def likeliest_cycle(readings: DifferenceReadings, weight: Floats) -> tuple[Floats, Floats]:
    """(n,) path differences and (n,) deviations by weights (n, len(CYCLES)) of the cycles, of any sum."""
    u_m, std_m = readings.envelope_m.copy(), readings.envelope_std_m.copy()
    per_rad = readings.cycle_m / (2.0 * np.pi)
    for row in range(len(u_m)):
        best = np.argmax(weight[row])
        total = np.sum(weight[row])
        if not weight[row, best] > SURE * total:
            continue
        nearest = nearest_place(readings.phase_rad[row], readings.envelope_m[row], readings.cycle_m)
        other = np.sum(weight[row] * (readings.cycle_m * (CYCLES - CYCLES[best])) ** 2) / total
        u_m[row] = nearest + readings.cycle_m * CYCLES[best]
        std_m[row] = np.sqrt(other + (per_rad * readings.phase_std_rad[row]) ** 2)
    return u_m, std_m


@compiled
def _weights(readings: DifferenceReadings, longest_m: Floats) -> Floats:
    """(n, len(CYCLES)) likelihoods of the cycles; NaN stays NaN."""
    weight = np.empty((len(longest_m), len(CYCLES)))
    for row in range(len(longest_m)):
        middle = readings.envelope_m[row]
        nearest = nearest_place(readings.phase_rad[row], middle, readings.cycle_m)
        for column, cycles in enumerate(CYCLES):
            place = nearest + readings.cycle_m * cycles
            distance = (place - middle) / readings.envelope_std_m[row]
            beyond = (place - longest_m[row]) / BEYOND_STD_M
            beyond = beyond if beyond > 0.0 else 0.0
            weight[row, column] = np.exp(-0.5 * (distance * distance + beyond * beyond))
    return weight
