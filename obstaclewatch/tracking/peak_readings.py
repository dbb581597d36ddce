"""What stands out of one beep, once what stays is taken away: peaks, what they read, and microphone 1 around them.

One compiled call a beep: handing arrays to compiled parts and back costs as much as what these compute.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.signal.carrier_phase import second_channel
from obstaclewatch.signal.echoes import (
    SIDELOBE,
    TINY,
    highest_nearby,
    keep_separated,
    local_maxima,
    noise_amplitude,
    refine_peaks,
)
from obstaclewatch.signal.local_noise import local_noise
from obstaclewatch.signal.two_mics import distance_of
from obstaclewatch.support.arrays import Complexes, Floats, SingleComplexes, Singles
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.order_statistic import order_statistic
from obstaclewatch.tracking.track_before_detect import log_ratio

CLUTTER_FACTOR = 1.6
"""How far above clutter a peak must stand. At 1.2 the ground's echo, which gait moves, captured tracks that crossed it:
18 of 44 false alerts on 200 rendered walks of the development split."""
PEAK_TO_RMS = 1.7
"""Least height of a peak over noise, which noise alone passes in 5 % of the cells."""
MOST_PEAKS = 20


class Reception(NamedTuple):
    """What is the same in every beep.

    Attributes:
        start_s, rate_hz: delay of the envelope's first sample, and its samples per second.
        sound_speed_m_s: speed of sound.
        baseline_m: from microphone 0 to the speaker.
        speaker_cosine: of the angle there between the speaker and what is straight ahead.
        one_m: deviation of the path at 2E/N0 = 1.
        noise_window: samples over which noise is the same, see `local_noise`.
        sidelobe_reach: of sidelobes, samples.
        separation: least distance between two peaks, samples.
    """

    start_s: float
    rate_hz: float
    sound_speed_m_s: float
    baseline_m: float
    speaker_cosine: float
    one_m: float
    noise_window: int
    sidelobe_reach: int
    separation: int


@compiled
def peak_readings(
    moved: Complexes,
    magnitude: Floats,
    clutter: Floats,
    offset: Floats,
    reception: tuple[Any, ...],
    first: int,
    start_s: float,
    direct: float,
    floor: float,
    most_peaks: int,
    alone: bool,
) -> tuple[Floats, SingleComplexes, Singles]:
    """What n peaks read (5, n) and microphone 1 around them (n, W), see `MovingPeaks`, and the log ratios of all cells.

    Args:
        moved, magnitude: (2, M) envelope without what stays, and its size.
        clutter: (S,) what stays of microphone 0's heights, from `first` on.
        offset: (W,) where microphone 1 is read after each peak, samples.
        reception: a `Reception`.
        first: sample from which on peaks are looked for.
        start_s: emission, on the envelope's delay axis.
        direct: height of the direct sound.
        floor: least height of an echo.
        most_peaks: how many are looked for.
        alone: microphone 1 says nothing.
    """
    known = Reception(*reception)
    received = magnitude[0, first : first + len(clutter)]
    height = received / noise_under(received, clutter, known.noise_window, known.sidelobe_reach, floor)
    sample = highest_peaks(received, height, known.separation, most_peaks)
    position, amplitude = refine_peaks(magnitude[0], sample + first)
    delay_s = known.start_s + position / known.rate_hz
    path_m = known.sound_speed_m_s * (delay_s - start_s)
    readings = readings_of(
        path_m, amplitude, sample, received, height, known.baseline_m, known.speaker_cosine, known.one_m, direct
    )
    second = np.full((len(sample), len(offset)), np.complex64(np.nan))
    if len(sample) > 0 and not alone:
        noise = max(noise_amplitude(magnitude[1, first:]), TINY)
        second = second_channel(moved, (delay_s - known.start_s) * known.rate_hz, offset, noise)
    return readings, second, log_ratio(height * height)


@inlined
def noise_under(received: Floats, clutter: Floats, window: int, reach: int, floor: float) -> Floats:
    """(S,) rms that an envelope's moving echoes must stand out of: noise, what stays, and sidelobes.

    Args:
        received, clutter: (S,) envelope, and what stays of it.
        window: samples over which noise is the same, see `local_noise`.
        reach: of sidelobes, samples.
        floor: least height of an echo.
    """
    noise, sidelobes = local_noise(received, window), highest_nearby(received, reach)
    for sample in range(len(noise)):
        standing = max(CLUTTER_FACTOR * clutter[sample], SIDELOBE * sidelobes[sample], floor)
        noise[sample] = max(noise[sample], standing / PEAK_TO_RMS)
    return noise


@inlined
def highest_peaks(magnitude: Floats, height: Floats, separation: int, most: int) -> NDArray[np.intp]:
    """(n,) peaks apart from one another that are highest over noise, nearest first."""
    if most == 0:
        return np.empty(0, dtype=np.intp)
    peaks = local_maxima(magnitude)
    peaks = keep_separated(magnitude, peaks[height[peaks] >= PEAK_TO_RMS], separation)
    if len(peaks) > most:
        peaks = peaks[height[peaks] >= order_statistic(height[peaks], len(peaks) - most)]
    return peaks


@inlined
def readings_of(
    path_m: Floats,
    amplitude: Floats,
    sample: NDArray[np.intp],
    received: Floats,
    height: Floats,
    baseline_m: float,
    speaker_cosine: float,
    one_m: float,
    direct: float,
) -> Floats:
    """(5, n) power over noise, range as if from straight ahead, its deviation, level in dB and 2E/N0 in dB, of n peaks.

    Args:
        path_m: (n,) from speaker to microphone 0.
        amplitude: (n,) of the peaks.
        sample: (n,) next to them.
        received, height: (S,) envelope, and its height over the rms of the noise around.
        baseline_m: from microphone 0 to the speaker.
        speaker_cosine: of the angle there between the speaker and what is straight ahead.
        one_m: deviation of the path at 2E/N0 = 1.
        direct: height of the direct sound.
    """
    readings = np.empty((5, len(path_m)))
    for peak in range(len(path_m)):
        noise = received[sample[peak]] / height[sample[peak]]
        power = (amplitude[peak] / noise) ** 2
        readings[0, peak] = power
        farther = path_m[peak] > baseline_m
        readings[1, peak] = distance_of(path_m[peak], baseline_m, speaker_cosine) if farther else np.nan
        readings[2, peak] = 0.5 * one_m / np.sqrt(2.0 * power)
        readings[3, peak] = 20.0 * np.log10(amplitude[peak] / direct)
        readings[4, peak] = 10.0 * np.log10(2.0 * power)
    return readings
