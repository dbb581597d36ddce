"""Lengths, directions and scalar products of many vectors of the plane or of space.

`np.sum` and `np.linalg.norm` over a last axis of three take seven times as long: they set up a loop for every row. The
sums are theirs to the last bit.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats


def dot(one: Floats, other: Floats) -> Floats:
    """(...) scalar products of (..., D) vectors.

    >>> dot(np.array([[1.0, 2.0, 3.0], [0.0, 1.0, 0.0]]), np.array([4.0, 5.0, 6.0]))
    array([32.,  5.])
    """
    one, other = np.asarray(one), np.asarray(other)
    total = one[..., 0] * other[..., 0]
    for x in range(1, one.shape[-1]):
        total = total + one[..., x] * other[..., x]
    return total


def norm(vector: Floats) -> Floats:
    """(...) lengths of (..., D) vectors.

    >>> norm(np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 2.0]]))
    array([5., 2.])
    """
    return np.sqrt(dot(vector, vector))


def unit(vector: Floats) -> Floats:
    """(..., D) vectors of length 1 in the directions of others; 0 where these are.

    >>> unit(np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 0.0]]))
    array([[0.6, 0.8, 0. ],
           [0. , 0. , 0. ]])
    """
    return vector / np.maximum(norm(vector)[..., None], 1e-300)
