"""Samples on demand from a recording that arrives in pieces; what has been used is forgotten."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from obstaclewatch.recording import Recording
from obstaclewatch.support.argument_types import check_types
from obstaclewatch.support.arrays import Singles


class SampleFeed:
    """A window that moves forwards over the pieces of a recording, in constant memory.

    Samples are numbered from the recording's first one.

    Args:
        pieces: the recording, piece by piece; all of one rate.
        sample_rate_hz: the rate they must have.

    Raises:
        ValueError: pieces that are none; while reading, something else than a recording, or one of another rate.
    """

    def __init__(self, pieces: Iterable[Recording], sample_rate_hz: float) -> None:
        check_types(pieces=(pieces, Iterable))
        self._pieces: Iterator[Recording] = iter(pieces)
        self._rate = sample_rate_hz
        self._held: Singles = np.empty((2, 0), dtype=np.float32)
        self._first = 0

    def take(self, begin: int, end: int) -> Singles:
        """(2, n) samples `begin` to `end` (excluded); fewer at the recording's end.

        Raises:
            ValueError: samples that were forgotten, or a piece of another rate.
        """
        if begin < self._first:
            raise ValueError(f"samples before {self._first} are forgotten, got {begin}")
        while self._first + self._held.shape[1] < end and self._grow():
            pass
        return self._held[:, begin - self._first : end - self._first]

    def forget(self, before: int) -> None:
        """Let go of the samples before this one."""
        gone = min(max(before - self._first, 0), self._held.shape[1])
        self._held = self._held[:, gone:]
        self._first += gone

    def _grow(self) -> bool:
        piece = next(self._pieces, None)
        if piece is None:
            return False
        check_types(piece=(piece, Recording))
        if piece.sample_rate_hz != self._rate:
            raise ValueError(
                f"the recording's sample rate must be the beep's, {self._rate} Hz, got {piece.sample_rate_hz} Hz"
            )
        self._held = np.concatenate([self._held, piece.samples], axis=1) if self._held.shape[1] else piece.samples
        return True
