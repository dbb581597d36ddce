"""Which beep a recording really holds: band, length and period, from the sound alone.

A line is fitted to the ridge of every beep in the spectrogram; the medians count, so that gaps in a recording do no
harm. The beep is taken for a linear sweep under a Hann window: a phone that swallows an edge of the band makes it read
shorter and narrower.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Floats

FRAME_S, HOP_S = 4e-3, 1e-3
LOWEST_HZ = 10_000.0
"""Speech, steps and traffic lie below."""
PERIOD_S = (0.02, 0.5)
"""Shortest and longest period looked for."""
LEAST_PERIODICITY = 0.5
"""Correlation of the band's energy with itself one period later; that of noise alone stays below 0.3."""
MULTIPLES = 4
CORE_SHARES = (0.05, 0.95)
LONGEST_S = 4.0
"""How much of a recording is looked at."""
HANN_ENERGY_SPREAD = 0.14145
"""Standard deviation of time under the weight sin^4(pi t / T), in units of T (integrated numerically)."""


@dataclass(frozen=True)
class DetectedBeep:
    """The beep as received.

    Attributes:
        start_hz, stop_hz: ends of the sweep.
        duration_s: length of the Hann window that has the ridge's spread of energy.
        period_s: from beep to beep.
        core_hz: (lowest, highest) frequency of the middle 90 % of its energy.
    """

    start_hz: float
    stop_hz: float
    duration_s: float
    period_s: float
    core_hz: tuple[float, float]

    @property
    def chirp_rate_hz_s(self) -> float:
        """Slope of the sweep."""
        return (self.stop_hz - self.start_hz) / self.duration_s

    def __str__(self) -> str:
        return (
            f"{self.start_hz / 1e3:.1f}-{self.stop_hz / 1e3:.1f} kHz in {self.duration_s * 1e3:.0f} ms "
            f"every {self.period_s * 1e3:.1f} ms"
        )


def detected_beep(samples: NDArray[np.floating], sample_rate_hz: float) -> DetectedBeep | None:
    """The sweep that repeats in the first seconds of a channel; None if nothing does.

    Args:
        samples: (N,) one channel.
        sample_rate_hz: its rate; at least 20 kHz.
    """
    power, frequency = _excess_power(samples[: round(LONGEST_S * sample_rate_hz)], sample_rate_hz)
    energy = power.sum(axis=0)
    period = _period_frames(energy)
    if period is None:
        return None
    fits = [_fitted(piece, frequency) for piece in _beeps(power, period) if piece.any()]
    if not fits:
        return None
    start, stop, duration, low, high = np.median(fits, axis=0).tolist()
    return DetectedBeep(start, stop, duration, period * HOP_S, (low, high))


def _excess_power(samples: NDArray[np.floating], rate_hz: float) -> tuple[Floats, Floats]:
    """(F, K) spectrogram above `LOWEST_HZ` less what is there at all times, and its (F,) frequencies."""
    frame, hop = round(FRAME_S * rate_hz), round(HOP_S * rate_hz)
    if len(samples) < 4 * frame:
        return np.zeros((1, 1)), np.zeros(1)
    frequency, _, spectrum = scipy.signal.stft(
        samples, rate_hz, nperseg=frame, noverlap=frame - hop, boundary=None, padded=False
    )
    kept = frequency >= LOWEST_HZ
    power = np.abs(spectrum[kept]) ** 2
    return np.maximum(power - 2.0 * np.median(power, axis=1, keepdims=True), 0.0), frequency[kept]


def _period_frames(energy: Floats) -> float | None:
    """Period of the energy in frames, from the first strong peak of its autocorrelation, refined at its multiples."""
    low, high = (round(edge / HOP_S) for edge in PERIOD_S)
    varying = energy - energy.mean()
    total = float(varying @ varying)
    if len(energy) < 2 * low or total <= 0.0:
        return None
    lags = scipy.signal.correlate(varying, varying)[len(energy) - 1 :]
    lags = lags / (total * (1.0 - np.arange(len(energy)) / len(energy)))
    high = min(high, len(energy) // 2)
    peaks, shape = scipy.signal.find_peaks(lags[low : high + 1], height=LEAST_PERIODICITY)
    if len(peaks) == 0:
        return None
    first = peaks[np.argmax(shape["peak_heights"] >= 0.8 * shape["peak_heights"].max())] + low
    return _refined_period(lags, int(first))


def _refined_period(lags: Floats, first: int) -> float:
    """The period from its first multiples: the error shrinks with the multiple, and few of them span a gap."""
    period = float(first)
    for multiple in range(1, MULTIPLES + 1):
        near = round(multiple * period)
        if near + 3 >= len(lags):
            break
        top = near - 2 + int(np.argmax(lags[near - 2 : near + 3]))
        left, middle, right = lags[top - 1 : top + 2]
        bend = left - 2.0 * middle + right
        period = (top + (0.5 * (left - right) / bend if bend < 0.0 else 0.0)) / multiple
    return period


def _beeps(power: Floats, period: float) -> list[Floats]:
    """One (F, round(period)) piece a period, the frame of most energy in its middle; those cut off are left out."""
    energy, width = power.sum(axis=0), round(period)
    tops = [start + int(np.argmax(energy[start : start + width])) for start in range(0, len(energy) - width + 1, width)]
    first = [top - width // 2 for top in tops]
    return [power[:, begin : begin + width] for begin in first if begin >= 0 and begin + width <= len(energy)]


def _fitted(piece: Floats, frequency: Floats) -> tuple[float, ...]:
    """Start, stop, duration and core of the line through the ridge of one beep, weighted by energy.

    A frame of the spectrogram adds its own variance to the time of the energy, and nothing to its covariance with
    frequency.
    """
    time = np.arange(piece.shape[1]) * HOP_S
    weight = piece.max(axis=0)
    weight = np.where(weight > 0.01 * weight.max(), weight, 0.0)
    ridge = _ridge_hz(piece, frequency)
    mean, height = np.average(time, weights=weight), np.average(ridge, weights=weight)
    variance = np.average((time - mean) ** 2, weights=weight) - (HANN_ENERGY_SPREAD * FRAME_S) ** 2
    variance = max(float(variance), (HANN_ENERGY_SPREAD * HOP_S) ** 2)
    duration = variance**0.5 / HANN_ENERGY_SPREAD
    half = 0.5 * duration * float(np.average((time - mean) * ridge, weights=weight)) / variance
    order = np.argsort(ridge)
    share = np.cumsum(weight[order]) / weight.sum()
    low, high = ridge[order][np.searchsorted(share, CORE_SHARES)]
    return float(height) - half, float(height) + half, duration, float(low), float(high)


def _ridge_hz(piece: Floats, frequency: Floats) -> Floats:
    """(K,) frequency of most power in each frame: the centroid of the three bins at its top.

    A tone under a Hann window is read within 0.03 bins.
    """
    top, frames = np.argmax(piece, axis=0), np.arange(piece.shape[1])
    below, middle, above = np.pad(piece, ((1, 1), (0, 0)))[top + np.arange(3)[:, None], frames]
    total = below + middle + above
    return frequency[top] + (above - below) / np.where(total > 0.0, total, 1.0) / FRAME_S
