"""The k-th lowest of some numbers, for compiled loops: numba takes seconds to compile `np.partition` into each."""

from __future__ import annotations

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled, inlined


@compiled
def order_statistic(values: Floats, rank: int) -> float:
    """The number at a place of (n,) numbers in order, the lowest being at 0 (Hoare 1961, algorithm 65, "Find").

    >>> import numpy as np
    >>> float(order_statistic(np.array([3.0, 1.0, 2.0]), 1))
    2.0
    """
    work, low, high = values.copy(), 0, len(values) - 1
    while low < high:
        pivot, first, last = work[rank], low, high
        while first <= last:
            while work[first] < pivot:
                first += 1
            while work[last] > pivot:
                last -= 1
            if first <= last:
                work[first], work[last] = work[last], work[first]
                first, last = first + 1, last - 1
        low, high = (first if last < rank else low), (last if rank < first else high)
    return work[rank]


@inlined
def median(values: Floats) -> float:
    """The mean of the two middle ones of (n,) numbers, or the middle one."""
    return 0.5 * (order_statistic(values, (len(values) - 1) // 2) + order_statistic(values, len(values) // 2))
