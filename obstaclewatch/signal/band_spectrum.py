"""A few neighbouring bins of a long spectrum: decimation in time, without the bins that nobody reads.

The samples are dealt to `PHASES` slow sequences. Each is transformed, and a bin of the full spectrum is the sum of
their bins, each rotated by its head start (Cooley and Tukey 1965). Of the paper's beep 545 of 8641 bins are wanted: a
third of the work of the full transform.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from obstaclewatch.support.arrays import Flags
from obstaclewatch.support.compiled import compiled

PHASES = 8


class BandSpectrum:
    """Bins `low` to `high` (excluded) of the spectrum of real signals of `length` samples, as `rfft` gives them.

    Args:
        length: samples transformed; a multiple of `PHASES` (`fast_length`).
        low, high: first and one-past-last bin, within 0..length // 2.

    Raises:
        ValueError: a length that is no multiple of `PHASES`, or bins out of range.
    """

    def __init__(self, length: int, low: int, high: int) -> None:
        if length % PHASES:
            raise ValueError(f"length must be a multiple of {PHASES}, got {length}")
        if not 0 <= low < high <= length // 2 + 1:
            raise ValueError(f"bins must be 0 <= low < high <= {length // 2 + 1}, got {low} and {high}")
        self.length = length
        wanted, rows = np.arange(low, high), length // PHASES
        row = wanted % rows
        self._mirrored = row > rows // 2  # a slow sequence of M samples has bins 0 to M // 2; the others mirror them
        self._row = np.where(self._mirrored, rows - row, row)
        self._rotation = np.exp(-2j * np.pi * np.outer(wanted, np.arange(PHASES)) / length)
        self._rotation[self._mirrored] = self._rotation[self._mirrored].conj()
        self._single_rotation = self._rotation.astype(np.complex64)

    @staticmethod
    def fast_length(samples: int) -> int:
        """Least fast length that holds so many samples."""
        return PHASES * int(fft.next_fast_len(-(-samples // PHASES), real=True))

    def __call__(self, block: NDArray[np.floating]) -> NDArray[np.complexfloating]:
        """(C, high - low) bins of (C, N) samples, N at most `length`; single precision stays single."""
        if block.shape[1] < self.length:
            block = np.pad(block, ((0, 0), (0, self.length - block.shape[1])))
        slow = fft.rfft(block.reshape(len(block), -1, PHASES), axis=1)
        rotation = self._rotation if slow.dtype == np.complex128 else self._single_rotation
        return _rotated_sums(slow, self._row, self._mirrored, rotation)


@compiled
def _rotated_sums(
    slow: NDArray[np.complexfloating], row: NDArray[np.intp], mirrored: Flags, rotation: NDArray[np.complexfloating]
) -> NDArray[np.complexfloating]:
    """(C, B) sums over the slow sequences' bins (C, rows, PHASES), each rotated, conjugate where mirrored."""
    sums = np.empty((len(slow), len(row)), dtype=slow.dtype)
    for channel in range(len(slow)):
        for wanted in range(len(row)):
            total = slow[channel, row[wanted], 0] * rotation[wanted, 0]
            for phase in range(1, PHASES):
                total += slow[channel, row[wanted], phase] * rotation[wanted, phase]
            sums[channel, wanted] = total.conjugate() if mirrored[wanted] else total
    return sums
