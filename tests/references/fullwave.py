"""The stored full-wave echoes beside the repository, and how an echo is compared with them."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from obstaclewatch.beep import BeepDesign

RATE_HZ = 192_000.0


def stored(name: str) -> dict[str, NDArray]:
    """Arrays of a reference; skips the test where the folder is not at hand."""
    default = Path(__file__).resolve().parents[3] / "shared"
    path = Path(os.environ.get("OBSTACLEWATCH_SHARED", default)) / "reference" / f"{name}_fullwave.npz"
    if not path.exists():
        pytest.skip(f"no full-wave reference at {path}; OBSTACLEWATCH_SHARED names its folder")
    with np.load(path) as arrays:
        return dict(arrays)


def correlation_peak(transfer: NDArray, frequency_hz: NDArray, delay_s: float) -> tuple[float, float]:
    """Level, dB, and time about `delay_s`, s, of the peak of the matched filter's envelope."""
    beep = BeepDesign()
    time = np.arange(0.0, beep.duration_s, 1.0 / RATE_HZ)
    power = np.abs(np.exp(-2j * np.pi * frequency_hz[:, None] * time) @ beep.waveform(time)) ** 2
    lag = np.arange(-1.2e-3, 1.2e-3, 0.05 / RATE_HZ)
    kernel = np.exp(2j * np.pi * np.outer(frequency_hz, lag))
    envelope = np.abs((power * transfer * np.exp(2j * np.pi * frequency_hz * delay_s)) @ kernel)
    peak = int(envelope.argmax())
    return 20.0 * np.log10(envelope[peak] / power.sum()), float(lag[peak])
