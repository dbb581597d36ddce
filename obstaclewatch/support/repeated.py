"""Each of several things as often as its count says, and which of its copies each is."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Ints


def repeated(count: Ints) -> tuple[Ints, Ints]:
    """(R,) thing of every copy, thing by thing, and (R,) its number among that thing's, from 0.

    >>> [rows.tolist() for rows in repeated(np.array([2, 0, 3]))]
    [[0, 0, 2, 2, 2], [0, 1, 0, 1, 2]]
    """
    thing = np.repeat(np.arange(len(count)), count)
    return thing, np.arange(len(thing)) - (np.cumsum(count) - count)[thing]
