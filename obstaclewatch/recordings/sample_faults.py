"""Damage that shows in the samples themselves: flat tops, gaps of zeros, equal channels, gain that drops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import Flag
from obstaclewatch.signal.direct_sound import DirectSound
from obstaclewatch.support.arrays import Flags, Floats, Singles

LEAST_STEPS = 200
"""Height in quantisation steps below which equal samples at the top are no sign of clipping."""
COPY_DB = -60.0
"""What is left of one channel after the best multiple of the other, below which the two are one."""
ZERO_RUN_S = 0.25e-3
GAIN_BAND_HZ = (2_000.0, 14_000.0)
"""Where noise shows the recorder's gain: above speech's strongest part, below the beep."""
GAIN_BAND_GUARD_HZ = 2_000.0
GAIN_STEP_S = 5e-3
LEAST_NOISE_STEPS = 0.5
"""Rms of that noise in quantisation steps, below which it does not follow the gain."""
DEAF = 1e-3
"""Of the direct sound at microphone 0: a microphone 1 that receives less of it is deaf; phones have -8 to -35 dB."""


def clipped_share(samples: Singles, sounding: int) -> Floats:
    """(2,) samples at the very top or bottom, as a share of those during which a beep sounds.

    A clean beep touches its extremes once. Recordings of less than `LEAST_STEPS` steps of height give 0.

    Args:
        samples: (2, N).
        sounding: samples of a channel during which a beep sounds.
    """
    shares = np.zeros(2)
    for channel, row in enumerate(samples):
        top, bottom = row.max(), row.min()
        if max(top, -bottom) <= LEAST_STEPS * quantisation_step(row):
            continue
        shares[channel] = max(np.sum(row == top) - 1, np.sum(row == bottom) - 1) / max(sounding, 1)
    return shares


def quantisation_step(row: Singles) -> float:
    """Least difference of two samples of a channel, found among the quiet ones; 0 for floating point noise."""
    small = np.unique(np.abs(row))[:200].astype(np.float64)
    steps = np.diff(small)
    least = float(steps.min()) if len(steps) else 0.0
    integer = least > 0.0 and bool(np.all(np.abs(steps / least - np.round(steps / least)) < 1e-3))
    return least if integer else 0.0


def one_is_the_other(samples: NDArray[np.floating]) -> bool:
    """Whether one channel is a multiple of the other: a mono recording in two channels."""
    one, two = np.asarray(samples, dtype=np.float64)
    energy = one @ one, two @ two
    if min(energy) == 0.0:
        return False
    left = energy[1] - (one @ two) ** 2 / energy[0]
    return bool(left <= energy[1] * 10.0 ** (COPY_DB / 10.0))


def flag_of_second(block: NDArray[np.floating], direct: DirectSound) -> Flag:
    """Why microphone 1 says nothing in a beep (2, n) with that direct sound: it is deaf, or no channel of its own."""
    if direct.amplitude[1] < DEAF * direct.amplitude[0]:
        return Flag.NO_SECOND_MIC
    return Flag.IDENTICAL_CHANNELS if one_is_the_other(block) else Flag.NONE


def longest_zero_runs(samples: Singles) -> NDArray[np.intp]:
    """(2, 2) start and length of each channel's longest run of exact zeros."""
    return np.array([_longest_run(row == 0.0) for row in samples])


def _longest_run(flag: Flags) -> tuple[int, int]:
    edges = np.flatnonzero(np.diff(flag.astype(np.int8), prepend=0, append=0))
    starts, ends = edges[::2], edges[1::2]
    if len(starts) == 0:
        return 0, 0
    longest = int(np.argmax(ends - starts))
    return int(starts[longest]), int(ends[longest] - starts[longest])


def gain_dip_db(periods: Singles, beep: BeepDesign) -> tuple[float, float]:
    """How far the noise beside the beep's band sinks while a beep sounds: the depth of a limiter's work.

    Args:
        periods: (K, period_samples) beep periods of one channel, each starting at an emission.
        beep: the emitted signal.

    Returns:
        Depth, dB, of the lowest of the 5 ms steps during the beep below the highest after it; and the standard
        deviation of that figure. (nan, nan) if there is no noise to measure.
    """
    power = _beside_the_band(periods, beep)
    if power is None:
        return np.nan, np.nan
    width = round(GAIN_STEP_S * beep.sample_rate_hz)
    count = power.shape[1] // width
    steps = power[:, : count * width].reshape(len(power), count, width).mean(axis=2)
    level = np.median(steps, axis=0)
    middle = (np.arange(count) + 0.5) * GAIN_STEP_S
    sounding = (middle > 0.2 * beep.duration_s) & (middle < beep.duration_s)
    # Below the band, noise is stronger and jumps from a period's end to its start: the last step shows that.
    after = (middle > beep.duration_s) & (middle < (count - 1) * GAIN_STEP_S)
    if not (sounding.any() and after.any()) or level.min() <= 0.0:
        return np.nan, np.nan
    low, high = _band(beep)
    deviation = 1.25 * 4.34 * np.sqrt(2.0 / ((high - low) * GAIN_STEP_S * len(power)))
    return float(10.0 * np.log10(level[after].max() / level[sounding].min())), float(deviation)


def _band(beep: BeepDesign) -> tuple[float, float]:
    lowest = min(beep.start_hz, beep.stop_hz)
    return GAIN_BAND_HZ[0], min(GAIN_BAND_HZ[1], lowest - GAIN_BAND_GUARD_HZ)


def _beside_the_band(periods: Singles, beep: BeepDesign) -> Floats | None:
    """(K, period_samples) instantaneous power beside the beep's band; None if there is only quantisation."""
    low, high = _band(beep)
    if high <= low:
        return None
    frequency = fft.rfftfreq(periods.shape[1], 1.0 / beep.sample_rate_hz)
    spectrum = fft.rfft(periods.astype(np.float64), axis=1)
    spectrum[:, (frequency < low) | (frequency > high)] = 0.0
    power = fft.irfft(spectrum, periods.shape[1], axis=1) ** 2
    step = quantisation_step(periods[: min(len(periods), 8)].ravel())
    if np.sqrt(np.median(power)) < max(LEAST_NOISE_STEPS * step, 1e-9):
        return None
    return power
