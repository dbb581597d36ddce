"""Kalman's filter of a straight approach: range and closing speed, read `ahead_s` ahead by a chirp.

Written out for two numbers and compiled: a matrix product of this size costs more to call than to compute.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled, inlined


@compiled
def begun(age_s: Floats, read_m: Floats, variance: float, ahead_s: float) -> tuple[Floats, Floats]:
    """State (2,) and covariance (2, 2) at the last of K readings of equal variance: least squares through them."""
    total, first, second = float(len(age_s)), age_s.sum(), np.sum(age_s * age_s)
    read, moment, spread = read_m.sum(), np.sum(age_s * read_m), total * second - first * first
    level, speed = (second * read - first * moment) / spread, (total * moment - first * read) / spread
    state, covariance = np.empty(2), np.empty((2, 2))
    state[0], state[1] = level + speed * ahead_s, speed
    covariance[0, 0] = variance / spread * (second - 2.0 * ahead_s * first + ahead_s**2 * total)
    covariance[0, 1] = covariance[1, 0] = variance / spread * (ahead_s * total - first)
    covariance[1, 1] = variance / spread * total
    return state, covariance


@inlined
def predicted(state: Floats, covariance: Floats, step_s: float, acceleration_m_s2: float) -> tuple[Floats, Floats]:
    """State (2,), range, m, and closing speed, m/s, and covariance (2, 2) a time later, under white acceleration."""
    moved, spread = np.empty(2), np.empty((2, 2))
    moved[0], moved[1] = state[0] - step_s * state[1], state[1]
    jolt_m, jolt_m_s = 0.5 * step_s**2 * acceleration_m_s2, -step_s * acceleration_m_s2
    to_speed = covariance[0, 1] - step_s * covariance[1, 1]
    spread[0, 0] = covariance[0, 0] - step_s * covariance[1, 0] - step_s * to_speed + jolt_m**2
    spread[0, 1] = spread[1, 0] = to_speed + jolt_m * jolt_m_s
    spread[1, 1] = covariance[1, 1] + jolt_m_s**2
    return moved, spread


@compiled
def expected_reading(state: Floats, covariance: Floats, ahead_s: float) -> tuple[float, float]:
    """What a chirp would read, m, and its variance."""
    to_range, to_speed = _seen(covariance, ahead_s)
    return state[0] - ahead_s * state[1], to_range - ahead_s * to_speed


@inlined
def updated(state: Floats, covariance: Floats, read_m: float, variance: float, ahead_s: float) -> tuple[Floats, Floats]:
    """State and covariance after a reading of that variance."""
    better, spread = np.empty(2), np.empty((2, 2))
    seen = _seen(covariance, ahead_s)
    expected_m, own = expected_reading(state, covariance, ahead_s)
    for row in range(2):
        gain = seen[row] / (own + variance)
        better[row] = state[row] + gain * (read_m - expected_m)
        for column in range(2):
            spread[row, column] = covariance[row, column] - gain * seen[column]
    return better, spread


@compiled
def _seen(covariance: Floats, ahead_s: float) -> tuple[float, float]:
    """Covariances of range and speed with what is read."""
    return (covariance[0, 0] - ahead_s * covariance[0, 1], covariance[1, 0] - ahead_s * covariance[1, 1])
