"""How loud it is around each range when nothing echoes there."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import inlined
from obstaclewatch.support.order_statistic import order_statistic

QUANTILE = 0.6
QUANTILE_TO_RMS = float(np.sqrt(-np.log(1.0 - QUANTILE)))
"""A Rayleigh envelope's 60 % quantile as a share of its rms; an echo fills less than the rest of a window."""


@inlined
def local_noise(magnitude: Floats, window: int) -> Floats:
    """(M,) rms of the noise around each sample of an envelope, from quantiles of windows that overlap by half.

    Args:
        magnitude: (M,) envelope, at least one window long.
        window: samples over which noise is taken to be the same, even.
    """
    hop, rank = window // 2, int(QUANTILE * window)
    level, noise = np.empty(len(magnitude) // hop - 1), np.empty(len(magnitude))
    for row in range(len(level)):
        level[row] = order_statistic(magnitude[row * hop : (row + 2) * hop], rank) / QUANTILE_TO_RMS
    noise[:hop] = level[0]  # up to the first window's middle
    for row in range(len(level) - 1):
        slope = (level[row + 1] - level[row]) / hop
        for past in range(hop):
            noise[(row + 1) * hop + past] = slope * past + level[row]
    noise[len(level) * hop :] = level[-1]
    return noise
