"""What a single point's echo looks like after compression: the calibration of widths and accuracies.

All of it follows from the beep's design; nothing is measured on a phone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.beep import BeepDesign
from obstaclewatch.signal.echoes import TINY, refine_peaks
from obstaclewatch.signal.matched_filter import MatchedFilter
from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.support.compiled import compiled, inlined

SPEEDS_M_S = np.arange(0.0, 4.01, 0.2)
"""Closing speeds of the width table. Doppler stretches the paper's pulse: its half width at half height grows from
259 us at rest to 280 us at 1.3 m/s, which unremoved reads as 15 cm of radius at 3 m."""
REACH_S = 2e-3
"""How far behind a peak its crest's trailing side is looked for."""


@dataclass(frozen=True)
class PulseShape:
    """Widths of the compressed beep.

    Attributes:
        level: height relative to the peak at which the trailing width is read.
        trailing_s: (len(SPEEDS_M_S),) from the peak to where the trailing side falls to `level`.
        rms_bandwidth_hz: spread of the beep's energy spectrum about its mean, 707 Hz for the paper's beep.
    """

    level: float
    trailing_s: Floats
    rms_bandwidth_hz: float

    def trailing_width_s(self, closing_speed_m_s: ArrayLike) -> Floats:
        """Trailing width of an echo that closes in (or recedes) at a speed."""
        return np.interp(np.abs(closing_speed_m_s), SPEEDS_M_S, self.trailing_s)

    def delay_std_s(self, snr: ArrayLike) -> Floats:
        """Cramer-Rao bound of an echo's delay from its envelope, 1 / (2 pi B sqrt(snr)); snr = 2E/N0 as a ratio."""
        return 1.0 / (2.0 * np.pi * self.rms_bandwidth_hz * np.sqrt(np.asarray(snr, dtype=np.float64)))


@lru_cache(maxsize=16)
def pulse_shape(beep: BeepDesign, level: float, sound_speed_m_s: float) -> PulseShape:
    """Calibrate the pulse of a beep at rest and in motion.

    Raises:
        ValueError: the pulse's side does not fall to the level within `REACH_S`.
    """
    compressor = MatchedFilter(beep, beep.period_s)
    trailing = [
        trailing_widths(*_peak_of(compressor, beep, speed, sound_speed_m_s), compressor.rate_hz, level, REACH_S)[0][0]
        for speed in SPEEDS_M_S
    ]
    if np.isnan(trailing).any():
        raise ValueError(
            f"the compressed beep must fall to {level:g} of its peak within {REACH_S} s at {SPEEDS_M_S[0]:g} to "
            f"{SPEEDS_M_S[-1]:g} m/s, got {beep}"
        )
    return PulseShape(level, np.array(trailing), rms_bandwidth_hz(beep))


def rms_bandwidth_hz(beep: BeepDesign) -> float:
    """Square root of the second central moment of the beep's energy spectrum."""
    samples = beep.samples()
    energy = np.abs(np.fft.rfft(samples, 4 * len(samples))) ** 2
    frequency = np.fft.rfftfreq(4 * len(samples), 1.0 / beep.sample_rate_hz)
    mean = np.sum(frequency * energy) / np.sum(energy)
    return float(np.sqrt(np.sum((frequency - mean) ** 2 * energy) / np.sum(energy)))


@compiled
def trailing_widths(
    magnitude: Floats, position: Floats, height: Floats, rate_hz: float, level: float, reach_s: float
) -> tuple[Floats, Flags]:
    """From each peak to where its trailing side first falls to `level` of its height.

    Args:
        magnitude: (M,) envelope.
        position, height: (n,) interpolated peaks, position in samples.
        rate_hz: samples per second.
        level: relative height.
        reach_s: how far to look.

    Returns:
        (n,) widths, s, NaN where the side does not fall so far or rises again before it does;
        (n,) whether the side rises again: a crest merged with the next one.
    """
    count = int(reach_s * rate_hz)
    width, merged = np.empty(len(position)), np.empty(len(position), dtype=np.bool_)
    for row in range(len(position)):
        first, target = int(position[row]), level * height[row]
        crossing, merged[row] = _crossing(magnitude[first : first + count], target)
        width[row] = np.nan
        if crossing > 0 and not merged[row]:
            at = first + crossing
            width[row] = (at + _inverse_parabola(magnitude[at - 2 : at + 1], target) - position[row]) / rate_hz
    return width, merged


@inlined
def _crossing(side: Floats, target: float) -> tuple[int, bool]:
    """Where a peak's side first falls below a target, 0 if nowhere, and whether it rises again before."""
    rises = False
    for sample in range(len(side)):
        if side[sample] < target:
            return sample, rises
        rises = rises or (sample >= 2 and side[sample] > side[sample - 1])
    return 0, False


@inlined
def _inverse_parabola(height: Floats, target: float) -> float:
    """Where falling heights (3,) at samples -2, -1, 0 pass a target: position as a parabola of log height."""
    early, middle, late = [math.log(max(sample, TINY)) for sample in height]
    goal = math.log(target)
    weight_early = (goal - middle) * (goal - late) / ((early - middle) * (early - late))
    weight_middle = (goal - early) * (goal - late) / ((middle - early) * (middle - late))
    return -2.0 * weight_early - weight_middle


def _peak_of(
    compressor: MatchedFilter, beep: BeepDesign, speed_m_s: float, sound_speed_m_s: float
) -> tuple[Floats, Floats, Floats]:
    """Envelope, peak position and height of a mirror that closes in at a speed."""
    time = np.arange(compressor.block_samples) / beep.sample_rate_hz
    delay_s = 0.2 * beep.period_s
    emitted = ((sound_speed_m_s + speed_m_s) * time - sound_speed_m_s * delay_s) / (sound_speed_m_s - speed_m_s)
    magnitude = compressor.compress(beep.waveform(emitted)[None])
    position, height = refine_peaks(magnitude.magnitude[0], np.array([np.argmax(magnitude.magnitude[0])]))
    return magnitude.magnitude[0], position, height
