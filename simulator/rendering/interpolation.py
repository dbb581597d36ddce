"""Real samples between those of an analytic signal: a windowed sinc about 20 kHz, a phase of it for every sample."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from obstaclewatch.support.arrays import Complexes, Singles
from obstaclewatch.support.compiled import fused
from simulator.waves.band import REFERENCE_HZ

TAPS = 24  # of the sinc; with this window it keeps 20 kHz and 7 kHz to either side to 1e-7, at 24 kHz
BETA = 14.5  # of Kaiser's window
BEFORE = TAPS // 2 - 1  # taps before the sample that is followed
AT_A_TIME = 6
CHUNK = 1024  # samples whose sums stay in the cache


def between(circle: Complexes, rate_hz: float, factor: int) -> Singles:
    """(2, factor n) real parts of (2, n) analytic signals of a band about 20 kHz, whose ends meet."""
    around = np.pad(circle, ((0, 0), (BEFORE, TAPS - BEFORE - 1)), mode="wrap")
    parts = np.stack([around.real, around.imag], axis=1, dtype=np.float32, casting="same_kind")
    samples = np.empty((*circle.shape, factor), dtype=np.float32)
    _interpolate(parts, _kernel(rate_hz, factor), samples)
    return samples.reshape(len(circle), -1)


@lru_cache
def _kernel(rate_hz: float, factor: int) -> Singles:
    """(factor, 2, TAPS) weights of real and imaginary parts, phase by phase; the first phase is that of a sample."""
    time = np.arange(factor)[:, None] / factor - np.arange(-BEFORE, TAPS - BEFORE)
    window = np.i0(BETA * np.sqrt(np.maximum(1.0 - (2.0 * time / TAPS) ** 2, 0.0))) / np.i0(BETA)
    weight = np.sinc(time) * window * np.exp(2j * np.pi * REFERENCE_HZ / rate_hz * time)
    return np.stack([weight.real, -weight.imag], axis=1).astype(np.float32)


@fused
def _interpolate(parts, kernel, samples):
    """Sums over the taps, chunk by chunk."""
    total = np.empty((len(kernel), CHUNK), np.float32)
    for channel in range(len(parts)):
        for first in range(0, samples.shape[1], CHUNK):
            count = min(CHUNK, samples.shape[1] - first)
            for i in range(count):
                total[0, i] = parts[channel, 0, first + i + BEFORE]
            for phase in range(1, len(kernel)):
                total[phase] = np.float32(0.0)
                for part in range(2):
                    for tap in range(0, TAPS, AT_A_TIME):
                        _add_six(total[phase, :count], kernel[phase, part, tap:], parts[channel, part, first + tap :])
            for i in range(count):
                for phase in range(len(kernel)):
                    samples[channel, first + i, phase] = total[phase, i]


@fused
def _add_six(total, weight, values):
    """Add running sums of `AT_A_TIME` weighted values."""
    a, b, c, d, e, f = weight[0], weight[1], weight[2], weight[3], weight[4], weight[5]
    v, w, x, y, z = values[1:], values[2:], values[3:], values[4:], values[5:]
    for i in range(len(total)):
        total[i] += a * values[i] + b * v[i] + (c * w[i] + d * x[i]) + (e * y[i] + f * z[i])
