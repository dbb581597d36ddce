"""An echogram: echo level over time and range, with a detector's candidates and alerts on it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from obstaclewatch import BeepDesign, Detection, MatchedFilter, PhoneGeometry, Recording

DYNAMIC_DB = 60.0
SPEED_M_S = 343.0
REACH_M = 7.0


def draw_echogram(
    recording: Recording, beep: BeepDesign, phone: PhoneGeometry, found: Sequence[Detection], path: Path
) -> None:
    """Draw microphone 0's envelope, beep after beep, as PNG."""
    levels, range_m = _levels(recording, beep, found)
    time = np.array([detection.time_s for detection in found])
    figure = Figure(figsize=(10, 5.5), layout="constrained")
    axes = figure.subplots()
    edges = np.append(time, time[-1] + beep.period_s)
    image = axes.pcolormesh(edges, range_m, levels, cmap="magma", vmin=-DYNAMIC_DB, vmax=0.0, rasterized=True)
    figure.colorbar(image, ax=axes, label="envelope, dB re direct sound")
    for detection in found:
        hit = np.asarray(detection.collides, dtype=bool)
        for mask, color in ((~hit, "#7fd3ff"), (hit, "#ff4d4d")):
            axes.plot(np.full(mask.sum(), detection.time_s), detection.range_m[mask], ".", color=color, markersize=5)
        if detection.decision.alert:
            axes.axvspan(detection.time_s, detection.time_s + beep.period_s, color="#ff4d4d", alpha=0.25, linewidth=0)
    axes.set(xlabel="time, s", ylabel="range, m", title=f"{phone.name}: candidates blue, on course red, alerts shaded")
    figure.savefig(path, dpi=120, metadata={"Software": None})


def _levels(recording: Recording, beep: BeepDesign, found: Sequence[Detection]) -> tuple[np.ndarray, np.ndarray]:
    """(ranges, beeps) level over the beep's direct peak, and the range edges."""
    filter_ = MatchedFilter(beep, 2.0 * REACH_M / SPEED_M_S)
    columns: list[np.ndarray] = []
    delay = np.zeros(0)
    for detection in found:
        begin = max(round(detection.time_s * recording.sample_rate_hz), 0)
        block = recording.samples[:, begin : begin + beep.period_samples]
        block = np.pad(block, ((0, 0), (0, beep.period_samples - block.shape[1])))
        profile = filter_.compress(block)
        delay = profile.delay_s
        columns.append(np.abs(profile.envelope[0]))
    magnitude = np.stack(columns, axis=1)
    level = 20.0 * np.log10(np.maximum(magnitude, 1e-12) / magnitude.max(axis=0, keepdims=True))
    step = 0.5 * SPEED_M_S * (delay[1] - delay[0])
    kept = 0.5 * SPEED_M_S * delay <= REACH_M
    return level[kept], np.append(0.5 * SPEED_M_S * delay[kept], 0.5 * SPEED_M_S * delay[kept][-1] + step)
