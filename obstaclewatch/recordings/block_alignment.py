"""Which blocks of samples a detector takes, and when each began."""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from obstaclewatch.beep import BeepDesign
from obstaclewatch.support.argument_types import check_numbers


class BlockAlignment:
    """Counts the beeps of a stream and refuses blocks that are none of its own.

    Args:
        beep: the emitted signal.
    """

    def __init__(self, beep: BeepDesign) -> None:
        self._beep = beep
        self.clear()

    def clear(self) -> None:
        """Forget all blocks."""
        self._count, self._last_s = 0, -np.inf
        self._given = (0, 0.0)

    def checked(self, block: ArrayLike, time_s: float | None) -> tuple[NDArray[Any], float]:
        """A block as real numbers (2, period_samples), and the time of its first sample; changes nothing.

        Args:
            block: samples; whether they are finite is left to compression, which sees it for nothing.
            time_s: of the first sample; None counts full periods since the last time that was given, 0 s at first.

        Raises:
            ValueError: not (2, period_samples) real numbers, or a time that is not finite or not later than the last.
        """
        samples = np.asarray(block)
        if samples.ndim != 2 or len(samples) != 2:
            raise ValueError(f"a block must have two channels, (2, {self._beep.period_samples}), got {samples.shape}")
        if samples.dtype.kind not in "fiu":
            raise ValueError(f"a block must hold real numbers, got {samples.dtype}")
        if time_s is not None:
            check_numbers(time_s=time_s)
        count, given_s = self._given
        passed_s = (self._count - count) * self._beep.period_samples / self._beep.sample_rate_hz
        begin_s = given_s + passed_s if time_s is None else float(time_s)
        if not isfinite(begin_s):
            raise ValueError(f"time_s must be finite, got {begin_s}")
        if begin_s <= self._last_s:
            raise ValueError(f"time_s must be later than the last block's {self._last_s} s, got {begin_s} s")
        return samples.astype(np.float64) if samples.dtype.itemsize > 8 else samples, begin_s

    def passed(self, begin_s: float, time_s: float | None) -> int:
        """Number of the block that was just measured: checked to begin then, by the time that was given with it."""
        if time_s is not None:
            self._given = (self._count, begin_s)
        self._last_s = begin_s
        self._count += 1
        return self._count - 1
