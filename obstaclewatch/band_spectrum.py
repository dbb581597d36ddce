"""A few neighbouring bins of a long spectrum: decimation in time, without the bins that nobody reads.

The samples are dealt to `PHASES` slow sequences. Each is transformed, and a bin of the whole is the sum of their bins,
each turned by its head start (Cooley and Tukey 1965). Of the paper's beep 545 of 8641 bins are wanted: a third of the
work of transforming the whole.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft

PHASES = 8


@dataclass(frozen=True)
class _Piece:
    """Wanted bins that read the slow sequences' bins in one direction.

    A slow sequence of M samples has the bins 0 to M // 2; those beyond mirror them, conjugate.
    """

    wanted: slice
    rows: slice
    mirrored: bool
    turn: NDArray[np.complex128]

    @cached_property
    def single_turn(self) -> NDArray[np.complex64]:
        """The same for spectra in single precision."""
        return self.turn.astype(np.complex64)


class BandSpectrum:
    """Bins `low` to `high` (excluded) of the spectrum of real signals of `length` samples, as `rfft` gives them.

    Args:
        length: samples transformed; a multiple of `PHASES` (`whole_length`).
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
        self._bins = high - low
        self._pieces = _pieces(length, low, high)

    @staticmethod
    def whole_length(samples: int) -> int:
        """Least fast length that holds so many samples."""
        return PHASES * int(fft.next_fast_len(-(-samples // PHASES), real=True))

    def __call__(self, block: NDArray[np.floating]) -> NDArray[np.complexfloating]:
        """(C, high - low) bins of (C, N) samples, N at most `length`; single precision stays single."""
        if block.shape[1] < self.length:
            block = np.pad(block, ((0, 0), (0, self.length - block.shape[1])))
        slow = fft.rfft(block.reshape(len(block), -1, PHASES), axis=1)
        bins = np.empty((len(block), self._bins), dtype=slow.dtype)
        for piece in self._pieces:
            turn = piece.turn if slow.dtype == np.complex128 else piece.single_turn
            turned = np.einsum("ckp,kp->ck", slow[:, piece.rows], turn)
            bins[:, piece.wanted] = turned.conj() if piece.mirrored else turned
        return bins


def _pieces(length: int, low: int, high: int) -> list[_Piece]:
    """Cut the wanted bins where the slow sequences' bins change direction."""
    whole = length // PHASES
    wanted = np.arange(low, high)
    within = wanted % whole
    mirrored = within > whole // 2
    cuts = np.flatnonzero(np.diff(mirrored.astype(int)) | (np.diff(within) < 0)) + 1
    pieces = []
    for first, last in zip(np.r_[0, cuts], np.r_[cuts, len(wanted)], strict=True):
        turn = np.exp(-2j * np.pi * np.outer(wanted[first:last], np.arange(PHASES)) / length)
        back = bool(mirrored[first])
        rows = whole - within[first:last] if back else within[first:last]
        step = -1 if back else 1
        end = int(rows[-1]) + step
        pieces.append(
            _Piece(slice(int(first), int(last)), slice(int(rows[0]), end if end >= 0 else None, step), back,
                   turn.conj() if back else turn)
        )  # fmt: skip
    return pieces
