"""Which blocks of samples a detector takes, and when each began."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from obstaclewatch.beep import BeepDesign
from obstaclewatch.support.argument_types import as_number, as_reals

LARGEST = 1e10
"""Re full scale: four times what integers of 32 bits hold, and sums of squares stay finite in single precision."""
LATEST_S = 1e10
"""300 years: farther on a float tells no two samples apart, and in the end no two beeps."""


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
            block: samples re full scale, within +-`LARGEST`.
            time_s: of the first sample; None counts full periods since the last time that was given, 0 s at first.

        Raises:
            ValueError: not (2, period_samples) real numbers, samples that are not finite or too large, or a time that
                is not finite, beyond `LATEST_S` or not later than the last.
        """
        samples = as_reals("a block", block)
        if samples.ndim != 2 or len(samples) != 2:
            raise ValueError(f"a block must have two channels, (2, {self._beep.period_samples}), got {samples.shape}")
        count, given_s = self._given
        passed_s = (self._count - count) * self._beep.period_samples / self._beep.sample_rate_hz
        begin_s = given_s + passed_s if time_s is None else float(as_number("time_s", time_s))
        if not abs(begin_s) <= LATEST_S:  # NaN fails too
            raise ValueError(f"time_s must be finite and within +-{LATEST_S:g} s, got {begin_s}")
        if begin_s <= self._last_s:
            raise ValueError(f"time_s must be later than the last block's {self._last_s} s, got {begin_s} s")
        _check_size(samples)
        return samples.astype(np.float64) if samples.dtype.itemsize > 8 else samples, begin_s

    def passed(self, begin_s: float, time_s: float | None) -> int:
        """Number of the block that was just measured: checked to begin then, by the time that was given with it."""
        if time_s is not None:
            self._given = (self._count, begin_s)
        self._last_s = begin_s
        self._count += 1
        return self._count - 1


def _check_size(samples: NDArray[Any]) -> None:
    """Refuse samples that are no numbers, or so large that sums of their squares are none."""
    if samples.size == 0 or max(samples.max(), -float(samples.min())) <= LARGEST:
        return
    bad = int((~np.isfinite(samples)).sum())
    if bad:
        raise ValueError(f"a block must be finite, got {bad} NaN or infinite samples")
    raise ValueError(f"a block must be re full scale, within +-{LARGEST:g}, got a sample of {np.abs(samples).max():g}")
