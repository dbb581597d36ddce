"""Peaks of the envelope: which heights count (paper section 3.4), and where exactly they lie."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from obstaclewatch.signal.matched_filter import EchoProfile
from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.order_statistic import order_statistic
from obstaclewatch.support.rows import Rows

TINY = float(np.finfo(np.float64).tiny)
QUARTILE_TO_RMS = float(np.sqrt(-np.log(0.75)))
SIDELOBE = 10.0 ** (-44.0 / 20.0)
"""Highest sidelobe of a compressed Hann chirp, -46.7 dB, and some more."""
CFAR_QUANTILE = 0.6
"""Which order statistic of its surroundings an echo is held against; it fills less than the rest of them."""


@dataclass(frozen=True)
class Echoes(Rows):
    """Peaks of one channel's envelope, nearest first.

    Attributes:
        delay_s: (n,) where the interpolated peaks lie, on the profile's delay axis.
        amplitude: (n,) their interpolated heights; 1 is the beep at its emitted amplitude.
        sample: (n,) profile sample next to each peak.
    """

    delay_s: Floats
    amplitude: Floats
    sample: NDArray[np.intp]


def mean_threshold(magnitude: Floats, factor: float) -> float:
    """The paper's threshold: the average envelope over the target range, times lambda (section 3.4).

    The average leaves out the direct sound, which would raise it by 1 % of the direct peak: more than a wall's echo.
    """
    return factor * float(np.mean(magnitude))


def os_cfar_threshold(magnitude: Floats, factor: float, half_width: int) -> Floats:
    """(n,) multiple of a local order statistic: ordered-statistic constant false-alarm rate (Rohling 1983).

    Args:
        magnitude: (n,) envelope.
        factor: multiple of the order statistic.
        half_width: reference samples on either side.
    """
    percent, size = 100.0 * CFAR_QUANTILE, 2 * half_width + 1
    return factor * ndimage.percentile_filter(magnitude, percent, size=size, mode="nearest")


@compiled
def os_cfar_passes(magnitude: Floats, peaks: NDArray[np.intp], factor: float, half_width: int) -> Flags:
    """(n,) which peaks reach `os_cfar_threshold` at their places, bit for bit, without sorting anything.

    A peak reaches the multiple of the window's order statistic where more samples of the window than the statistic's
    rank have a multiple that is no higher. Beyond an end the outermost sample repeats.
    """
    last = len(magnitude) - 1
    rank = int((2 * half_width + 1) * (100.0 * CFAR_QUANTILE) / 100.0)
    passes = np.empty(len(peaks), dtype=np.bool_)
    for row, peak in enumerate(peaks):
        height, first, end = magnitude[peak], peak - half_width, peak + half_width
        before = max(-first, 0) if factor * magnitude[0] <= height else 0
        after = max(end - last, 0) if factor * magnitude[last] <= height else 0
        passes[row] = before + _reached(magnitude[max(first, 0) : end + 1], factor, height) + after > rank
    return passes


@inlined
def _reached(samples: Floats, factor: float, height: float) -> int:
    """How many samples times the factor are no higher than a height. By index this loop is vectorised."""
    count = 0
    for sample in range(len(samples)):
        count += 1 if factor * samples[sample] <= height else 0
    return count


@compiled
def highest_nearby(magnitude: Floats, half_width: int) -> Floats:
    """(n,) highest sample within `half_width` samples of each: windows that double in width, then two that overlap."""
    size, width = 2 * half_width + 1, 1
    window = np.full(len(magnitude) + 2 * half_width, -np.inf)
    for sample in range(len(magnitude)):
        window[half_width + sample] = magnitude[sample]
    while 2 * width <= size:
        _raise_to(window[: len(window) - width], window[width:])
        width *= 2
    highest = window[: len(magnitude)].copy()
    _raise_to(highest, window[size - width :])
    return highest


@compiled
def _raise_to(lowest: Floats, other: Floats) -> None:
    """Replace (n,) numbers by those of another, or of the same a little later, that are higher."""
    for row in range(len(lowest)):
        lowest[row] = other[row] if other[row] > lowest[row] else lowest[row]


@compiled
def above_sidelobes(magnitude: Floats, peaks: NDArray[np.intp], half_width: int, least: float) -> NDArray[np.intp]:
    """Those of the peaks higher than the sidelobes of any echo within `half_width` samples, and than `least`."""
    highest = SIDELOBE * magnitude[np.argmax(magnitude)]
    kept = np.empty(len(peaks), dtype=np.bool_)
    for row, peak in enumerate(peaks):
        kept[row] = magnitude[peak] >= least
        if kept[row] and magnitude[peak] < highest:
            around = magnitude[max(peak - half_width, 0) : peak + half_width + 1]
            kept[row] = magnitude[peak] >= SIDELOBE * around[np.argmax(around)]
    return peaks[kept]


@compiled
def noise_amplitude(magnitude: Floats) -> float:
    """Rms of a complex Gaussian noise envelope, from the lower quartile of the heights.

    A Rayleigh height's quartile is sqrt(-ln 0.75) of its rms. Echoes fill less than three quarters of the range.
    """
    return order_statistic(magnitude, len(magnitude) // 4) / QUARTILE_TO_RMS


@compiled
def local_maxima(magnitude: Floats) -> NDArray[np.intp]:
    """(n,) samples higher than both their neighbours; of a flat top its middle."""
    peaks, count, sample = np.empty(len(magnitude) // 2, dtype=np.intp), 0, 1
    while sample < len(magnitude) - 1:
        end = sample + 1
        if magnitude[sample - 1] < magnitude[sample]:
            while end < len(magnitude) - 1 and magnitude[end] == magnitude[sample]:
                end += 1
            if magnitude[end] < magnitude[sample]:
                peaks[count] = (sample + end - 1) // 2
                count += 1
        sample = end
    return peaks[:count].copy()


def separated_peaks(magnitude: Floats, threshold: float | Floats, separation: int) -> NDArray[np.intp]:
    """(n,) local maxima above a threshold; of two nearer than `separation` samples only the higher stays."""
    peaks = local_maxima(magnitude)
    height = threshold if np.ndim(threshold) == 0 else np.asarray(threshold)[peaks]
    return keep_separated(magnitude, peaks[magnitude[peaks] >= height], separation)


@compiled
def keep_separated(magnitude: Floats, peaks: NDArray[np.intp], separation: int) -> NDArray[np.intp]:
    """Of peaks nearer to one another than `separation` samples, the highest; peaks come and go in order."""
    undecided, kept = np.ones(len(peaks), dtype=np.bool_), np.zeros(len(peaks), dtype=np.bool_)
    for _ in range(len(peaks)):
        best = -1
        for row, peak in enumerate(peaks):
            if undecided[row] and (best < 0 or magnitude[peak] >= magnitude[peaks[best]]):
                best = row
        if best < 0:
            break
        kept[best], undecided[best] = True, False
        for row, peak in enumerate(peaks):
            if abs(peak - peaks[best]) < separation:
                undecided[row] = False
    return peaks[kept]


def highest_of_windows(magnitude: Floats, window: int) -> NDArray[np.intp]:
    """(n,) the highest sample of every non-overlapping window (section 3.4 as printed)."""
    covered = len(magnitude) // window * window
    return np.argmax(magnitude[:covered].reshape(-1, window), axis=1) + np.arange(0, covered, window)


@compiled
def refine_peaks(magnitude: Floats, peaks: NDArray[np.intp]) -> tuple[Floats, Floats]:
    """Sub-sample positions and heights of peaks: a parabola through three points of the log envelope.

    The compressed pulse is nearly Gaussian at its top, so its logarithm is nearly a parabola. Samples that are no
    local maximum (possible under fixed windows) stay where they are.

    Returns:
        (n,) positions in samples, and (n,) heights.
    """
    position, height = np.empty(len(peaks)), np.empty(len(peaks))
    for row, peak in enumerate(peaks):
        position[row], height[row] = refined_peak(magnitude, peak)
    return position, height


@compiled
def refined_peak(magnitude: Floats, peak: int) -> tuple[float, float]:
    """The same of a single peak."""
    if not 1 <= peak <= len(magnitude) - 2:
        return float(peak), magnitude[peak]
    left = math.log(max(magnitude[peak - 1], TINY))
    middle = math.log(max(magnitude[peak], TINY))
    right = math.log(max(magnitude[peak + 1], TINY))
    slope, curvature = left - right, left - 2.0 * middle + right
    if not (middle >= max(left, right) and curvature < 0.0):
        return float(peak), magnitude[peak]
    offset = 0.5 * slope / curvature
    return peak + offset, magnitude[peak] * math.exp(-0.25 * slope * offset)


def echoes_at(profile: EchoProfile, channel: int, peaks: NDArray[np.intp]) -> Echoes:
    """Echoes at the given peak samples of one channel."""
    position, height = refine_peaks(profile.magnitude[channel], peaks)
    return Echoes(profile.start_s + position / profile.rate_hz, height, peaks)
