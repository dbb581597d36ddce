"""Bearing of what is received on a cone about the phone's long axis, its height not known.

Two microphones give the angle to the phone's long axis alone. With the phone pitched and the ground known, one cone is
that of a thing at the phone's height and some way aside, or of one's corner with the ground straight ahead. Nothing
decides which; so all are weighed, every bearing alike and heights as often as they were found, against what the
envelopes and the carrier say of the path difference. Straight ahead the cone hardly changes with the bearing, so that
even prior alone makes bearings near it likelier, and with them the carrier's cycle that leads there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.signal.carrier_cycle import CYCLES, DifferenceReadings, nearest_place
from obstaclewatch.signal.two_mics import law_of_cosines, path_difference_at
from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled, inlined

STEP_RAD = np.deg2rad(1.0)
BEARINGS_RAD = STEP_RAD * np.arange(0.5, 90.0)
COS_BEARING = np.cos(BEARINGS_RAD)
HEIGHTS_M = np.array([0.0, 0.3, 0.6, np.inf])
"""Phone above reflecting point; the last stands for the corner with the ground."""
HEIGHT_PRIOR = np.array([0.45, 0.1, 0.1, 0.35])
"""Of the points whose echo is expected first at 360 development places, of walls, signs, bins and people, 50 % lie
within 10 cm of the phone's height, 12 % between and 36 % at the foot; of cars, which these lack, all between."""
IMAGES = np.array([1.0, 2.0])
"""Distance that waves seem to come from over the range: a point's or a round thing's own, twice that of a mirror."""
REACH = 4.0
"""How far from the envelopes' path difference, in its deviations, another may lie."""
ODD = 0.05
"""Share of phases without information."""


class Attitude(NamedTuple):
    """Of the phone: pitch of the phone as sine and cosine, height of microphone 0, length between microphones."""

    sin_pitch: float
    cos_pitch: float
    height_m: float
    separation_m: float


def bearing_posterior(
    range_m: Floats, readings: DifferenceReadings, attitude: Attitude
) -> tuple[Floats, Floats, Floats]:
    """Bearings of n candidates, and which cycles they lie in.

    Args:
        range_m: (n,) from microphone 0.
        readings: of their path differences.
        attitude: of the phone.

    Returns:
        (n,) medians of the bearing, 0 to pi / 2, (n,) deviations from them; NaN where nothing ahead explains what was
        received. (n, len(CYCLES)) probabilities of the cycles around the one nearest to the envelopes' difference; 0
        without a phase.
    """
    return _posterior(range_m, readings, attitude)


@compiled
def _posterior(range_m: Floats, readings: DifferenceReadings, attitude: Attitude) -> tuple[Floats, Floats, Floats]:
    medians, deviations = np.full(len(range_m), np.nan), np.full(len(range_m), np.nan)
    cycles = np.zeros((len(range_m), len(CYCLES)))
    place = np.empty(len(BEARINGS_RAD))
    for row in range(len(range_m)):
        if np.isnan(readings.envelope_m[row]):
            continue
        said = readings.envelope_m[row], readings.envelope_std_m[row]
        rotated = readings.phase_rad[row], readings.phase_std_rad[row]
        total = _weigh(range_m[row], said, rotated, readings.cycle_m, attitude, place, cycles[row])
        if total > 0.0:
            for angle in range(len(place)):
                place[angle] /= total
            medians[row], deviations[row] = _middle(place)
            for cycle in range(len(CYCLES)):
                cycles[row, cycle] /= total
    return medians, deviations, cycles


@inlined
def _weigh(
    range_m: float,
    envelope: tuple[float, float],
    phase: tuple[float, float],
    cycle_m: float,
    attitude: Attitude,
    place: Floats,
    cycles: Floats,
) -> float:
    """Fill weights of bearings and of cycles (as many as `CYCLES`) for one candidate; their sum."""
    place[:], cycles[:] = 0.0, 0.0
    middle_m, std_m = envelope
    phase_rad, sharpness = phase[0], 1.0 / phase[1] ** 2
    received = not np.isnan(phase_rad)
    rad_per_m = 2.0 * np.pi / cycle_m
    odd = ODD / np.sqrt(2.0 * np.pi * sharpness)
    nearest_m = nearest_place(phase_rad, middle_m, cycle_m)
    total = 0.0
    for kind in range(len(HEIGHTS_M)):
        down = min(HEIGHTS_M[kind], attitude.height_m) / range_m
        if down >= 1.0:
            continue
        along, below = np.sqrt(1.0 - down * down) * attitude.cos_pitch, down * attitude.sin_pitch
        for image in IMAGES:
            image_m = range_m * image
            most = law_of_cosines(image_m, image_m + middle_m + REACH * std_m, attitude.separation_m)
            least = law_of_cosines(image_m, image_m + middle_m - REACH * std_m, attitude.separation_m)
            for angle in range(_step_at((most + below) / along), _step_at((least + below) / along)):
                u_m = path_difference_at(image_m, along * COS_BEARING[angle] - below, attitude.separation_m)
                off = (u_m - middle_m) / std_m
                weight = HEIGHT_PRIOR[kind] * np.exp(-0.5 * off * off)
                if received:
                    weight *= (1.0 - ODD) * np.exp(sharpness * (np.cos(phase_rad + rad_per_m * u_m) - 1.0)) + odd
                    cycle = round((u_m - nearest_m) / cycle_m) + len(cycles) // 2
                    if 0 <= cycle < len(cycles):
                        cycles[cycle] += weight
                place[angle] += weight
                total += weight
    return total


@compiled
def _step_at(cosine: float) -> int:
    """The first of `BEARINGS_RAD` that is at least as far aside as a cosine says."""
    aside = np.arccos(min(max(cosine, 0.0), 1.0))
    return min(int(np.ceil(aside / STEP_RAD - 0.5)), len(BEARINGS_RAD))


@inlined
def _middle(share: Floats) -> tuple[float, float]:
    """Median of the bearing, and root mean square departure from it."""
    passed, median = 0.0, np.nan
    for angle in range(len(share)):
        if passed + share[angle] >= 0.5:
            median = BEARINGS_RAD[angle] + STEP_RAD * ((0.5 - passed) / share[angle] - 0.5)
            break
        passed += share[angle]
    spread = 0.0
    for angle in range(len(share)):
        spread += share[angle] * (BEARINGS_RAD[angle] - median) ** 2
    return median, np.sqrt(spread)
