"""Products and distances of vectors in space, for compiled loops."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.compiled import inlined


@inlined
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def distance(a, b):
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return np.sqrt(x * x + y * y + z * z)
