"""The stored full-wave echoes beside the repository, and how echoes are compared with them, damped ones included."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from obstaclewatch.beep import BeepDesign
from simulator import Paths

SAMPLE_S = 1.0 / 192_000.0


def stored(name: str) -> dict[str, NDArray]:
    """Arrays of a reference; skips the test where the folder is not at hand."""
    default = Path(__file__).resolve().parents[3] / "shared"
    path = Path(os.environ.get("OBSTACLEWATCH_SHARED", default)) / "reference" / f"{name}_fullwave.npz"
    if not path.exists():
        pytest.skip(f"no full-wave reference at {path}; OBSTACLEWATCH_SHARED names its folder")
    with np.load(path) as arrays:
        return dict(arrays)


def damped(paths: Paths, frequency_hz: NDArray, sigma_1_s: float) -> NDArray[np.complex128]:
    """(F,) sum of paths at complex frequencies w - j sigma: each one is damped by e^{-sigma delay}."""
    gain = paths.gain_at(frequency_hz)
    turn = np.exp(-(2j * np.pi * frequency_hz + sigma_1_s) * paths.delay_s[:, None])
    return (gain * turn).sum(axis=0)


def matched_peak(
    ours: NDArray[np.complex128], reference: NDArray[np.complex128], frequency_hz: NDArray, delay_s: float
) -> tuple[float, float]:
    """Level, dB, and delay, samples at 192 kHz, of the matched filter's peak about `delay_s` re the reference's."""
    (level_a, lag_a), (level_b, lag_b) = (correlation_peak(h, frequency_hz, delay_s) for h in (ours, reference))
    return level_a - level_b, (lag_a - lag_b) / SAMPLE_S


def correlation_peak(
    transfer: NDArray[np.complex128], frequency_hz: NDArray, delay_s: float, reach_s: float = 1.2e-3
) -> tuple[float, float]:
    """Level, dB, and time about `delay_s`, s, of the peak of the matched filter's envelope within `reach_s` of it."""
    power, lag, kernel = _filter(tuple(frequency_hz.tolist()), reach_s)
    envelope = np.abs((power * transfer * np.exp(2j * np.pi * frequency_hz * delay_s)) @ kernel)
    peak = int(envelope.argmax())
    return 20.0 * np.log10(envelope[peak] / power.sum()), float(lag[peak])


@cache
def _filter(frequency_hz: tuple[float, ...], reach_s: float) -> tuple[NDArray, NDArray, NDArray]:
    """(F,) power of the beep, (L,) lags, and (F, L) what turns a spectrum into its envelope there."""
    beep, each = BeepDesign(), np.array(frequency_hz)
    time = np.arange(0.0, beep.duration_s, SAMPLE_S)
    power = np.abs(np.exp(-2j * np.pi * each[:, None] * time) @ beep.waveform(time)) ** 2
    lag = np.arange(-reach_s, reach_s, SAMPLE_S / 20.0)
    return power, lag, np.exp(2j * np.pi * np.outer(each, lag))
