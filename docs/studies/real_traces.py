"""Recorded magnitude traces of real phones (LibAcousticSensing) through the stages that accept them.

The traces hold no phase, so compression and bearings are out of reach; what remains is the decision whether something
is there, the vote over beeps, and the range over time. One rule serves all traces: a height counts where it exceeds the
clutter map of the same phone's baseline, recorded without an object, by a factor that follows from the baselines alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.paper.collision import CollisionVote
from obstaclewatch.signal.background import ClutterMap
from obstaclewatch.signal.echoes import refine_peaks, separated_peaks
from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.tracking.kalman import expected_reading, predicted, updated
from obstaclewatch.tracking.tracks import ACCELERATION_M_S2

ZONE_M = (1.6, 3.5)
"""Where objects were: beyond the floor's echo at 1.35 m, before the end of the traces."""
NOISE_M = (3.6, 4.2)
MAP_HALF_WIDTH = 7
"""Bins (of 1.43 cm) by which a standing echo may wander: hands move by 10 cm."""
LABEL_M = (-0.55, 0.15)
"""Where the first line of a labelled object may lie: 0.5 m short of the mark to 0.04 m beyond (arm length)."""
CHIRP_AHEAD_S = 21_000.0 / (6_000.0 / 0.025)
"""Range-Doppler coupling of the recorded chirp, 18-24 kHz in 25 ms."""
TRACK_GATE_M = 0.09
OUT_OF_NOISE = 3.0
"""Multiple of the noise's median that a followed peak must reach, the factor of the paper's threshold."""
READING_M = 0.01
"""Deviation of a peak of the rectified correlation, whose ripple is 0.9 cm long."""


@dataclass(frozen=True)
class Trace:
    """One recording.

    Attributes:
        name, phone: labels; phones of one name share a baseline.
        level: (K, R, C) magnitude over the noise's median, far from everything.
        range_m: (R,) of the bins.
        time_s: (K,) of the beeps.
        hold: (K,) the user stood at the mark.
        object_m: nominal distance of the object; NaN without one.
        wall_m: (K,) first line as followed by eye and dynamic programming; NaN where it was not.
        wall_channel: channel in which it was followed.
    """

    name: str
    phone: str
    level: Floats
    range_m: Floats
    time_s: Floats
    hold: Flags
    object_m: float
    wall_m: Floats
    wall_channel: int

    @property
    def step_m(self) -> float:
        """Width of a bin."""
        return float(self.range_m[1] - self.range_m[0])


def load_trace(path: Path) -> Trace:
    """Read a trace file."""
    with np.load(path) as stored:
        held = stored["hold"] & stored["valid"]
        magnitude, range_m = stored["mag"].astype(np.float64), stored["range_m"]
        far = (range_m > NOISE_M[0]) & (range_m < NOISE_M[1])
        wall = stored["wall_channel"]
        return Trace(
            name=path.stem,
            phone=str(stored["phone"]),
            level=magnitude / np.median(magnitude[held][:, far], axis=(0, 1)),
            range_m=range_m,
            time_s=stored["t_s"],
            hold=held,
            object_m=float(stored["object_m_nominal"]),
            wall_m=stored["wall_m"],
            wall_channel=int(wall) - 1 if np.isfinite(wall) else 0,
        )


@dataclass(frozen=True)
class BaselineRule:
    """What the baselines say about nothing.

    Attributes:
        clutter: mean height, (R,) per phone and channel.
        factor: multiple of it that a height must exceed.
    """

    clutter: dict[tuple[str, int], Floats]
    factor: float

    def threshold(self, trace: Trace, channel: int) -> Floats:
        """(R,) height above which something is there."""
        return self.factor * self.clutter[trace.phone, channel]


def learn(baselines: Sequence[Trace], halves: tuple[int, int] = (0, 1)) -> BaselineRule:
    """A clutter map from one half of each baseline's hold, and the factor that the other half never exceeds.

    Args:
        baselines: traces without an object.
        halves: which half the map is learned from, and which the factor.
    """
    clutter, scores = {}, []
    for trace in baselines:
        for channel in range(trace.level.shape[2]):
            pieces = np.array_split(trace.level[trace.hold, :, channel], 2)
            mean = _mean_clutter(pieces[halves[0]])
            clutter[trace.phone, channel] = mean
            scores.append(_scores(pieces[halves[1]], mean, trace.range_m))
    return BaselineRule(clutter, float(np.max(np.concatenate(scores))))


def false_detections(rule: BaselineRule, baselines: Sequence[Trace], half: int) -> tuple[int, int]:
    """(false, all) beeps of a half of each baseline's hold in which any channel exceeds the rule in the zone."""
    false = total = 0
    for trace in baselines:
        above = [
            _scores(np.array_split(trace.level[trace.hold, :, c], 2)[half], rule.clutter[trace.phone, c], trace.range_m)
            > rule.factor
            for c in range(trace.level.shape[2])
        ]
        false += int(np.any(above, axis=0).sum())
        total += len(above[0])
    return false, total


def objects_at_label(trace: Trace, rule: BaselineRule) -> Floats:
    """(K, C) range of the peak of each beep and channel that exceeds the rule most where the object was labelled.

    NaN if none does.
    """
    best = np.full((len(trace.level), trace.level.shape[2]), np.nan)
    for channel in range(best.shape[1]):
        threshold = rule.threshold(trace, channel)
        for beep in range(len(best)):
            ranges = _peaks_m(trace, beep, channel, threshold)
            ranges = ranges[(ranges > trace.object_m + LABEL_M[0]) & (ranges < trace.object_m + LABEL_M[1])]
            if len(ranges):
                excess = (trace.level[beep, :, channel] / threshold)[_bins(trace, ranges)]
                best[beep, channel] = ranges[np.argmax(excess)]
    return best


def track_from_hold(trace: Trace, rule: BaselineRule) -> Floats:
    """(K,) range of the object, from its median range while the user stood at the mark, forwards and backwards.

    Only the span over which the authors' line was followed is tracked; NaN elsewhere.
    """
    held = np.flatnonzero(trace.hold)
    spanned = np.flatnonzero(np.isfinite(trace.wall_m))
    start_m = float(np.nanmedian(objects_at_label(trace, rule)[held, trace.wall_channel]))
    middle = int(held[len(held) // 2])
    track = np.full(len(trace.time_s), np.nan)
    for beeps in (range(middle, spanned[-1] + 1), range(middle, spanned[0] - 1, -1)):
        track[list(beeps)] = follow(trace, start_m, beeps, trace.wall_channel)
    return track


def voted(present: Flags) -> Flags:
    """(K,) the paper's vote, five of the last nine beeps."""
    vote = CollisionVote(5, 9)
    return np.array([vote.cast(bool(beep)) >= 5 for beep in present])


def follow(trace: Trace, start_m: float, beeps: Sequence[int], channel: int) -> Floats:
    """(len(beeps),) ranges of a Kalman track that starts at a range and takes the strongest peak near it in each beep.

    "Near" is a gate of 9 cm on either side, as the tracking detector's; the first and strongest line of an object is
    followed by weaker ones 15-60 cm behind it, which the nearest peak would fall for.

    Args:
        trace: the recording.
        start_m: range at the first of the beeps.
        beeps: indices, in order of time or against it.
        channel: which microphone.
    """
    sign = 1.0 if beeps[-1] >= beeps[0] else -1.0
    state, covariance = np.array([start_m, 0.0]), np.diag([0.02**2, 0.3**2])
    ahead_s, step_s = sign * CHIRP_AHEAD_S, np.diff(sign * trace.time_s[beeps], prepend=sign * trace.time_s[beeps[0]])
    ranges = np.full(len(beeps), np.nan)
    for place, beep in enumerate(beeps):
        state, covariance = predicted(state, covariance, step_s[place], ACCELERATION_M_S2)
        reading = _strongest_near(trace, beep, channel, expected_reading(state, covariance, ahead_s)[0])
        if np.isfinite(reading):
            state, covariance = updated(state, covariance, reading, READING_M**2, ahead_s)
        ranges[place] = expected_reading(state, covariance, ahead_s)[0]
    return ranges


def _mean_clutter(level: Floats) -> Floats:
    clutter = ClutterMap(len(level), MAP_HALF_WIDTH)
    for row in level:
        clutter.level(row)
    return clutter.level(level[-1])


def _scores(level: Floats, clutter: Floats, range_m: Floats) -> Floats:
    """(K,) highest ratio of height to clutter within the zone."""
    zone = (range_m > ZONE_M[0]) & (range_m < ZONE_M[1])
    ratio: Floats = (level / clutter)[:, zone].max(axis=1)
    return ratio


def _peaks_m(trace: Trace, beep: int, channel: int, threshold: Floats) -> Floats:
    row = trace.level[beep, :, channel]
    position = refine_peaks(row, separated_peaks(row, threshold, 2))[0]
    ranges: Floats = trace.range_m[0] + position * trace.step_m
    return ranges


def _strongest_near(trace: Trace, beep: int, channel: int, expected_m: float) -> float:
    """Range of the strongest peak within the gate that stands out of the noise; NaN if there is none."""
    peaks = _peaks_m(trace, beep, channel, np.full(len(trace.range_m), OUT_OF_NOISE))
    peaks = peaks[np.abs(peaks - expected_m) < TRACK_GATE_M]
    return float(peaks[np.argmax(trace.level[beep, _bins(trace, peaks), channel])]) if len(peaks) else np.nan


def _bins(trace: Trace, range_m: Floats) -> NDArray[np.intp]:
    return np.round((range_m - trace.range_m[0]) / trace.step_m).astype(np.intp)
