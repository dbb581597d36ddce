"""Telling obstacles from what moves along with the walker: ground, parallel walls, the body (paper section 3.4).

While the user walks, obstacles ahead come nearer and everything else stays at its delay. Peaks are compared with
those of earlier beeps: one that finds partners at its own range stays, one that finds them along a constant approach
closes in.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

SPEED_STEP_M_S = 0.1
"""Between trial speeds: 7 cm after 0.7 s, just within the tolerance of an approach."""
CLOSING_SHARE = 0.5
"""Share of earlier beeps that must hold a partner along the approach."""
STATIC_SHARE = 0.5
"""Share of the older beeps that must hold a partner at the same range."""
LEAST_BEEPS = 3
"""Partners without which nothing is said."""


@dataclass(frozen=True)
class Motion:
    """What the past says about n peaks.

    Attributes:
        static: (n,) the peak stays where it is.
        closing: (n,) the peak follows a constant approach.
        closing_speed_m_s: (n,) speed of that approach, NaN where there is none.
        judged: there were enough earlier beeps to say so; False leaves all of the above False and NaN.
    """

    static: NDArray[np.bool_]
    closing: NDArray[np.bool_]
    closing_speed_m_s: NDArray[np.float64]
    judged: bool


class PeakHistory:
    """Ranges of the peaks of the last beeps.

    Args:
        span_s: how long they are kept.
    """

    def __init__(self, span_s: float) -> None:
        self._span_s = span_s
        self._beeps: deque[tuple[float, NDArray[np.float64]]] = deque()

    def add(self, time_s: float, range_m: NDArray[np.float64]) -> None:
        """Remember the (n,) peak ranges of the beep at that time."""
        self._beeps.append((time_s, range_m))

    def before(self, time_s: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Ages (K,), s, and ranges (K, P), m, NaN-padded, of the beeps within the span; older ones are forgotten."""
        while self._beeps and time_s - self._beeps[0][0] > self._span_s:
            self._beeps.popleft()
        ages = np.array([time_s - past for past, _ in self._beeps])
        width = max((len(ranges) for _, ranges in self._beeps), default=0)
        padded = np.full((len(self._beeps), width), np.nan)
        for row, (_, ranges) in zip(padded, self._beeps, strict=True):
            row[: len(ranges)] = ranges
        return ages, padded

    def clear(self) -> None:
        """Forget all beeps."""
        self._beeps.clear()


def judge_motion(
    range_m: NDArray[np.float64],
    age_s: NDArray[np.float64],
    past_m: NDArray[np.float64],
    static_tolerance_m: float,
    static_age_s: float,
    closing_speed_m_s: tuple[float, float],
    closing_tolerance_m: float,
) -> Motion:
    """Judge (n,) peak ranges against the peaks (K, P) of K earlier beeps of the given ages (K,).

    A peak is static when at least half of the older beeps hold a partner at its range and no approach explains more
    beeps than that; it closes in when an approach explains at least half of all beeps. The speed is a least-squares
    fit through the partners.
    """
    count, beeps = len(range_m), len(age_s)
    old = age_s >= static_age_s
    aged = np.count_nonzero(old)
    if aged < LEAST_BEEPS or count == 0:
        return Motion(np.zeros(count, bool), np.zeros(count, bool), np.full(count, np.nan), bool(aged >= LEAST_BEEPS))
    speeds = trial_speeds(*closing_speed_m_s)
    offset = nearest_offset(range_m[:, None, None] + speeds[:, None] * age_s, past_m)
    stays, approach = offset[:, 0] <= static_tolerance_m, offset[:, 1:]
    each = np.ones(beeps)
    partners = (approach <= closing_tolerance_m) @ each
    best = (partners - 1e-3 / beeps * (np.minimum(approach, 1.0) @ each)).argmax(axis=-1)
    most = partners[np.arange(count), best]
    static = (stays @ old.astype(float) >= STATIC_SHARE * aged) & (stays @ each >= most)
    closing = (most >= max(CLOSING_SHARE * beeps, LEAST_BEEPS)) & ~static
    speed = np.full(count, np.nan)
    which = closing.nonzero()[0]
    if len(which):
        speed[which] = fitted_speed(range_m[which], speeds[1:][best[which]], age_s, past_m, closing_tolerance_m)
    return Motion(static, closing, speed, True)


@lru_cache(maxsize=16)
def trial_speeds(slowest_m_s: float, fastest_m_s: float) -> NDArray[np.float64]:
    """Zero, and the speeds of approach that are tried."""
    steps = np.arange(slowest_m_s, fastest_m_s + SPEED_STEP_M_S / 2, SPEED_STEP_M_S)
    speeds = np.concatenate([[0.0], steps])
    speeds.setflags(write=False)
    return speeds


def nearest_offset(expected_m: NDArray[np.float64], past_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., K) distance from expected ranges (..., K) to the nearest peak of each beep (K, P); inf if none."""
    nearest = np.full(expected_m.shape, np.inf)
    apart = np.empty(expected_m.shape)
    for peak in np.where(np.isnan(past_m), np.inf, past_m).T:
        np.subtract(expected_m, peak, out=apart)
        np.abs(apart, out=apart)
        np.minimum(nearest, apart, out=nearest)
    return nearest


def fitted_speed(
    range_m: NDArray[np.float64],
    speed_m_s: NDArray[np.float64],
    age_s: NDArray[np.float64],
    past_m: NDArray[np.float64],
    tolerance_m: float,
) -> NDArray[np.float64]:
    """(n,) least-squares speed through each peak (n,) and its partners along a trial speed (n,)."""
    if past_m.shape[1] == 0:
        return speed_m_s
    expected = range_m[:, None] + speed_m_s[:, None] * age_s
    offset = np.where(np.isnan(past_m), np.inf, past_m) - expected[..., None]
    rows = offset.reshape(-1, past_m.shape[1])
    nearest = rows[np.arange(len(rows)), np.argmin(np.abs(rows), axis=1)].reshape(expected.shape)
    weight = np.where(np.abs(nearest) <= tolerance_m, age_s, 0.0)
    correction = np.sum(weight * np.where(weight > 0, nearest, 0.0), axis=-1)
    return speed_m_s + correction / np.maximum(np.sum(weight * age_s, axis=-1), np.finfo(float).tiny)
