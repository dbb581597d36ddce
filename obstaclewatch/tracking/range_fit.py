"""Where a tracked echo is, and how fast it closes in: a robust fit to the last beeps' readings, with the steps in it.

The Kalman filter that follows an echo (`kalman`) must decide within the beep whether a peak is its own, and takes the
steps for white noise. What is reported is fitted anew to the last readings instead. The beep that met the obstacle at
tau, counted from the asked time, read

    y = r - v (tau + T) + a (tau^2 / 2 + T tau) + Re((c - j s) exp(j w tau)) + Re((1 + j w T) X exp(j w tau)) + noise,

for a chirp reads x + T dx/dt with T = `range_doppler_s`. X is the phone's bob and fore-aft oscillation as far as they
are measured in the ground's echo and show in this range, c and s what they leave; range r, speed v, acceleration a, c
and s are fitted, with the priors of walkers. Noise follows Student's distribution, by iteratively reweighted least
squares (Lange, Little and Taylor 1989, J. Am. Stat. Assoc. 84:881): where echoes cross, a peak may be of another one,
and later readings decide. Where beeps brought no peak, some of the peaks that others brought are not the echo's either:
deviations grow with the share that is missing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.walker.gait import OSCILLATION_KNOWN_M, OTHER_M, READING_M, STEP_HZ
from obstaclewatch.walker.pitch_oscillation import Oscillation

FITTED_BEEPS = 16
"""1.4 s. Over walks of development 12 or 24 beeps leave 90 % of ranges within 2 % more."""
FREEDOM, ROUNDS = 3.0, 4
"""Of Student's distribution, and fits of which each weighs the readings by the one before."""
SPEED_M_S, SPEED_STD_M_S = 1.2, 0.6
"""Prior of the closing speed."""
ACCELERATION_M_S2 = 0.35
"""Deviation of the acceleration."""
AGEING_HZ = 2.0
"""Deviations grow as sqrt(1 + (AGEING_HZ tau)^2): the older a reading, the less constant the acceleration was."""
DETECTED_SHARE, MISSED_GROWTH = 0.6, 5.0
"""What of the fit's deviation is claimed if every beep was received, and how that grows with the share that was not.
On walks of development 68 % of errors are within 1.05, 1.06, 0.83, 0.83, 0.77 and 0.92 of the claim where up to 50, 60,
70, 80, 90 and 100 % of the beeps were received."""
TERMS = 5


class Timing(NamedTuple):
    """Of the beeps: how far ahead the chirp reads, `BeepDesign.range_doppler_s`, and the time between two of them."""

    ahead_s: float
    period_s: float


class TrackRange(NamedTuple):
    """Range from microphone 0 and closing speed at the asked time, m and m/s, and the range's deviation."""

    range_m: float
    closing_m_s: float
    std_m: float


def track_range(
    readings: Floats, hit_s: float, timing: Timing, oscillation: Oscillation, bob: float = 0.0, fore_aft: float = 0.0
) -> TrackRange:
    """The range at a time, from K >= 1 readings in any order.

    Args:
        readings: (K, 3) time at which a beep met the obstacle, s, range as read, m, and its deviation by noise, m.
        hit_s: the asked time.
        timing: of the beeps.
        oscillation: of the phone; `STEADY` if it is not known.
        bob, fore_aft: what of a rise of the phone adds to this range, and of a move ahead takes off it.
    """
    departure = bob * oscillation.height_m - fore_aft * oscillation.fore_aft_m
    step_rad_s = oscillation.step_rad_s or 2.0 * np.pi * STEP_HZ
    step_std_m = OSCILLATION_KNOWN_M if oscillation.fore_aft_m else READING_M
    return TrackRange(*_fitted(readings, hit_s, timing.ahead_s, timing.period_s, step_rad_s, departure, step_std_m))


@compiled
def _fitted(
    readings: Floats,
    hit_s: float,
    ahead_s: float,
    period_s: float,
    step_rad_s: float,
    departure: complex,
    step_std_m: float,
) -> tuple[float, float, float]:
    """Range, closing speed and the range's deviation; `departure` is X of above as a phasor of absolute time."""
    now, ahead = departure * np.exp(1j * step_rad_s * hit_s), complex(1.0, step_rad_s * ahead_s)
    count, oldest_s, centre_m = len(readings), readings[0, 0], readings[0, 1]
    terms, read_m, variance = np.empty((count, TERMS)), np.empty(count), np.empty(count)
    for row in range(count):
        tau = readings[row, 0] - hit_s
        _terms(terms[row], tau, ahead_s, step_rad_s)
        oscillated = (now * ahead * complex(terms[row, 3], terms[row, 4])).real
        read_m[row] = readings[row, 1] - oscillated - centre_m - SPEED_M_S * terms[row, 1]
        variance[row] = (OTHER_M**2 + readings[row, 2] ** 2) * (1.0 + (AGEING_HZ * tau) ** 2)
        oldest_s = min(oldest_s, readings[row, 0])
    precision = np.array([0.0, SPEED_STD_M_S**-2, ACCELERATION_M_S2**-2, step_std_m**-2, step_std_m**-2])
    there = 1.0 / ahead  # of what is read of the steps, what is in the range
    asked = np.array([1.0, 0.0, 0.0, there.real, there.imag])
    fit = _robust_fit(terms, read_m, variance, precision, asked)
    missed = max(1.0 - count / (round((hit_s - oldest_s) / period_s) + 1.0), 0.0)
    std_m = DETECTED_SHARE * (1.0 + MISSED_GROWTH * missed) * np.sqrt(_sum_of_products(asked, fit[1]))
    return centre_m + now.real + _sum_of_products(asked, fit[0]), SPEED_M_S + fit[0, 1], std_m


@inlined
def _terms(terms: Floats, tau_s: float, ahead_s: float, step_rad_s: float) -> None:
    """Fill in (5,) what range, closing speed, acceleration, and cosine and sine of the steps add to a reading."""
    terms[0], terms[1], terms[2] = 1.0, -(tau_s + ahead_s), tau_s * (0.5 * tau_s + ahead_s)
    terms[3], terms[4] = np.cos(step_rad_s * tau_s), np.sin(step_rad_s * tau_s)


@inlined
def _robust_fit(terms: Floats, read_m: Floats, variance: Floats, precision: Floats, asked: Floats) -> Floats:
    """(2, 5) coefficients of (K, 5) terms, under Student's noise of (K,) scales, and their covariance with `asked`."""
    fit, weight = np.zeros((2, TERMS)), np.empty(len(terms))
    for row in range(len(terms)):
        weight[row] = 1.0 / variance[row]
    for _ in range(ROUNDS):
        _weighted_fit(fit, terms, read_m, weight, precision, asked)
        for row in range(len(terms)):
            left_m = read_m[row] - _sum_of_products(terms[row], fit[0])
            weight[row] = (FREEDOM + 1.0) / (FREEDOM * variance[row] + left_m * left_m)
    return fit


@inlined
def _weighted_fit(fit: Floats, terms: Floats, read_m: Floats, weight: Floats, precision: Floats, asked: Floats) -> None:
    """Fill in the same (2, 5) by weighted least squares with a prior of (5,) precisions about 0."""
    rows = np.zeros((TERMS, TERMS + 2))
    for term in range(TERMS):
        rows[term, term], rows[term, TERMS + 1] = precision[term], asked[term]
    for reading in range(len(terms)):
        for term in range(TERMS):
            share = weight[reading] * terms[reading, term]
            rows[term, TERMS] += share * read_m[reading]
            for other in range(TERMS):
                rows[term, other] += share * terms[reading, other]
    for pivot in range(TERMS):  # positive definite: no row needs to change its place
        for row in range(TERMS):
            share = rows[row, pivot] / rows[pivot, pivot] if row != pivot else 0.0
            for column in range(pivot, TERMS + 2):
                rows[row, column] -= share * rows[pivot, column]
    for term in range(TERMS):
        for side in range(2):
            fit[side, term] = rows[term, TERMS + side] / rows[term, term]


@compiled
def _sum_of_products(one: Floats, other: Floats) -> float:
    """Of (5,) and (5,)."""
    total = 0.0
    for term in range(TERMS):
        total += one[term] * other[term]
    return total
