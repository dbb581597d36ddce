"""How broad is what is followed? What the kind of its echo says: nothing else that is received does.

A smooth round body widens no crest, and a level depends on the roughness of a surface, not its width. What is received
is where an echo comes from (`posterior_grid`): a corner with the ground is mostly a dustbin's, an echo from between
ground and phone mostly a car's, from a wall anything's. Each kind has its distribution of radii, and the posterior over
kinds mixes them. The radius is half the width across the walk.

What is more likely than not narrow gets the median of the narrow radii; the deviation is the distance from it within
which 68 % of the posterior lies, the chance that it is a car or a wall included. Of anything else no radius is
reported: walls and cars echo from one place, and where they end is not received.
"""

from __future__ import annotations

import numba
import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.trajectories.prior import Hypotheses

EDGES_M = np.array([0.15, 0.2, 0.23, 0.26, 0.29, 0.32, 0.36, 0.41, 0.5, 0.8, 1.1, 1.5, 2.2, 3.5, 8.0])
"""Between classes of radii; evenly spread within a class."""
NARROW = 8
"""Classes up to half a metre: people, posts, signs, most dustbins."""
OF_LEVEL = np.array([5, 3, 9, 12, 9, 13, 3, 1, 12, 5, 4, 7, 6, 12])
OF_BETWEEN = np.array([4, 4, 8, 10, 8, 8, 2, 2, 4, 5, 9, 18, 12, 7])
OF_CORNER = np.array([1, 9, 10, 16, 11, 9, 6, 6, 6, 11, 3, 4, 4, 3])
OF_WALL = np.array([5, 2, 5, 7, 9, 10, 3, 1, 8, 5, 8, 10, 10, 18])
"""Of a hundred targets that are detected so, how many have radii of each class: 289 development walks, weighed by the
posterior over kinds. From the phone's height; from between, or off what leans; from a corner with the ground; off an
upright wall. No script derives these numbers."""
SAID = 0.6827
"""Share of the posterior within one deviation, a normal distribution's."""
HALVINGS = 30


def radius_shares(trajectories: Hypotheses) -> Floats:
    """(H, B) probabilities of the classes of radii, given each trajectory."""
    upright = trajectories.tilt_rad == 0.0
    level, corner = (trajectories.height_m == 0.0) & upright, np.isinf(trajectories.height_m)
    kind = np.select([corner, level & trajectories.is_wall, level], [2, 3, 0], default=1)
    table = np.array([OF_LEVEL, OF_BETWEEN, OF_CORNER, OF_WALL], dtype=np.float64)
    shares: Floats = (table / table.sum(axis=1, keepdims=True))[kind]
    return shares


@numba.njit(cache=True, error_model="numpy")
def narrow_radius(share: Floats, radii: Floats) -> tuple[float, float]:
    """Radius of what is thought narrow, and its deviation, m; NaN both if that is not likelier than not.

    Args:
        share: (H,) probabilities of the trajectories, which sum to 1.
        radii: (H, B) of the classes of radii given each, see `radius_shares`.
    """
    weight = np.dot(share, radii)
    narrow = weight[:NARROW].sum()
    if not narrow >= 0.5:
        return np.nan, np.nan
    radius_m = _median(weight[:NARROW])
    nearest, farthest = 0.0, EDGES_M[-1]
    for _ in range(HALVINGS):
        middle = 0.5 * (nearest + farthest)
        if _share_within(weight, radius_m - middle, radius_m + middle) < SAID:
            nearest = middle
        else:
            farthest = middle
    return radius_m, farthest


@numba.njit(cache=True, error_model="numpy")
def _median(weight: Floats) -> float:
    """Of the first classes (n,), whose weights are not all 0."""
    left, row = 0.5 * weight.sum(), 0
    while left > weight[row]:
        left, row = left - weight[row], row + 1
    return float(EDGES_M[row] + left / weight[row] * (EDGES_M[row + 1] - EDGES_M[row]))


@numba.njit(cache=True, error_model="numpy")
def _share_within(weight: Floats, low_m: float, high_m: float) -> float:
    """Of classes' weights (B,), what lies between two radii."""
    total = 0.0
    for row in range(len(weight)):
        first, last = max(low_m, EDGES_M[row]), min(high_m, EDGES_M[row + 1])
        total += weight[row] * max(last - first, 0.0) / (EDGES_M[row + 1] - EDGES_M[row])
    return total
