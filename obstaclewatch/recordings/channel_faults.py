"""What a channel's samples and the two channels' own noise show, whatever the beep: levels, steps, offset, polarity."""

from __future__ import annotations

import numpy as np
import scipy

from obstaclewatch.recording import Recording
from obstaclewatch.recordings.faults import Fault, Finding
from obstaclewatch.recordings.sample_faults import quantisation_step
from obstaclewatch.support.arrays import Singles

LOUDEST = 1e3
"""Times full scale: files of floating point may pass it by some dB, never by 60."""
OFFSET_SHARE = 0.1
"""Of half a channel's range; microphones are AC coupled, and converters offset some 1e-3."""
FEWEST_LEVELS = 64
"""Between a channel's extremes: 6 bits, whose steps are 36 dB below a full beep and above most echoes."""
AMBIENT_HZ = (60.0, 500.0)
"""Where microphones 16 cm apart receive the surroundings alike: the wavelength is 0.7 m and more."""
OPPOSED = -0.7
SEGMENT_S, FEWEST_SEGMENTS = 0.1, 5
"""Correlations are taken over segments, and their median counts: where a recording begins within a beep or lacks
samples, the jump rings below 500 Hz with the phases of the beep, for less than a segment."""
LEAST_AMBIENT_STEPS = 1.0


def absurd_level(recording: Recording) -> Finding | None:
    """Samples that no converter writes, and that overflow single precision when squared."""
    top = float(np.abs(recording.samples).max())
    if top <= LOUDEST:
        return None
    return Finding(Fault.ABSURD_LEVEL, f"samples reach {top:.3g} times full scale: these are no samples of a recorder")


def constant_offset(recording: Recording) -> Finding | None:
    """The channel with the largest offset from zero, against its range."""
    low, high = recording.samples.min(axis=1), recording.samples.max(axis=1)
    half = np.maximum(0.5 * (high.astype(np.float64) - low), np.finfo(np.float64).tiny)
    offset = np.asarray(np.mean(recording.samples, axis=1, dtype=np.float64))
    worst = int(np.argmax(np.abs(offset) / half))
    if abs(offset[worst]) <= OFFSET_SHARE * half[worst]:
        return None
    return Finding(
        Fault.OFFSET,
        f"microphone {worst} lies {offset[worst]:+.3g} of full scale off zero, its sound is {half[worst]:.3g} high",
    )


def coarse_steps(recording: Recording) -> Finding | None:
    """The channel with the fewest levels; a channel of floating point, or without sound, has none."""
    levels = [_levels(row) for row in recording.samples]
    worst = int(np.argmin(levels))
    if levels[worst] >= FEWEST_LEVELS:
        return None
    return Finding(
        Fault.COARSE_STEPS,
        f"microphone {worst} has {levels[worst]:.0f} steps from top to bottom, {np.log2(levels[worst]):.1f} bits: "
        "echoes are lost between them",
    )


def inverted_channel(recording: Recording) -> Finding | None:
    """The surroundings reach both microphones alike; where they do so with opposite sign, a channel is inverted.

    Not told by the beep: a phone's channels differ by any phase at 20 kHz. Nor without sound below 500 Hz.
    """
    rate = recording.sample_rate_hz
    length = round(SEGMENT_S * rate)
    count = recording.samples.shape[1] // length
    if count < FEWEST_SEGMENTS:
        return None
    filtered = scipy.signal.sosfiltfilt(
        scipy.signal.butter(2, AMBIENT_HZ, "bandpass", fs=rate, output="sos"),
        recording.samples.astype(np.float64),
        axis=1,
    )
    power = np.sum(filtered**2, axis=1)
    steps = [quantisation_step(row) for row in recording.samples]
    least = LEAST_AMBIENT_STEPS * np.array(steps) * np.sqrt(filtered.shape[1])
    if (power <= np.maximum(least**2, np.finfo(np.float64).tiny)).any():
        return None
    first, second = filtered[:, : count * length].reshape(2, count, length)
    scale = np.sqrt(np.sum(first**2, axis=1) * np.sum(second**2, axis=1))
    alike = float(np.median(np.sum(first * second, axis=1) / np.maximum(scale, np.finfo(np.float64).tiny)))
    if alike > OPPOSED:
        return None
    return Finding(
        Fault.INVERTED_CHANNEL,
        f"sound below {AMBIENT_HZ[1]:g} Hz correlates by {alike:.2f} between the microphones: one is inverted",
    )


def _levels(row: Singles) -> float:
    """Quantisation steps between the extremes of a channel; infinite where there are no steps."""
    step = quantisation_step(row)
    return float(row.max() - row.min()) / step if step > 0.0 else np.inf
