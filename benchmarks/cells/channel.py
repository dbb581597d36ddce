"""What happens to a recording between microphones and detector: gains, lags, clock, clipping, equal channels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from benchmarks.cells.spec import RecordingChange
from obstaclewatch.recording import Recording

SPLINE_ORDER = 5
"""Of the resampling; on 23 kHz at 192 kHz a quintic spline is off by 3e-4 of the amplitude."""


def through_channel(recording: Recording, change: RecordingChange) -> Recording:
    """The recording as the detector gets it, as long as before.

    Raises:
        ValueError: a channel that lags by more than the recording.
    """
    if change == RecordingChange():
        return recording
    count = recording.samples.shape[1]
    if max(change.mic_delay_samples) > count:
        raise ValueError(
            f"mic_delay_samples must be within the recording's {count} samples, got {change.mic_delay_samples}"
        )
    samples = recording.samples * (10.0 ** (np.array(change.mic_gain_db, dtype=np.float32)[:, None] / 20.0))
    samples = np.stack([_lagged(channel, lag) for channel, lag in zip(samples, change.mic_delay_samples, strict=True)])
    samples = _on_clock(samples, change.clock_ppm)
    if change.clip_level is not None:
        samples = np.clip(samples, -change.clip_level, change.clip_level)
    if change.identical:
        samples = np.stack([samples[0], samples[0]])
    return replace(recording, samples=samples.astype(np.float32))


def _lagged(channel: NDArray[np.floating], lag: int) -> NDArray[np.floating]:
    return np.concatenate([np.zeros(lag, dtype=channel.dtype), channel[: len(channel) - lag]])


def _on_clock(samples: NDArray[np.floating], ppm: float) -> NDArray[np.floating]:
    """Sample k is what the true clock's sample k / (1 + ppm 1e-6) was."""
    if ppm == 0.0:
        return samples
    at = np.arange(samples.shape[1]) / (1.0 + 1e-6 * ppm)
    return np.stack([ndimage.map_coordinates(row, at[None], order=SPLINE_ORDER, mode="nearest") for row in samples])
