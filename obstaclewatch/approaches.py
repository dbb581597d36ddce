"""Tracks of what closes in: found as a line through the peaks of many beeps, then followed by a Kalman filter.

Range r and closing speed v are those of the beep's centre as it is hit. The chirp reads r - v x range_doppler_s, and
that is the filter's measurement: its ranges have no range-Doppler bias.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.courses import Samples
from obstaclewatch.moving_peaks import MovingPeaks

Array = NDArray[np.float64]
Heard = tuple[float, float, float, NDArray[np.complex64]]

SPEEDS_M_S = np.arange(0.5, 3.3, 0.15)
SEARCH_BEEPS = 12
GATE_M = 0.09
"""How far a peak may be from a line: 1 cm of surge, 2.6 cm of its range-Doppler coupling, 6 cm of a coarse speed."""
HIT, MISS = 1.9, -1.1
"""Log likelihood ratios: a peak lies within the gate of an echo in 7 beeps of 10, of nothing in 1 of 10."""
POWER_GAIN, MOST_GAIN = 0.25, 3.0
"""What a peak's power above the usual threshold adds, at most."""
THRESHOLD_POWER = 4.0
START_SCORE = 8.0
"""exp(8) outweighs 3,000 of the 7,000 lines that are tried at every beep; the rest is left to what follows."""
MOST_SCORE = 25.0
LEAST_SPEED_M_S = 0.3
MOST_MISSES = 7
KEPT_BEEPS = 16
SURGE_READ_M = 0.025
"""Deviation of a reading by gait: what the surge's speed reads through range-Doppler coupling."""
ACCELERATION_M_S2 = 0.35
GATE_DEVIATIONS = 3.5


@dataclass
class Track:
    """One obstacle that closes in.

    Attributes:
        state: (2,) range, m, and closing speed, m/s, at `time_s`.
        covariance: (2, 2).
        time_s: of the state: when the beep's centre meets the obstacle, about.
        score: log likelihood ratio of being real.
        level_db, snr_db: of its last peak.
        misses: beeps since that peak.
        past: the last beeps' peaks: time, range, its deviation, and microphone 1 around it.
    """

    state: Array
    covariance: Array
    time_s: float
    score: float
    level_db: float = np.nan
    snr_db: float = np.nan
    misses: int = 0
    past: deque[Heard] = field(default_factory=lambda: deque(maxlen=KEPT_BEEPS))

    def predict(self, time_s: float) -> None:
        """Move the state to another time, under white acceleration."""
        step = time_s - self.time_s
        move = np.array([[1.0, -step], [0.0, 1.0]])
        jolt = np.array([0.5 * step**2, -step]) * ACCELERATION_M_S2
        self.state = move @ self.state
        self.covariance = move @ self.covariance @ move.T + np.outer(jolt, jolt)
        self.time_s = time_s

    def expected(self, ahead_s: float) -> tuple[float, float]:
        """What a chirp would read, m, and its variance."""
        look = np.array([1.0, -ahead_s])
        return float(look @ self.state), float(look @ self.covariance @ look)

    def update(self, read_m: float, variance: float, ahead_s: float) -> None:
        """Kalman's update by a reading."""
        look = np.array([1.0, -ahead_s])
        gain = self.covariance @ look / (look @ self.covariance @ look + variance)
        self.state = self.state + gain * (read_m - look @ self.state)
        self.covariance = self.covariance - np.outer(gain, look @ self.covariance)

    def remember(self, time_s: float, peaks: MovingPeaks, which: int) -> None:
        """Keep a peak for the judgement of the course."""
        self.past.append((time_s, float(peaks.range_m[which]), float(peaks.range_std_m[which]), peaks.second[which]))
        self.level_db, self.snr_db = float(peaks.level_db[which]), float(peaks.snr_db[which])

    def samples(self, ahead_s: float) -> Samples:
        """What was measured, at the times that the readings stand for."""
        time, read, deviation, second = zip(*self.past, strict=True)
        return Samples(np.array(time) + ahead_s, np.array(read), np.array(deviation), np.stack(second))


class Approaches:
    """All tracks.

    Args:
        ahead_s: how far ahead the chirp reads, `BeepDesign.range_doppler_s`.
    """

    def __init__(self, ahead_s: float) -> None:
        self._ahead_s = ahead_s
        self.tracks: list[Track] = []
        self._free: deque[tuple[float, MovingPeaks, NDArray[np.bool_]]] = deque(maxlen=SEARCH_BEEPS)

    def clear(self) -> None:
        """Forget everything."""
        self.tracks.clear()
        self._free.clear()

    def step(self, time_s: float, peaks: MovingPeaks) -> list[Track]:
        """Follow the tracks to a beep's peaks, start and end tracks; returns those there are, nearest first."""
        taken = np.zeros(len(peaks), dtype=bool)
        for track in sorted(self.tracks, key=lambda track: -track.score):
            self._follow(track, time_s, peaks, taken)
        self.tracks = [track for track in self.tracks if _lives(track)]
        self._start(time_s, peaks, taken)
        self._free.append((time_s, peaks, ~taken))
        self._part()
        self.tracks.sort(key=lambda track: track.state[0])
        return self.tracks

    def _follow(self, track: Track, time_s: float, peaks: MovingPeaks, taken: NDArray[np.bool_]) -> None:
        track.predict(time_s)
        expected_m, spread = track.expected(self._ahead_s)
        variance = SURGE_READ_M**2 + peaks.range_std_m**2
        distance2 = (peaks.range_m - expected_m) ** 2 / (spread + variance)
        merit = np.where(taken | (distance2 > GATE_DEVIATIONS**2), -np.inf, np.log(peaks.power) - 0.5 * distance2)
        if len(peaks) == 0 or not np.isfinite(merit.max()):
            track.misses += 1
            track.score += MISS
            return
        best = int(np.argmax(merit))
        taken[best] = True
        track.update(float(peaks.range_m[best]), float(variance[best]), self._ahead_s)
        track.remember(time_s, peaks, best)
        track.misses = 0
        track.score = min(track.score + HIT + float(_power_gain(peaks.power[best])), MOST_SCORE)

    def _start(self, time_s: float, peaks: MovingPeaks, taken: NDArray[np.bool_]) -> None:
        """Tracks from peaks that no track has taken, if a line leads to them."""
        here = np.flatnonzero(~taken)
        if len(self._free) < 4 or len(here) == 0:
            return
        age_s = np.array([time_s - past for past, _, _ in self._free])
        width = max(len(past) for _, past, _ in self._free)
        if width == 0:
            return
        ranges = _padded([np.where(free, past.range_m, np.nan) for _, past, free in self._free], width)
        gains = _padded([_power_gain(past.power) for _, past, _ in self._free], width)
        line = peaks.range_m[here, None, None] + SPEEDS_M_S[:, None] * age_s
        offset = np.abs(line[..., None] - ranges)
        gain = np.where(offset <= GATE_M, HIT + gains - 4.0 * (offset / GATE_M) ** 2 * 0.25, -np.inf)
        partner = np.argmax(gain, axis=-1)
        best = np.take_along_axis(gain, partner[..., None], axis=-1)[..., 0]
        steps = np.where(np.isfinite(best), best, MISS)
        newest_first = np.cumsum(steps[..., ::-1], axis=-1)
        score = newest_first.max(axis=-1)
        for row in np.argsort(-score.max(axis=1)):
            speed = int(np.argmax(score[row]))
            if score[row, speed] < START_SCORE or taken[here[row]]:
                continue
            beeps = np.arange(len(age_s)) >= len(age_s) - 1 - int(np.argmax(newest_first[row, speed]))
            chosen = np.flatnonzero(beeps & np.isfinite(best[row, speed]))
            self._begin(time_s, peaks, int(here[row]), chosen, partner[row, speed], float(score[row, speed]))
            taken[here[row]] = True

    def _begin(
        self,
        time_s: float,
        peaks: MovingPeaks,
        here: int,
        beeps: NDArray[np.intp],
        partner: NDArray[np.intp],
        score: float,
    ) -> None:
        """A track along a line: least squares through the peaks on it, then remembered as if followed."""
        chain = [(*self._free[k][:2], int(partner[k])) for k in beeps] + [(time_s, peaks, here)]
        age = np.array([time_s - past for past, _, _ in chain])
        read = np.array([found.range_m[which] for _, found, which in chain])
        design = np.stack([np.ones(len(age)), age], axis=1)
        inverse = np.linalg.inv(design.T @ design)
        read_m, speed = inverse @ design.T @ read
        if not speed >= LEAST_SPEED_M_S:
            return
        to_state = np.array([[1.0, self._ahead_s], [0.0, 1.0]])
        covariance = to_state @ inverse @ to_state.T * 4.0 * SURGE_READ_M**2
        track = Track(np.array([read_m + speed * self._ahead_s, speed]), covariance, time_s, min(score, MOST_SCORE))
        for past_s, found, which in chain:
            track.remember(past_s, found, which)
        for k in beeps:
            self._free[k][2][partner[k]] = False
        self.tracks.append(track)

    def _part(self) -> None:
        """Of two tracks that have become one, the better stays."""
        kept: list[Track] = []
        for track in sorted(self.tracks, key=lambda track: (-len(track.past), -track.score)):
            twin = any(np.all(np.abs(track.state - other.state) < [0.08, 0.4]) for other in kept)
            if not twin:
                kept.append(track)
        self.tracks = kept


def _lives(track: Track) -> bool:
    """Still heard, still closing in, still ahead."""
    heard = track.score > 0.0 and track.misses <= MOST_MISSES
    return heard and track.state[1] >= LEAST_SPEED_M_S and track.state[0] > 0.1


def _power_gain(power: Array) -> Array:
    return np.minimum(POWER_GAIN * np.maximum(power - THRESHOLD_POWER, 0.0), MOST_GAIN)


def _padded(rows: list[Array], width: int) -> Array:
    """(K, width), filled up with NaN."""
    padded = np.full((len(rows), width), np.nan)
    for line, row in zip(padded, rows, strict=True):
        line[: len(row)] = row
    return padded
