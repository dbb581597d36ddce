"""What never changes, taken away: the ringing of the direct sound by coherent mean, standing echoes by a clutter map.

Phone and clock are rigid: the direct sound and its ringing have the same phase in every beep, while an obstacle that
closes in by 2 mm has turned by a quarter of a cycle. A mean over beeps keeps the one and loses the other. The
ground and walls alongside bob with the gait and keep their height only; a mean of heights finds them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage


class CoherentBackground:
    """Running complex mean of the envelopes of successive beeps.

    Args:
        beeps: over how many of them the mean runs once there are so many.
    """

    def __init__(self, beeps: int) -> None:
        self._beeps = beeps
        self._count = 0
        self._mean: NDArray[np.complex128] | None = None

    def clear(self) -> None:
        """Forget all beeps."""
        self._count, self._mean = 0, None

    def subtract(self, envelope: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """What of a (2, M) envelope was not there in the mean of earlier beeps; then learn it. Zeros at first."""
        rest = np.zeros_like(envelope) if self._mean is None else envelope - self._mean
        self._count = min(self._count + 1, self._beeps)
        self._mean = envelope.copy() if self._mean is None else self._mean + rest / self._count
        return rest


class ClutterMap:
    """Running mean height of a profile, widened by how far gait moves a standing echo.

    Args:
        beeps: over how many of them the mean runs once there are so many.
        half_width: samples by which a standing echo may wander.
    """

    def __init__(self, beeps: int, half_width: int) -> None:
        self._beeps = beeps
        self._size = 2 * half_width + 1
        self._count = 0
        self._mean: NDArray[np.float64] | None = None

    def clear(self) -> None:
        """Forget all beeps."""
        self._count, self._mean = 0, None

    @property
    def mean(self) -> NDArray[np.float64] | None:
        """(M,) mean of all beeps' highest value nearby; None before the first."""
        return self._mean

    def level(self, magnitude: NDArray[np.float64]) -> NDArray[np.float64]:
        """(M,) mean of the earlier beeps' highest value nearby; then learn this one. Infinite at first."""
        before = np.full(len(magnitude), np.inf) if self._mean is None else self._mean
        widened = ndimage.maximum_filter1d(magnitude, self._size, mode="nearest")
        self._count = min(self._count + 1, self._beeps)
        self._mean = widened if self._mean is None else self._mean + (widened - self._mean) / self._count
        return before
