"""Tracks of what closes in: found by the likelihood of a line over many beeps, then followed by a Kalman filter.

Range r and closing speed v are those of the beep's centre as it is hit. The chirp reads r - v x range_doppler_s, and
that is the filter's measurement: its ranges have no range-Doppler bias.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Floats, SingleComplexes
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.tracking.kalman import begun, expected_reading, predicted, updated
from obstaclewatch.tracking.moving_peaks import MovingPeaks
from obstaclewatch.tracking.range_fit import FITTED_BEEPS, Timing, TrackRange, track_range
from obstaclewatch.tracking.track_before_detect import LineLikelihood
from obstaclewatch.trajectories.posterior_grid import Expectation, Posterior, Samples
from obstaclewatch.walker.pitch_oscillation import Oscillation

SEARCH_BEEPS = 12
GATE_M = 0.09
"""How far a peak may be from a line: 1 cm of fore-aft oscillation, 2.6 cm of its range-Doppler coupling, 6 cm of a
coarse speed."""
HIT, MISS = 1.9, -1.1
"""Log likelihood ratios: a peak lies within the gate of an echo in 7 beeps of 10, of nothing in 1 of 10."""
POWER_GAIN, MOST_GAIN = 0.25, 3.0
"""What a peak's power above the usual threshold adds, at most."""
THRESHOLD_POWER = 4.0
START_SCORE = 9.0
"""exp(9) outweighs the 8,000 lines that are tried at every beep."""
STARTS_A_BEEP = 3
LEAST_PEAKS = 4
OWN_M = 0.10
"""Around a track, what is received belongs to it."""
MOST_SCORE = 25.0
LEAST_SPEED_M_S = 0.3
MOST_MISSES = 7
"""Beeps in which nothing is received of a track, or that are missing, until it or a line is given up."""
KEPT_BEEPS = 24
"""On 287 walks of development bearings were off by 6.5 degrees (median) with 16, 6.0 with 24, 5.8 with 32; collisions
and misses were distinguished best with 24."""
LEFT_PEAKS = 6
"""Of a track that forgets those that fit no trajectory."""
FORE_AFT_READ_M = 0.025
"""Deviation of a reading by gait: what the fore-aft oscillation's speed reads through range-Doppler coupling."""
ACCELERATION_M_S2 = 0.35
GATE_DEVIATIONS = 3.5
TWINS_M, TWINS_M_S = 0.08, 0.4
"""Differences below which two tracks follow the same echo."""
Reading = tuple[float, float, float]
"""Of a peak: time, range and the range's deviation."""


@dataclass
class Track:
    """One obstacle that closes in.

    Attributes:
        range_m, closing_m_s: range and closing speed at `time_s`.
        covariance: (2, 2) of the two.
        time_s: of these: when the beep's centre meets the obstacle, about.
        score: log likelihood ratio of being real.
        level_db, snr_db: of its last peak.
        misses: beeps since that peak.
        judged, trajectory: the trajectories that it was last thought to take, and what was to be expected of them at
            the last beep; None before the first judgement.
        past: the last peaks, oldest first.
        second, levels_db: microphone 1 around them, and their levels.
        detected_s: time of the last.
        readings: of the last `FITTED_BEEPS` peaks the same as `past`, which forgets what fits no trajectory.
    """

    range_m: float
    closing_m_s: float
    covariance: Floats
    time_s: float
    score: float
    level_db: float = np.nan
    snr_db: float = np.nan
    misses: int = 0
    judged: Posterior | None = None
    trajectory: Expectation | None = None
    past: deque[Reading] = field(default_factory=lambda: deque(maxlen=KEPT_BEEPS))
    second: deque[SingleComplexes] = field(default_factory=lambda: deque(maxlen=KEPT_BEEPS))
    levels_db: deque[float] = field(default_factory=lambda: deque(maxlen=KEPT_BEEPS))
    detected_s: float = -np.inf
    readings: deque[Reading] = field(default_factory=lambda: deque(maxlen=FITTED_BEEPS))

    def follow(self, time_s: float, peaks: MovingPeaks, taken: Flags, ahead_s: float) -> int:
        """Move on to a beep and update by the likeliest of the peaks not taken; which it is, -1 for none."""
        step_s, self.time_s = time_s - self.time_s, time_s
        self.range_m, self.closing_m_s, self.covariance, which = _followed(
            self.range_m, self.closing_m_s, self.covariance, step_s, ahead_s, peaks.readings, taken
        )
        return which

    def remember(self, time_s: float, peaks: MovingPeaks, which: int) -> None:
        """Keep a peak for the judgement of the trajectory."""
        _, range_m, deviation_m, self.level_db, self.snr_db = peaks.readings[:, which].tolist()
        self.past.append((time_s, range_m, deviation_m))
        self.readings.append((time_s, range_m, deviation_m))
        self.second.append(peaks.second[which])
        self.levels_db.append(self.level_db)
        self.detected_s = time_s

    def forget_oldest(self) -> None:
        """Drop a third of the peaks kept for judgement, the oldest, if enough are left to judge."""
        dropped = len(self.past) // 3
        if len(self.past) - dropped >= LEFT_PEAKS:
            for _ in range(dropped):
                self.past.popleft()
                self.second.popleft()
                self.levels_db.popleft()

    def samples(self, ahead_s: float) -> Samples:
        """What was measured, at the times that the readings stand for."""
        time_s, range_m, range_std_m = np.array(self.past).T.copy()
        return Samples(time_s + ahead_s, range_m, range_std_m, np.array(self.second))

    def ranged(self, trajectory: Expectation, oscillation: Oscillation, timing: Timing) -> TrackRange:
        """Where the echo is at `time_s`, by its last readings, on a trajectory, with the phone oscillating."""
        return track_range(
            np.array(self.readings), self.time_s, timing, oscillation, trajectory.bob, trajectory.fore_aft
        )


class _FreePeaks(NamedTuple):
    """The peaks of the last B beeps, n in all.

    Attributes:
        readings: (5, n) see `MovingPeaks`.
        free: (n,) which of them no track has taken.
        counts: (B,) peaks of each beep, in the order of the beeps.
        ages_s: (B,) of the beeps.
    """

    readings: Floats
    free: Flags
    counts: NDArray[np.int_]
    ages_s: Floats


class Approaches:
    """All tracks.

    Args:
        ahead_s: how far ahead the chirp reads, `BeepDesign.range_doppler_s`.
        likelihood: of lines, empty.

    Attributes:
        tracks: those there are.
    """

    def __init__(self, ahead_s: float, likelihood: LineLikelihood) -> None:
        self._ahead_s, self._likelihood = ahead_s, likelihood
        self.tracks: list[Track] = []
        self._free: deque[tuple[float, MovingPeaks, Flags]] = deque(maxlen=SEARCH_BEEPS)

    def clear(self) -> None:
        """Forget everything."""
        self.tracks.clear()
        self._free.clear()
        self._likelihood.clear()

    def step(self, time_s: float, peaks: MovingPeaks) -> list[Track]:
        """Follow the tracks to a beep's peaks, start and end tracks; returns those there are, nearest first."""
        taken = np.zeros(len(peaks), dtype=bool)
        for track in sorted(self.tracks, key=lambda track: -track.score):
            self._follow(track, time_s, peaks, taken)
        self.tracks = [track for track in self.tracks if _lives(track)]
        self._gather(time_s, peaks)
        self._free.append((time_s, peaks, ~taken))
        for track in self.tracks:
            self._fade(track.range_m - self._ahead_s * track.closing_m_s, peaks)
        self._start(peaks)
        self._part()
        self.tracks.sort(key=lambda track: track.range_m)
        return self.tracks

    def _follow(self, track: Track, time_s: float, peaks: MovingPeaks, taken: Flags) -> None:
        best = track.follow(time_s, peaks, taken, self._ahead_s)
        if best < 0:
            track.misses += 1
            track.score += MISS
            return
        taken[best] = True
        track.remember(time_s, peaks, best)
        track.misses = 0
        track.score = min(track.score + HIT + _power_gain(peaks.readings[0, best]), MOST_SCORE)

    def _gather(self, time_s: float, peaks: MovingPeaks) -> None:
        """Add a beep's likelihood; through beeps that are missing the lines go on, with nothing said of them."""
        missing = round((time_s - self._free[-1][0]) / self._likelihood.period_s) - 1 if self._free else 0
        if missing > MOST_MISSES:
            self._likelihood.clear()
            missing = 0
        for _ in range(missing):
            self._likelihood.add(np.zeros_like(peaks.log_ratio))
        self._likelihood.add(peaks.log_ratio)

    def _fade(self, read_m: float, peaks: MovingPeaks, share: float = 0.0) -> None:
        cell = round((read_m - peaks.first_m) / peaks.cell_m)
        reach = round(OWN_M / peaks.cell_m)
        self._likelihood.fade(cell - reach, cell + reach + 1, share)

    def _start(self, peaks: MovingPeaks) -> None:
        """Tracks along the lines that have gathered enough."""
        free = None
        for _ in range(STARTS_A_BEEP):
            score, cell = self._likelihood.best()
            if score < START_SCORE:
                return
            read_m = peaks.first_m + cell * peaks.cell_m
            free = self._free_peaks() if free is None else free
            found = _best_chain(free, read_m, self._likelihood.speeds_to(cell))
            chain = [(row, which) for row, which in enumerate(found.tolist()) if which >= 0]
            begun = len(chain) >= LEAST_PEAKS
            if begun:
                self._begin(chain, min(score, MOST_SCORE))
                free = None
            self._fade(read_m, peaks, 0.0 if begun else 0.5)

    def _free_peaks(self) -> _FreePeaks:
        times_s, peaks, free = zip(*self._free, strict=True)
        counts, ages_s = np.array([len(of_beep) for of_beep in free]), times_s[-1] - np.array(times_s)
        # Of a single peak each the result would be by columns, and compiled loops would be compiled anew for that.
        readings = np.ascontiguousarray(np.concatenate([of.readings for of in peaks], axis=1))
        return _FreePeaks(readings, np.concatenate(free), counts, ages_s)

    def _begin(self, chain: list[tuple[int, int]], score: float) -> None:
        """A track along a line: least squares through the peaks on it, then remembered as if followed."""
        last_s = self._free[chain[-1][0]][0]
        age = np.array([last_s - self._free[row][0] for row, _ in chain])
        read = np.array([self._free[row][1].range_m[which] for row, which in chain])
        state, covariance = begun(age, read, 4.0 * FORE_AFT_READ_M**2, self._ahead_s)
        range_m, closing_m_s = state.tolist()
        if not closing_m_s >= LEAST_SPEED_M_S:
            return
        track = Track(range_m, closing_m_s, covariance, last_s, score)
        for row, which in chain:
            time_s, peaks, free = self._free[row]
            track.remember(time_s, peaks, which)
            free[which] = False
        self.tracks.append(track)

    def _part(self) -> None:
        """Of two tracks that have become one, the better stays."""
        kept: list[Track] = []
        for track in sorted(self.tracks, key=lambda track: (-len(track.past), -track.score)):
            if not any(_are_one(track, other) for other in kept):
                kept.append(track)
        self.tracks = kept


def _lives(track: Track) -> bool:
    """Still detected, still closing in, still ahead."""
    received = track.score > 0.0 and track.misses <= MOST_MISSES
    return received and track.closing_m_s >= LEAST_SPEED_M_S and track.range_m > 0.1


def _are_one(track: Track, other: Track) -> bool:
    """As near and as fast as each other."""
    near = abs(track.range_m - other.range_m) < TWINS_M
    return near and abs(track.closing_m_s - other.closing_m_s) < TWINS_M_S


@compiled
def _followed(
    range_now_m: float,
    closing_m_s: float,
    covariance: Floats,
    step_s: float,
    ahead_s: float,
    readings: Floats,
    taken: Flags,
) -> tuple[float, float, Floats, int]:
    """Range, closing speed and covariance (2, 2) a step later, updated by the likeliest peak; which one.

    `readings` are those of `MovingPeaks`, of n peaks, and `taken` (n,) says which are another track's. The likeliest is
    the free peak within the gate that is strongest for its distance from the expected one; -1 if there is none,
    and no update then.
    """
    state = np.array([range_now_m, closing_m_s])
    moved, spread = predicted(state, covariance, step_s, ACCELERATION_M_S2)
    expected_m, expected_variance = expected_reading(moved, spread, ahead_s)
    best, most = -1, -np.inf
    power, range_m, range_std_m = readings[0], readings[1], readings[2]
    for peak in range(len(power)):
        own = FORE_AFT_READ_M**2 + range_std_m[peak] ** 2
        distance2 = (range_m[peak] - expected_m) ** 2 / (expected_variance + own)
        merit = np.log(power[peak]) - 0.5 * distance2
        if not taken[peak] and distance2 <= GATE_DEVIATIONS**2 and merit > most:
            best, most = peak, merit
    if best >= 0:
        moved, spread = updated(moved, spread, range_m[best], FORE_AFT_READ_M**2 + range_std_m[best] ** 2, ahead_s)
    return moved[0], moved[1], spread, best


@compiled
def _best_chain(peaks: _FreePeaks, read_m: float, speeds_m_s: Floats) -> NDArray[np.int_]:
    """(B,) which peak of each beep lies on the line that gained most, -1 where none does or before it gained.

    Args:
        peaks: of all beeps.
        read_m: range to which the lines have come.
        speeds_m_s: (S,) of the lines.
    """
    counts, free, power, range_m = peaks.counts, peaks.free, peaks.readings[0], peaks.readings[1]
    most, best, found = -np.inf, np.full(len(counts), -1), np.full(len(counts), -1)
    for speed in speeds_m_s:
        gained, first = 0.0, len(range_m)
        for row in range(len(counts) - 1, -1, -1):
            first, end = first - counts[row], first
            farther_m = speed * peaks.ages_s[row]
            which, gain = _on_line(range_m[first:end], power[first:end], free[first:end], read_m, farther_m)
            found[row] = which
            gained += gain if which >= 0 else MISS
            if gained > most:
                most = gained
                for other in range(len(counts)):
                    best[other] = found[other] if other >= row else -1
    return best


@inlined
def _on_line(range_m: Floats, power: Floats, free: Flags, read_m: float, farther_m: float) -> tuple[int, float]:
    """The free peak that gains most for a line farther than `read_m`, and what it gains; -1 if none is near enough."""
    best, most = -1, -np.inf
    for peak in range(len(range_m)):
        offset = (range_m[peak] - read_m - farther_m) / GATE_M
        gain = HIT + _power_gain(power[peak]) - offset**2
        if free[peak] and abs(offset) <= 1.0 and gain > most:
            best, most = peak, gain
    return best, most


@compiled
def _power_gain(power: float) -> float:
    """What a peak's power adds to a score."""
    return min(POWER_GAIN * max(power - THRESHOLD_POWER, 0.0), MOST_GAIN)
