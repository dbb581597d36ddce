"""What never changes, taken away: the ringing of the direct sound by coherent mean, standing echoes by a clutter map.

Phone and clock are rigid: the direct sound and its ringing have the same phase in every beep, while an obstacle that
closes in by 2 mm has rotated by a quarter of a cycle. A mean over beeps keeps the one and loses the other. The
ground and walls alongside bob with the gait and keep their height only; a mean of heights finds them.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.signal.echoes import highest_nearby
from obstaclewatch.support.arrays import Complexes, Floats
from obstaclewatch.support.compiled import compiled


class CoherentBackground:
    """Running complex mean of the envelopes of successive beeps.

    Args:
        beeps: over how many of them the mean runs once there are so many.
    """

    def __init__(self, beeps: int) -> None:
        self._beeps = beeps
        self._count = 0
        self._mean: Complexes | None = None

    def clear(self) -> None:
        """Forget all beeps."""
        self._count, self._mean = 0, None

    def subtract(self, envelope: Complexes) -> Complexes:
        """What of a (2, M) envelope was not there in the mean of earlier beeps; then learn it. Zeros at first."""
        self._count = min(self._count + 1, self._beeps)
        if self._mean is None:
            self._mean = np.array(envelope, order="C")
            return np.zeros_like(self._mean)
        return _learnt(self._mean, envelope, self._count)


class ClutterMap:
    """Running mean height of a profile, widened by how far gait moves a standing echo.

    Args:
        beeps: over how many of them the mean runs once there are so many.
        half_width: samples by which a standing echo may wander.
    """

    def __init__(self, beeps: int, half_width: int) -> None:
        self._beeps = beeps
        self._half_width = half_width
        self._count = 0
        self._mean: Floats | None = None

    def clear(self) -> None:
        """Forget all beeps."""
        self._count, self._mean = 0, None

    @property
    def mean(self) -> Floats | None:
        """(M,) mean of all beeps' highest value nearby; None before the first."""
        return self._mean

    def level(self, magnitude: Floats) -> Floats:
        """(M,) mean of the earlier beeps' highest value nearby; then learn this one. Infinite at first."""
        self._count, before = min(self._count + 1, self._beeps), self._mean
        if before is None:
            self._mean = highest_nearby(magnitude, self._half_width)
            return np.full(len(magnitude), np.inf)
        self._mean = _mean_height(before, magnitude, self._half_width, self._count)
        return before


@compiled
def _mean_height(mean: Floats, magnitude: Floats, half_width: int, count: int) -> Floats:
    """(M,) mean height of `count` beeps, from that of all but the last and the last one's magnitude, widened."""
    height = highest_nearby(magnitude, half_width)
    for sample in range(len(mean)):
        height[sample] = mean[sample] + (height[sample] - mean[sample]) / count
    return height


@compiled
def _learnt(mean: Complexes, envelope: Complexes, count: int) -> Complexes:
    """What of an envelope is not in the mean of `count - 1` others; the mean, in place, becomes that of all."""
    rest, share = np.empty(mean.shape, dtype=np.complex128), 1.0 / count
    for mic in range(len(mean)):
        for sample in range(mean.shape[1]):
            rest[mic, sample] = envelope[mic, sample] - mean[mic, sample]
            mean[mic, sample] += rest[mic, sample] * share
    return rest
