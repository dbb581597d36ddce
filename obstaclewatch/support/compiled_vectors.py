"""Scalar products and distances of single vectors of space, and products of matrices, for compiled loops."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.compiled import compiled, inlined


@inlined
def dot(a, b):
    """Scalar product of vectors (3,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def distance(a, b):
    """Between points (3,)."""
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return np.sqrt(x * x + y * y + z * z)


@compiled
def multiplied(a, b, product):
    """Fill in the product of matrices (3, 3)."""
    for i in range(3):
        for j in range(3):
            product[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
