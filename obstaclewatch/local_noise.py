"""How loud it is around each range when nothing echoes there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

QUANTILE = 0.6
QUANTILE_TO_RMS = float(np.sqrt(-np.log(1.0 - QUANTILE)))
"""A Rayleigh envelope's 60 % quantile as a share of its rms; an echo fills less than the rest of a window."""


def local_noise(magnitude: NDArray[np.float64], window: int) -> NDArray[np.float64]:
    """(M,) rms of the noise around each sample of an envelope, from quantiles of windows that overlap by half.

    Args:
        magnitude: (M,) envelope, at least one window long.
        window: samples over which noise is taken to be the same, even.
    """
    hop = window // 2
    halves = magnitude[: len(magnitude) // hop * hop].reshape(-1, hop)
    windows = np.concatenate([halves[:-1], halves[1:]], axis=1)
    rank = int(QUANTILE * window)
    windows.partition(rank, axis=1)
    quantile = windows[:, rank]
    middle = hop * np.arange(1, len(windows) + 1)
    return np.interp(np.arange(len(magnitude)), middle, quantile / QUANTILE_TO_RMS)
