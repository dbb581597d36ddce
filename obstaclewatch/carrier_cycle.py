"""Which cycle of the carrier a path difference lies in: about where by the envelopes, then exactly by the phase.

At 20.5 kHz a cycle is 16.7 mm of path. Of a phone held still every candidate is asked by itself, with the beeps'
noise averaged away; where a course is followed over beeps, no cycle needs to be chosen (`carrier_phase`).
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from obstaclewatch.carrier_phase import phase_at
from obstaclewatch.matched_filter import EchoProfile

Array = NDArray[np.float64]

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


def phase_between(profile: EchoProfile, delay_s: Array, difference_s: Array) -> Array:
    """(n,) phase of microphone 1's envelope over microphone 0's, rad, at n delays and so much later; NaN stays NaN.

    An echo that reaches microphone 1 by u later has the phase -2 pi reference_hz u, whichever the sample asked.
    """
    position = (delay_s - profile.start_s) * profile.rate_hz
    return _phases(profile.envelope, position, position + difference_s * profile.rate_hz)


@numba.njit(cache=True)
def _phases(envelope: NDArray[np.complex128], position0: Array, position1: Array) -> Array:
    phase = np.full(len(position0), np.nan)
    for row in range(len(position0)):
        if np.isfinite(position1[row]):
            phase[row] = phase_at(envelope, position0[row], position1[row])
    return phase


def within_cycle(
    phase_rad: Array, envelope_m: Array, envelope_std_m: Array, phase_std_rad: Array, longest_m: Array, cycle_m: float
) -> tuple[Array, Array]:
    """Path differences by phase in the likeliest cycle, and their deviations, the chance of other cycles included.

    Cycles are weighed by the envelopes and by what is possible: nothing at the phone's height is further behind at
    microphone 1 than straight ahead. Where none is likelier than all others together, the envelopes' values stay.

    Args:
        phase_rad: (n,) of microphone 1 over microphone 0, freed of what its channel adds.
        envelope_m, envelope_std_m: (n,) path 2 - path 1 by the envelopes, and its deviation; NaN stays NaN.
        phase_std_rad: (n,) deviation of the phase.
        longest_m: (n,) path 2 - path 1 straight ahead.
        cycle_m: wavelength at the profile's reference frequency.

    Returns:
        (n,) path differences and (n,) deviations.
    """
    off = -phase_rad / (2.0 * np.pi) * cycle_m - envelope_m
    nearest = envelope_m + off - cycle_m * np.round(off / cycle_m)
    places = nearest[:, None] + cycle_m * CYCLES
    distance = (places - envelope_m[:, None]) / envelope_std_m[:, None]
    beyond = np.maximum(places - longest_m[:, None], 0.0) / BEYOND_STD_M
    weight = np.exp(-0.5 * (distance**2 + beyond**2))
    total = weight.sum(axis=1)
    best = np.argmax(weight, axis=1)[:, None]
    chosen = np.take_along_axis(places, best, axis=1)
    sure = np.take_along_axis(weight, best, axis=1)[:, 0] > SURE * total
    other = np.sum(weight * (places - chosen) ** 2, axis=1) / np.where(sure, total, 1.0)
    std = np.sqrt(other + (phase_std_rad / (2.0 * np.pi) * cycle_m) ** 2)
    return np.where(sure, chosen[:, 0], envelope_m), np.where(sure, std, envelope_std_m)
