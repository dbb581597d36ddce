"""Rows, each once: several times as fast as `np.unique` along an axis, which compares bytes."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints


def distinct(rows: Ints | Floats) -> tuple[Ints, Ints]:
    """(D,) where each distinct row of (R, C) comes first, in order of the rows; and (R,) which of them each is.

    >>> first, which = distinct(np.array([[2, 0], [1, 5], [2, 0]]))
    >>> first.tolist(), which.tolist()
    ([1, 0], [1, 0, 1])
    """
    telling = rows[:, (rows != rows[:1]).any(axis=0)]  # sorting by a constant costs as much as by another
    order = np.lexsort(telling.T[::-1]) if telling.size else np.arange(len(rows))
    ordered = telling[order]
    begins = np.ones(len(rows), dtype=bool)
    begins[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    which = np.empty(len(rows), dtype=np.int64)
    which[order] = np.cumsum(begins) - 1
    return order[begins], which
