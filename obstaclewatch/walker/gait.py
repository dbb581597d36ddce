"""How gait makes a walker's readings depart from a straight trajectory at constant speed.

Once a step the trunk oscillates fore and aft by about a centimetre, and through range-Doppler coupling the chirp reads
0.205 s of the fore-aft oscillation's speed as well: 2.8 cm at two steps a second, zero to peak. Deviations repeat with
the step; so they are not independent from beep to beep, of which a step holds six, and a straight line through few of
them is worth less than through as many independent readings.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import inlined

STEP_HZ, STEP_STD_HZ = 1.85, 0.15
"""Steps per second of adults who walk at 1.0-1.5 m/s (Murakami and Otaka 2017: 1.6-2.0)."""
READING_M = 0.020
"""Standard deviation over a step: 2.8 cm / sqrt(2)."""
OSCILLATION_KNOWN_M = 0.010
"""The same with the oscillation known and taken off: half, as people move by half as much or more."""
OTHER_M = 0.012
"""What is neither step nor noise: reflecting points that wander, echoes that overlap."""


@inlined
def reading_covariance(time_s: Floats, noise_std_m: Floats, step_std_m: float) -> Floats:
    """(K, K) covariance, m^2, of K readings about a straight trajectory.

    A sinusoid of random phase and of a frequency N(STEP_HZ, STEP_STD_HZ^2), and white noise.

    Args:
        time_s: (K,) times of the readings.
        noise_std_m: (K,) their deviations by noise.
        step_std_m: standard deviation over a step.
    """
    covariance = np.empty((len(time_s), len(time_s)))
    angle, cosine, sine = np.empty(len(time_s)), np.empty(len(time_s)), np.empty(len(time_s))
    for row in range(len(time_s)):
        angle[row] = 2.0 * np.pi * time_s[row]
        cosine[row], sine[row] = np.cos(STEP_HZ * angle[row]), np.sin(STEP_HZ * angle[row])
        for column in range(row):
            of_lag = cosine[row] * cosine[column] + sine[row] * sine[column]
            spread = STEP_STD_HZ * (angle[row] - angle[column])
            covariance[row, column] = covariance[column, row] = step_std_m**2 * of_lag * np.exp(-0.5 * spread * spread)
        covariance[row, row] = step_std_m**2 + OTHER_M**2 + noise_std_m[row] ** 2
    return covariance


@inlined
def whitening(covariance: Floats) -> Floats:
    """(K, K) lower triangle W with W covariance W^T = 1: rows of covariance and identity are eliminated jointly."""
    count = len(covariance)
    rows = np.zeros((count, 2 * count))
    for row in range(count):
        rows[row, count + row] = 1.0
        for column in range(count):
            rows[row, column] = covariance[row, column]
    for pivot in range(count):
        reached = slice(pivot, count + pivot + 1)  # before it all is eliminated, behind it the identity has zeros
        own = rows[pivot, reached].copy()
        for row in range(pivot + 1, count):
            other = rows[row, reached]
            share = other[0] / own[0]
            for column in range(count + 1):
                other[column] -= share * own[column]
    white = np.zeros((count, count))
    for row in range(count):
        deviation = np.sqrt(rows[row, row])
        for column in range(row + 1):
            white[row, column] = rows[row, count + column] / deviation
    return white


@inlined
def line_weights(time_s: Floats, white: Floats) -> tuple[Floats, Floats]:
    """(K,) weights whose sums over readings are a straight line's value at time 0, and its fall a second.

    Generalised least squares: in whitened readings (K, K) the line is `level - fall time`.
    """
    level, fall = np.zeros(len(time_s)), np.zeros(len(time_s))
    on_level, on_fall = np.zeros(len(time_s)), np.zeros(len(time_s))
    own = both = other = 0.0
    for row in range(len(time_s)):
        for beep in range(row + 1):
            level[row] += white[row, beep]
            fall[row] -= white[row, beep] * time_s[beep]
        own, both, other = own + level[row] ** 2, both + level[row] * fall[row], other + fall[row] ** 2
        for beep in range(row + 1):
            on_level[beep] += level[row] * white[row, beep]
            on_fall[beep] += fall[row] * white[row, beep]
    of_level, of_fall = np.empty(len(time_s)), np.empty(len(time_s))
    for beep in range(len(time_s)):
        of_level[beep] = (other * on_level[beep] - both * on_fall[beep]) / (own * other - both * both)
        of_fall[beep] = (own * on_fall[beep] - both * on_level[beep]) / (own * other - both * both)
    return of_level, of_fall
