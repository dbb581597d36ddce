"""The last rows of a growing table, kept as one array.

A deque of tuples must be gathered into arrays whenever it is used; here rows lie side by side as they come, and move to
the front once in as many rows as are kept.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray


class LastRows:
    """At most the last so many rows.

    Args:
        most: rows that are kept.
        width: of a row.
        dtype: of its values.
    """

    def __init__(self, most: int, width: int, dtype: DTypeLike = np.float64) -> None:
        self._most, self._table = most, np.empty((2 * most, width), dtype)
        self.clear()

    def clear(self) -> None:
        """Drop all rows."""
        self._first = self._end = 0

    def __len__(self) -> int:
        return self._end - self._first

    @property
    def rows(self) -> NDArray[Any]:
        """(n, width) rows, the oldest first: a view, good until the next one is appended."""
        return self._table[self._first : self._end]

    def append(self, row: ArrayLike) -> None:
        """Add a row; the oldest goes if there are too many."""
        if self._end == len(self._table):
            kept = self._table[self._first + (len(self) == self._most) :].copy()
            self._table[: len(kept)] = kept
            self._first, self._end = 0, len(kept)
        self._table[self._end] = row
        self._end += 1
        self._first = max(self._first, self._end - self._most)

    def drop(self, count: int) -> None:
        """Drop the oldest rows."""
        self._first = min(self._first + count, self._end)
