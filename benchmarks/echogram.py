"""An echogram: echo level over time and range, with a detector's candidates, their track and its alerts on it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from obstaclewatch import BeepDesign, Detection, MatchedFilter, Recording
from obstaclewatch.recordings.sample_feed import SampleFeed
from obstaclewatch.support.whole_file import whole_file

LEVELS_DB = (-80.0, -20.0)
"""From the noise of quiet recordings to the nearest wall; the direct sound itself may burn out."""
SPEED_M_S = 343.0
REACH_M = 7.0
MOST_COLUMNS = 2000
OTHER, ALERT, RING = "#1f77d0", "#e0202a", "#1d2430"
"""Colours of candidates, of those on a collision course and of alerts, and of what decisions are about."""


@dataclass
class Columns:
    """The detections that a picture shows: all of a short recording, every so many of a long one.

    Attributes:
        kept: in the order of time, at most `MOST_COLUMNS`.
        stride: every how many beeps one is kept.
        alerts_s: times of all alerts.
    """

    kept: list[Detection] = field(default_factory=list)
    stride: int = 1
    alerts_s: list[float] = field(default_factory=list)

    def add(self, detection: Detection) -> None:
        """Take the next detection in."""
        if detection.decision.alert:
            self.alerts_s.append(detection.time_s)
        if detection.index % self.stride == 0:
            self.kept.append(detection)
        if len(self.kept) > MOST_COLUMNS:
            self.stride *= 2
            self.kept = [one for one in self.kept if one.index % self.stride == 0]


def draw_echogram(pieces: Iterable[Recording], beep: BeepDesign, title: str, columns: Columns, path: Path) -> None:
    """Draw microphone 0's envelope, beep after beep, as PNG.

    Args:
        pieces: the recording once more, in any pieces; it is never held whole.
        beep: the emitted signal.
        title: whose recording and which detector.
        columns: what was detected.
        path: where to.

    Raises:
        ValueError: nothing was detected, not even a beep.
    """
    if not columns.kept:
        raise ValueError("an echogram needs at least one whole beep, got none")
    levels, range_m = beep_levels(pieces, beep, [detection.time_s for detection in columns.kept])
    time = np.array([detection.time_s for detection in columns.kept])
    width_s = columns.stride * beep.period_s
    figure = Figure(figsize=(10, 5.5), layout="constrained")
    axes = figure.subplots()
    edges = np.append(time, time[-1] + width_s)
    image = axes.pcolormesh(edges, range_m, levels, cmap="Greys", vmin=LEVELS_DB[0], vmax=LEVELS_DB[1], rasterized=True)
    figure.colorbar(image, ax=axes, label="envelope (dB re direct sound)")
    _mark_candidates(axes, columns, 0.5 * width_s)
    for k, alert_s in enumerate(columns.alerts_s):
        label = "alert" if k == 0 else None
        axes.axvspan(alert_s, alert_s + beep.period_s, color=ALERT, alpha=0.2, linewidth=0, label=label)
    axes.set(xlabel="time (s)", ylabel="range (m)", ylim=(0.0, range_m[-1]))
    axes.set_title(title, fontsize=11)
    figure.legend(loc="outside lower center", ncols=4, fontsize=9, frameon=False)
    with whole_file(path) as partial:
        figure.savefig(partial, format="png", dpi=120, metadata={"Software": None})


def _mark_candidates(axes: Axes, columns: Columns, middle_s: float) -> None:
    """Dots for candidates in the middle of their column, and rings at what the decisions are about."""
    for on_course, color, label in ((False, OTHER, "candidate"), (True, ALERT, "candidate on a collision course")):
        points = [
            (detection.time_s + middle_s, range_m)
            for detection in columns.kept
            for range_m, hit in zip(detection.range_m, detection.collides, strict=True)
            if bool(hit) is on_course
        ]
        axes.plot(*np.array(points).reshape(-1, 2).T, ".", color=color, markersize=7, label=label, zorder=3)
    track = [(detection.time_s + middle_s, detection.decision.range_m) for detection in columns.kept]
    axes.plot(
        *np.array(track).T, "o", color=RING, markersize=10, markeredgewidth=1.3, markerfacecolor="none", zorder=4,
        label="range that the decision is about",
    )  # fmt: skip


def beep_levels(
    pieces: Iterable[Recording], beep: BeepDesign, time_s: Sequence[float]
) -> tuple[np.ndarray, np.ndarray]:
    """Microphone 0's envelope after every one of some beeps.

    Args:
        pieces: the recording, in any pieces.
        beep: the emitted signal.
        time_s: (T,) when the beeps left, in order.

    Returns:
        (R, T) levels, dB re the highest peak after each beep, and (R + 1,) edges of the ranges.
    """
    reach_s = min(2.0 * REACH_M / SPEED_M_S, beep.period_s - 3e-3)
    compressor = MatchedFilter(beep, reach_s)
    feed = SampleFeed(pieces, beep.sample_rate_hz)
    heights = []
    delay_s = np.zeros(0)
    for emitted_s in time_s:
        begin = max(round(emitted_s * beep.sample_rate_hz), 0)
        feed.forget(begin)
        block = feed.take(begin, begin + beep.period_samples)
        profile = compressor.compress(np.pad(block, ((0, 0), (0, beep.period_samples - block.shape[1]))))
        delay_s = profile.delay_s
        heights.append(profile.magnitude[0])
    magnitude = np.stack(heights, axis=1)
    level = 20.0 * np.log10(np.maximum(magnitude, 1e-12) / np.maximum(magnitude.max(axis=0, keepdims=True), 1e-12))
    step = 0.5 * SPEED_M_S * (delay_s[1] - delay_s[0])
    range_m = 0.5 * SPEED_M_S * delay_s
    return level, np.append(range_m, range_m[-1] + step)
