"""Telling obstacles from what moves along with the walker: ground, parallel walls, the body (paper section 3.4).

While the user walks, obstacles ahead come nearer and everything else stays at its delay. Peaks are compared with
those of earlier beeps: one that finds partners at its own range stays, one that finds them along a constant approach
closes in.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, floor

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.support.compiled import compiled, inlined

SPEED_STEP_M_S = 0.1
"""Between trial speeds: 7 cm after 0.7 s, just within the tolerance of an approach."""
CLOSING_SHARE = 0.5
"""Share of earlier beeps that must hold a partner along the approach."""
STATIC_SHARE = 0.5
"""Share of the older beeps that must hold a partner at the same range."""
LEAST_BEEPS = 3
"""Partners without which nothing is said."""
EDGE = 0.02
"""Of a period, by which ages may waver: a direct sound is looked for within 1.2 ms of its place."""


def check_memory(static_age_s: float, history_s: float, period_s: float) -> None:
    """Refuse beeps so far apart that what moves can never be distinguished: no candidate would ever have a vote.

    An age on the edge does not count: rounding and the clock decide there.

    Raises:
        ValueError: with those ages fewer than `LEAST_BEEPS` earlier beeps are old enough and still remembered.

    >>> check_memory(0.25, 0.75, period_s=0.09)
    """
    held = floor(history_s / period_s - EDGE) - ceil(static_age_s / period_s + EDGE) + 1
    if held < LEAST_BEEPS:
        raise ValueError(
            f"history_s must hold {LEAST_BEEPS} earlier beeps that are static_age_s old or older, got {max(held, 0)}: "
            f"one beep in {period_s:g} s, history_s = {history_s:g}, static_age_s = {static_age_s:g}"
        )


@dataclass(frozen=True)
class Motion:
    """What the past says about n peaks.

    Attributes:
        static: (n,) the peak stays where it is.
        closing: (n,) the peak follows a constant approach.
        closing_speed_m_s: (n,) speed of that approach, NaN where there is none.
        judged: there were enough earlier beeps to say so; False leaves all of the above False and NaN.
    """

    static: Flags
    closing: Flags
    closing_speed_m_s: Floats
    judged: bool


class PeakHistory:
    """Ranges of the peaks of the last beeps.

    Args:
        span_s: how long they are kept.
    """

    def __init__(self, span_s: float) -> None:
        self._span_s = span_s
        self._beeps: deque[tuple[float, Floats]] = deque()

    def add(self, time_s: float, range_m: Floats) -> None:
        """Remember the (n,) peak ranges of the beep at that time."""
        self._beeps.append((time_s, range_m))

    def before(self, time_s: float) -> tuple[Floats, Floats]:
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
    range_m: Floats,
    age_s: Floats,
    past_m: Floats,
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
    speeds = trial_speeds(*closing_speed_m_s)
    return Motion(*_judged(range_m, age_s, past_m, static_tolerance_m, static_age_s, speeds, closing_tolerance_m))


@compiled
def _judged(
    range_m: Floats,
    age_s: Floats,
    past_m: Floats,
    static_tolerance_m: float,
    static_age_s: float,
    speeds_m_s: Floats,
    closing_tolerance_m: float,
) -> tuple[Flags, Flags, Floats, bool]:
    """The fields of `judge_motion`'s answer; the first of the speeds is zero, the others are approaches."""
    count, beeps = len(range_m), len(age_s)
    static, closing = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    speed = np.full(count, np.nan)
    aged = 0
    for age in age_s:
        aged += age >= static_age_s
    if aged < LEAST_BEEPS:
        return static, closing, speed, False
    for peak in range(count):
        partners, apart_m = _partners(range_m[peak], age_s, past_m, speeds_m_s, closing_tolerance_m)
        best = _best(partners, apart_m)
        stays, stays_long = _stays(range_m[peak], age_s, past_m, static_tolerance_m, static_age_s)
        static[peak] = stays_long >= STATIC_SHARE * aged and stays >= partners[best]
        closing[peak] = partners[best] >= max(CLOSING_SHARE * beeps, LEAST_BEEPS) and not static[peak]
        if closing[peak]:
            speed[peak] = _fitted_speed(range_m[peak], speeds_m_s[best], age_s, past_m, closing_tolerance_m)
    return static, closing, speed, True


@lru_cache(maxsize=16)
def trial_speeds(slowest_m_s: float, fastest_m_s: float) -> Floats:
    """Zero, and the speeds of approach that are tried."""
    steps = np.arange(slowest_m_s, fastest_m_s + SPEED_STEP_M_S / 2, SPEED_STEP_M_S)
    speeds = np.concatenate([[0.0], steps])
    speeds.setflags(write=False)
    return speeds


@inlined
def _partners(
    range_m: float, age_s: Floats, past_m: Floats, speeds_m_s: Floats, tolerance_m: float
) -> tuple[Floats, Floats]:
    """Of each approach (S,) to a range: how many earlier beeps hold a peak on it, and how far all beeps' lie off it.

    Speeds run innermost, so that the loop is vectorised over them.
    """
    partners, apart_m = np.zeros(len(speeds_m_s)), np.zeros(len(speeds_m_s))
    nearest = np.empty(len(speeds_m_s))
    for beep in range(len(age_s)):
        nearest[:] = np.inf
        for past in past_m[beep]:
            for trial in range(len(speeds_m_s)):
                offset = abs(range_m + speeds_m_s[trial] * age_s[beep] - past)
                nearest[trial] = offset if offset < nearest[trial] else nearest[trial]
        for trial in range(len(speeds_m_s)):
            partners[trial] += 1.0 if nearest[trial] <= tolerance_m else 0.0
            apart_m[trial] += nearest[trial] if nearest[trial] < 1.0 else 1.0
    return partners, apart_m


@inlined
def _best(partners: Floats, apart_m: Floats) -> int:
    """The approach with the most partners; of several, the one nearest to all beeps. The first speed is none."""
    best = 1
    for trial in range(2, len(partners)):
        more = partners[trial] - partners[best]
        if more > 0.0 or (more == 0.0 and apart_m[trial] < apart_m[best]):
            best = trial
    return best


@inlined
def _stays(range_m: float, age_s: Floats, past_m: Floats, tolerance_m: float, static_age_s: float) -> tuple[int, int]:
    """How many earlier beeps hold a peak at the same range, and how many of those are old enough to decide by."""
    stays = stays_long = 0
    for beep in range(len(age_s)):
        if abs(_nearest_offset(range_m, past_m[beep])) <= tolerance_m:
            stays += 1
            stays_long += age_s[beep] >= static_age_s
    return stays, stays_long


@compiled
def _nearest_offset(expected_m: float, past_m: Floats) -> float:
    """How much farther than expected the nearest of a beep's peaks lies; infinite if there is none."""
    nearest = np.inf
    for past in past_m:
        if abs(past - expected_m) < abs(nearest):
            nearest = past - expected_m
    return nearest


@inlined
def _fitted_speed(range_m: float, speed_m_s: float, age_s: Floats, past_m: Floats, tolerance_m: float) -> float:
    """Least-squares speed through a peak and its partners along a trial speed."""
    moment = weight = 0.0
    for beep, age in enumerate(age_s):
        offset = _nearest_offset(range_m + speed_m_s * age, past_m[beep])
        if abs(offset) <= tolerance_m:
            moment += age * offset
            weight += age * age
    return speed_m_s + moment / weight if weight > 0.0 else speed_m_s
