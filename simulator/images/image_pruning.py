"""Which patch can be lit through which: what the walk through sequences of mirrors passes over."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, inline="always")
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@numba.njit(cache=True, inline="always")
def distance(a, b):
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return np.sqrt(x * x + y * y + z * z)


@numba.njit(cache=True)
def far_or_aside(image, center, radius, previous_center, previous_radius, goal, goal_radius, limit):
    """Whether the next patch cannot be lit through the previous one within the path length allowed."""
    gap = max(distance(image, center) - radius, 0.0)
    onwards = max(distance(goal, center) - radius - goal_radius, 0.0)
    if gap + onwards > limit:
        return True
    return previous_radius > 0.0 and aside(image, center, radius, previous_center, previous_radius)


@numba.njit(cache=True)
def aside(image, center, radius, window, window_radius):
    """Whether a sphere lies outside the cone from an image through another sphere."""
    a, b = distance(center, image), distance(window, image)
    if a <= radius or b <= window_radius:
        return False
    product = 0.0
    for x in range(3):
        product += (center[x] - image[x]) * (window[x] - image[x])
    angle = np.arccos(min(1.0, max(-1.0, product / (a * b))))
    return angle > np.arcsin(radius / a) + np.arcsin(window_radius / b)


@numba.njit(cache=True)
def grown(array):
    bigger = np.empty((2 * len(array),) + array.shape[1:], array.dtype)
    bigger[: len(array)] = array
    return bigger
