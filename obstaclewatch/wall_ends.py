"""What it says of a wall that it is still heard: one that is passed falls silent before it is reached.

A wall mirrors at the foot of its normal through the phone, which lies R sin(a) aside of the walker's line where the
wall stands at the angle a and the distance R. As R falls the foot wanders inwards. A wall that is hit reaches across
the line, so that it is heard until it is met; one that is passed ends aside of the line, and is heard no more once its
foot would lie beyond that end.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from obstaclewatch.course_geometry import Singles

Array = NDArray[np.float64]

GAP_M = (0.08, 0.75)
"""Between the walker's side and the end of a wall that is passed, evenly; what ends farther off is no near miss."""
LEAST_HEARD = 0.02
"""Share of passed walls that are heard from where none should be: by way of their ends."""


def ends_of_passed(half_width_m: float) -> tuple[float, float]:
    """How far aside of a walker's line walls end that are passed, at least and at most."""
    least_m, most_m = GAP_M
    return half_width_m + least_m, half_width_m + most_m


@numba.njit(cache=True, error_model="numpy")
def of_those_heard(
    share: Array, collision: Array, aside: Array, ahead_m: Singles, ends_m: tuple[float, float]
) -> tuple[Array, Array]:
    """(H,) probabilities of courses, and of a collision on each, given that what they lead to is still heard.

    Args:
        share: (H,) probabilities before, 1 together.
        collision: (H,) probabilities of a collision before, above 0.
        aside: (H,) how far aside a wall's foot lies per distance along its normal; infinite for what is no wall.
        ahead_m: (H,) distances along the normal.
        ends_m: how far aside passed walls end, at least and at most.
    """
    heard, hit, (least_m, most_m) = np.empty(len(share)), np.empty(len(share)), ends_m
    for course in range(len(share)):
        end_is_nearer = (aside[course] * ahead_m[course] - least_m) / (most_m - least_m)
        passed = (1.0 - collision[course]) * min(max(end_is_nearer, LEAST_HEARD), 1.0)
        heard[course] = share[course] * (collision[course] + passed)
        hit[course] = collision[course] / (collision[course] + passed)
    return heard / heard.sum(), hit
