"""Rows of whole numbers, each once: several times as fast as `np.unique` along an axis, which compares bytes."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Ints


def distinct(rows: Ints) -> tuple[Ints, Ints]:
    """(D,) where each distinct row of (R, C), C at least 1, comes first, in order of the rows; and (R,) which each is.

    >>> first, which = distinct(np.array([[2, 0], [1, 5], [2, 0]]))
    >>> first.tolist(), which.tolist()
    ([1, 0], [1, 0, 1])
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    begins = np.ones(len(rows), dtype=bool)
    begins[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    which = np.empty(len(rows), dtype=np.int64)
    which[order] = np.cumsum(begins) - 1
    return order[begins], which
