"""Peaks of the envelope: which heights count (paper section 3.4), and where exactly they lie."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, signal

from obstaclewatch.matched_filter import EchoProfile

NEIGHBOURS = np.array([[-1], [0], [1]])
TINY = np.finfo(np.float64).tiny
QUARTILE_TO_RMS = np.sqrt(-np.log(0.75))
SIDELOBE = 10.0 ** (-44.0 / 20.0)
"""Highest sidelobe of a compressed Hann chirp, -46.7 dB, and some more."""


@dataclass(frozen=True)
class Echoes:
    """Peaks of one channel's envelope, nearest first.

    Attributes:
        delay_s: (n,) where the interpolated peaks lie, on the profile's delay axis.
        amplitude: (n,) their interpolated heights; 1 is the beep at its emitted amplitude.
        sample: (n,) profile sample next to each peak.
    """

    delay_s: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    sample: NDArray[np.intp]

    def __len__(self) -> int:
        return len(self.delay_s)

    def __getitem__(self, which: NDArray[np.bool_] | NDArray[np.intp] | slice) -> Echoes:
        return Echoes(self.delay_s[which], self.amplitude[which], self.sample[which])


def mean_threshold(magnitude: NDArray[np.float64], factor: float) -> float:
    """The paper's threshold: the average envelope over the target range, times lambda (section 3.4).

    The average leaves out the direct sound, which would raise it by 1 % of the direct peak: more than a wall's echo.
    """
    return factor * float(np.mean(magnitude))


def os_cfar_threshold(
    magnitude: NDArray[np.float64], factor: float, half_width: int, quantile: float = 0.6
) -> NDArray[np.float64]:
    """(n,) multiple of a local order statistic: ordered-statistic constant false-alarm rate (Rohling 1983).

    Args:
        magnitude: (n,) envelope.
        factor: multiple of the order statistic.
        half_width: reference samples on either side.
        quantile: which order statistic of the window; an echo fills less than the rest of it.
    """
    return factor * ndimage.percentile_filter(magnitude, 100.0 * quantile, size=2 * half_width + 1, mode="nearest")


def os_cfar_passes(
    magnitude: NDArray[np.float64],
    peaks: NDArray[np.intp],
    factor: float,
    half_width: int,
    quantile: float = 0.6,
) -> NDArray[np.bool_]:
    """(n,) which peaks reach `os_cfar_threshold` at their places, bit for bit, without computing it elsewhere.

    A peak reaches the multiple of the window's order statistic where so many samples of the window lie below it.
    """
    rank = int((2 * half_width + 1) * (100.0 * quantile) / 100.0)
    height = magnitude[peaks]
    passes = height >= factor * _least_order_statistic(magnitude, peaks, rank, half_width)
    likely = passes.nonzero()[0]
    bar = np.empty(len(magnitude) + 2 * half_width)  # beyond an end the outermost sample repeats
    bar[:half_width] = magnitude[0]
    bar[half_width : half_width + len(magnitude)] = magnitude
    bar[half_width + len(magnitude) :] = magnitude[-1]
    bar *= factor
    window = bar[peaks[likely, None] + _from_zero(2 * half_width + 1)]
    passes[likely] = np.count_nonzero(window <= height[likely, None], axis=1) > rank
    return passes


@lru_cache(maxsize=16)
def _from_zero(count: int) -> NDArray[np.intp]:
    """0 to count - 1, made once."""
    index = np.arange(count)
    index.setflags(write=False)
    return index


def _least_order_statistic(
    magnitude: NDArray[np.float64], peaks: NDArray[np.intp], rank: int, half_width: int
) -> NDArray[np.float64]:
    """(n,) what the order statistic around each peak cannot fall below: a window's is at least that of all samples.

    At the ends up to `half_width` samples of a window repeat the outermost one.
    """
    if not half_width <= rank < len(magnitude):
        return np.zeros(len(peaks))
    order = magnitude.copy()
    order.partition((rank - half_width, rank))
    inside = (peaks >= half_width) & (peaks < len(magnitude) - half_width)
    return np.where(inside, order[rank], order[rank - half_width])


def sidelobe_floor(magnitude: NDArray[np.float64], half_width: int) -> NDArray[np.float64]:
    """(n,) height that the sidelobes of stronger echoes within `half_width` samples may reach."""
    return SIDELOBE * ndimage.maximum_filter1d(magnitude, 2 * half_width + 1, mode="nearest")


def noise_amplitude(magnitude: NDArray[np.float64]) -> float:
    """Rms of a complex Gaussian noise envelope, from the lower quartile of the heights.

    A Rayleigh height's quartile is sqrt(-ln 0.75) of its rms. Echoes fill less than three quarters of the range.
    """
    quarter = len(magnitude) // 4
    ordered = magnitude.copy()
    ordered.partition(quarter)
    return float(ordered[quarter] / QUARTILE_TO_RMS)


def local_maxima(magnitude: NDArray[np.float64]) -> NDArray[np.intp]:
    """(n,) samples higher than both their neighbours; of a flat top its middle."""
    return signal.find_peaks(magnitude)[0]


def separated_peaks(
    magnitude: NDArray[np.float64], threshold: float | NDArray[np.float64], separation: int
) -> NDArray[np.intp]:
    """(n,) local maxima above a threshold; of two nearer than `separation` samples only the higher stays."""
    peaks = local_maxima(magnitude)
    height = threshold if np.ndim(threshold) == 0 else np.asarray(threshold)[peaks]
    return keep_separated(magnitude, peaks[magnitude[peaks] >= height], separation)


def keep_separated(magnitude: NDArray[np.float64], peaks: NDArray[np.intp], separation: int) -> NDArray[np.intp]:
    """Of peaks nearer to one another than `separation` samples, the highest; peaks come and go in order."""
    if len(peaks) < 2 or separation < 2 or (peaks[1:] - peaks[:-1]).min() >= separation:
        return peaks
    kept = np.ones(len(peaks), dtype=bool)
    for best in np.argsort(magnitude[peaks])[::-1]:
        if kept[best]:
            kept[np.abs(peaks - peaks[best]) < separation] = False
            kept[best] = True
    return peaks[kept]


def highest_of_windows(magnitude: NDArray[np.float64], window: int) -> NDArray[np.intp]:
    """(n,) the highest sample of every non-overlapping window (section 3.4 as printed)."""
    whole = len(magnitude) // window * window
    return np.argmax(magnitude[:whole].reshape(-1, window), axis=1) + np.arange(0, whole, window)


def refine_peaks(
    magnitude: NDArray[np.float64], peaks: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sub-sample positions and heights of peaks: a parabola through three points of the log envelope.

    The compressed pulse is nearly Gaussian at its top, so its logarithm is nearly a parabola. Samples that are no
    local maximum (possible under fixed windows) stay where they are.

    Returns:
        (n,) positions in samples, and (n,) heights.
    """
    inner = np.minimum(np.maximum(peaks, 1), len(magnitude) - 2)
    left, middle, right = np.log(np.maximum(magnitude[inner + NEIGHBOURS], TINY))
    slope, curvature = left - right, left - 2.0 * middle + right
    is_peak = (middle >= np.maximum(left, right)) & (curvature < 0.0) & (inner == peaks)
    offset: NDArray[np.float64] = np.zeros(len(peaks))
    np.divide(0.5 * slope, curvature, out=offset, where=is_peak)
    return peaks + offset, magnitude[peaks] * np.exp(-0.25 * slope * offset)


def echoes_at(profile: EchoProfile, channel: int, peaks: NDArray[np.intp]) -> Echoes:
    """Echoes at the given peak samples of one channel."""
    position, height = refine_peaks(profile.magnitude[channel], peaks)
    return Echoes(profile.start_s + position / profile.rate_hz, height, peaks)
