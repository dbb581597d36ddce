"""Triangles cut into small ones of an even size, long and thin triangles too.

Halving the longest edge again and again keeps the angles of the triangle it began with: the side of a cylinder falls
into needles 1 mm wide. Here a triangle is cut into rows along its shortest edge, and each row into as many pieces as
it is wide. Which corner is its left one goes by the lengths of its sides, so that a mesh wound the other way round has
the same pieces.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.compiled import compiled

_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])  # (eta, zeta) of a quadratic triangle's corners


def cut_up(excess: Floats) -> tuple[Ints, Floats]:
    """Owners (R,) and places (R, 3, 2) of pieces.

    Args:
        excess: (T, 3) lengths of the edges 01, 12 and 20 re the longest that is allowed.
    """
    apex = (excess.argmin(axis=1) + 2) % 3  # the corner across from the shortest edge
    after, before = (np.take_along_axis(excess, (apex + k)[:, None] % 3, axis=1)[:, 0] for k in (0, 2))
    left = np.where(after >= before, apex + 1, apex + 2) % 3  # at the end of the longer side
    base = np.maximum(excess.min(axis=1), 1e-9)
    rows = np.maximum(np.ceil(excess.max(axis=1)), 1.0).astype(np.int64)
    count = _counts(rows, base)
    owner = np.repeat(np.arange(len(excess)), count)
    return owner, _pieces(rows, base, np.stack([apex, left, 3 - apex - left], axis=1), _CORNERS, int(count.sum()))


@compiled
def _across(base, row, rows):
    """Pieces of the line `row` of `rows`, counted from the apex."""
    return 0 if row == 0 else max(1, int(np.ceil(base * row / rows - 1e-9)))


@compiled
def _counts(rows, base):
    """(T,) pieces of each triangle: along both lines of each row."""
    count = np.zeros(len(rows), np.int64)
    for t in range(len(rows)):
        for i in range(1, rows[t] + 1):
            count[t] += _across(base[t], i - 1, rows[t]) + _across(base[t], i, rows[t])
    return count


@compiled
def _pieces(rows, base, turn, corners, count):
    """(count, 3, 2) places of the pieces' corners; `turn` (T, 3) has the apex, the left and the right corner."""
    place, at = np.empty((count, 3, 2)), 0
    for t in range(len(rows)):
        top, left, right = corners[turn[t, 0]], corners[turn[t, 1]], corners[turn[t, 2]]
        for i in range(1, rows[t] + 1):
            upper, lower = _across(base[t], i - 1, rows[t]), _across(base[t], i, rows[t])
            here, there = (i - 1) / rows[t], i / rows[t]
            for j in range(lower):
                _put(place[at, 0], top, left, right, there, j / lower)
                _put(place[at, 1], top, left, right, there, (j + 1) / lower)
                _put(place[at, 2], top, left, right, here, j / max(upper, 1))
                at += 1
            for j in range(upper):
                _put(place[at, 0], top, left, right, here, (j + 1) / upper)
                _put(place[at, 1], top, left, right, here, j / upper)
                _put(place[at, 2], top, left, right, there, (j + 1) / lower)
                at += 1
    return place


@compiled
def _put(place, top, left, right, down, across):
    for x in range(2):
        place[x] = (1.0 - down) * top[x] + down * ((1.0 - across) * left[x] + across * right[x])
