"""Likelihood along the paths that walkers take: echoes too weak or too short for a track still tell of a collision.

A walker at speed v who will pass a point at the miss distance b, x ahead and h below the phone, reads the ranges
sqrt(x^2 + b^2 + h^2) while x falls by v a second. Steps tell v to 12 %, the ground's echo how the phone oscillates: so
what 20 beeps received adds up along few curves, of which those with b = 0 are collisions. The difference between the
best of these and the best that passes is close to a log likelihood ratio, and needs no track.

Power counts over the mean of earlier beeps at its place. A place that always echoes counts little; it is not counted
against an echo.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Complexes, Floats, Ints, SingleComplexes
from obstaclewatch.support.compiled import compiled
from obstaclewatch.trajectories.geometry import NEAREST_M
from obstaclewatch.walker.pitch_oscillation import Oscillation, oscillation_as_read

MEMORY_BEEPS, LEAST_BEEPS = 20, 8
"""Beeps that add up at most, and at least."""
MEAN_BEEPS, SETTLING_BEEPS = 12, 3
"""Of the mean power at a place, and those that only begin it."""
WIDENED_CELLS = 3
"""How far gait moves what stands there: 4.3 cm."""
EXPECTED_POWER = 3.0
"""Of the echoes that are looked for, over the noise far from all echoes: 8 dB as 2E/N0."""
QUIET_SHARE = 0.3
"""Quantile of the mean powers that stands for that noise."""
BIAS = 0.4
"""Of the largest of three cells, where the echo is free to be."""
LEAST_SHARE = 1e-6
"""Of the strongest sound, that the usual size of a beep's envelope is taken for at least."""
RATIO_LIMITS = (-1.5, 5.0)
AHEAD_M = np.arange(0.25, 1.75, 0.05)
HEIGHTS_M = np.array([0.0, 0.2, 0.35, 0.5, 0.7, 0.95, np.inf])
"""Phone above the reflecting point; the last is the corner with the ground."""
MISSES_M = np.array([0.0, 0.8, 1.1, 1.5])
"""A collision's, then those of what passes."""
SPEEDS = np.concatenate([np.linspace(0.82, 1.18, 7), np.linspace(1.6, 2.4, 5)])
"""Over the walker's own: of what stands, within what steps leave open, then of who comes the other way."""
STANDING = 7
"""So many of them are of what stands."""
NOTHING = -9.0
"""Sum of no beeps."""


class ApproachSums(NamedTuple):
    """The best sums of log likelihood ratios.

    Attributes:
        hit, passing: along a collision with what stands, and along what passes.
        oncoming, oncoming_passing: the same of who comes the other way.
        ahead_m: distance ahead of the best collision with what stands.
    """

    hit: float
    passing: float
    oncoming: float
    oncoming_passing: float
    ahead_m: float


class RecentBeeps(NamedTuple):
    """What the last K beeps received, newest first.

    Attributes:
        time_s: (K,) at which their centres were hit.
        ratio: (K, cells) log likelihood ratios of an echo.
        envelope: (K, 2, S) what moved, over its usual size at either microphone, two samples a cell.
        first_m, cell_m: range of the first cell, and their spacing.
    """

    time_s: Floats
    ratio: Floats
    envelope: SingleComplexes
    first_m: float
    cell_m: float


NO_SUMS = ApproachSums(NOTHING, NOTHING, NOTHING, NOTHING, float(AHEAD_M[-1]))


class ApproachMemory:
    """What the last beeps received, and its log likelihood ratios by range.

    Args:
        cells: number of ranges.
        samples: of an envelope, two a cell.
    """

    def __init__(self, cells: int, samples: int) -> None:
        self._ratio, self._time_s = np.zeros((MEMORY_BEEPS, cells)), np.zeros(MEMORY_BEEPS)
        self._envelope = np.zeros((MEMORY_BEEPS, 2, samples), dtype=np.complex64)
        self._mean = np.zeros(cells)
        self.clear()

    def clear(self) -> None:
        """Forget all beeps."""
        self._mean[:], self._learnt, self._count = 0.0, 0, 0

    def add(self, hit_s: float, moved: Complexes) -> None:
        """One beep at the time at which its centre is hit: envelopes (2, samples) of what moved."""
        size = np.abs(moved)
        magnitude = size[0]
        if self._learnt >= SETTLING_BEEPS:
            row = self._count % MEMORY_BEEPS
            quiet = float(np.quantile(self._mean, QUIET_SHARE))
            _log_ratios(self._ratio[row], magnitude, self._mean, quiet)
            least = max(LEAST_SHARE * float(size.max()), 1e-30)  # without noise, as in synthetic recordings
            self._envelope[row] = moved / np.maximum(np.median(size, axis=1, keepdims=True), least)
            self._time_s[row], self._count = hit_s, self._count + 1
        self._learnt = min(self._learnt + 1, MEAN_BEEPS)
        _learn(self._mean, magnitude, self._learnt)

    def recent(self, first_m: float, cell_m: float) -> RecentBeeps:
        """What the last beeps received, the first cell at a range and the others so far apart."""
        rows = self._newest_first()
        return RecentBeeps(self._time_s[rows], self._ratio[rows], self._envelope[rows], first_m, cell_m)

    def _newest_first(self) -> Ints:
        newest: Ints = (self._count - 1 - np.arange(min(self._count, MEMORY_BEEPS))) % MEMORY_BEEPS
        return newest

    def sums(
        self,
        now_s: float,
        first_m: float,
        cell_m: float,
        ground_m: float,
        oscillation: Oscillation,
        speed_m_s: float,
        ahead_s: float,
    ) -> ApproachSums:
        """The best sums at a time.

        Args:
            now_s: at which the last beep's centre was hit.
            first_m, cell_m: range of the first cell, and their spacing.
            ground_m: height of microphone 0 above the ground.
            oscillation: of the phone.
            speed_m_s: expected of the walker.
            ahead_s: how far ahead the chirp reads.
        """
        if self._count < LEAST_BEEPS:
            return NO_SUMS
        newest_first = self._newest_first()
        time_s, ratio = self._time_s[newest_first], self._ratio[newest_first]
        waves = oscillation_as_read(oscillation, time_s, ahead_s)
        grid = AHEAD_M, np.minimum(HEIGHTS_M, ground_m), MISSES_M, SPEEDS
        best = _best_sums(ratio, now_s - ahead_s - time_s, waves, speed_m_s, first_m, cell_m, *grid)
        return ApproachSums(*best)


@compiled
def _log_ratios(ratio: Floats, magnitude: Floats, mean: Floats, quiet: float) -> None:
    """Fill in (cells,) log likelihood ratios of an echo against what a place usually receives."""
    least, most = RATIO_LIMITS
    power = np.empty(len(mean))
    for cell in range(len(mean)):
        usual = quiet
        for near in range(max(cell - WIDENED_CELLS, 0), min(cell + WIDENED_CELLS + 1, len(mean))):
            usual = max(usual, mean[near])
        ratio[cell] = max(usual, 1e-300)
        power[cell] = 0.5 * (magnitude[2 * cell] ** 2 + magnitude[2 * cell + 1] ** 2) / ratio[cell]
    for cell in range(len(mean)):
        expected = EXPECTED_POWER * quiet / ratio[cell]
        highest = max(power[max(cell - 1, 0)], power[cell], power[min(cell + 1, len(power) - 1)])
        gain = expected / (1.0 + expected)
        ratio[cell] = min(max((highest - BIAS) * gain - np.log1p(expected), least), most)


@compiled
def _learn(mean: Floats, magnitude: Floats, count: int) -> None:
    """Move (cells,) mean powers to those of `count` beeps, of which this is the last."""
    for cell in range(len(mean)):
        power = 0.5 * (magnitude[2 * cell] ** 2 + magnitude[2 * cell + 1] ** 2)
        mean[cell] += (power - mean[cell]) / count


@compiled
def _best_sums(
    ratio: Floats,
    age_s: Floats,
    waves: Floats,
    speed_m_s: float,
    first_m: float,
    cell_m: float,
    ahead_m: Floats,
    heights_m: Floats,
    misses_m: Floats,
    speeds: Floats,
) -> tuple[float, float, float, float, float]:
    """`ApproachSums` of (K, cells) ratios, newest first, (K,) ages as the chirp reads, and (3, K) `waves`.

    Of each curve the best of all sums that end at the newest beep and have `LEAST_BEEPS` or more. Who comes the other
    way is as many times farther ahead as they are faster, so that the walker's own share stays the same.
    """
    hit = passing = oncoming = oncoming_passing = NOTHING
    at_m, cells, per_m = ahead_m[-1], ratio.shape[1], 1.0 / cell_m
    for height_m in heights_m:
        for miss_m in misses_m:
            aside2 = miss_m * miss_m + height_m * height_m
            for place in range(len(ahead_m)):
                for which in range(len(speeds)):
                    pace_m_s, begin_m = speeds[which] * speed_m_s, ahead_m[place] * max(speeds[which], 1.0)
                    total, most = 0.0, NOTHING
                    for beep in range(len(age_s)):
                        along_m = begin_m + pace_m_s * age_s[beep]
                        range_m = max(np.sqrt(along_m * along_m + aside2), NEAREST_M)
                        read_m = range_m + (height_m * waves[1, beep] - along_m * waves[2, beep]) / range_m
                        cell = int(np.floor((read_m - first_m) * per_m + 0.5))
                        if 0 <= cell < cells:
                            total += ratio[beep, cell]
                        if beep >= LEAST_BEEPS - 1 and total > most:
                            most = total
                    if which >= STANDING:
                        if miss_m > 0.0:
                            oncoming_passing = max(oncoming_passing, most)
                        else:
                            oncoming = max(oncoming, most)
                    elif miss_m > 0.0:
                        passing = max(passing, most)
                    elif most > hit:
                        hit, at_m = most, ahead_m[place]
    return hit, passing, oncoming, oncoming_passing, at_m
