"""Whether the straight segment between two points is free of all obstacles."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled
from simulator.world.visibility import OFFSET, Blocker
from simulator.world.world import Tracing


def free_between(tracing: Tracing, start_m: Floats, end_m: Floats, pose: Ints, blockers: tuple[Blocker, ...]) -> Flags:
    """(R,) whether none of the blockers stands between points (R, 3) at poses (R,).

    Segments in a corner that float32 cannot tell from its faces are free.
    """
    free = np.ones(len(pose), dtype=bool)
    length = np.linalg.norm(end_m - start_m, axis=1)
    for shadow in blockers:
        asked = free & (length > 2.0 * OFFSET * shadow.extent_m)
        free &= ~shadow.blocks_from(start_m, end_m, tracing.placed[:, shadow.obstacle], pose, asked)
    return free


def in_the_way(tracing: Tracing, start_m: Floats, end_m: Floats, asked: Flags) -> list[Blocker]:
    """The blockers that may stand between points (R, 3) of the rows asked for (R,), at some pose.

    Most stand elsewhere in the street: this asks each blocker once, and not each row of each.
    """
    low_m, high_m = _box(start_m, end_m, asked)  # type: ignore[call-arg]
    return [
        shadow for shadow in tracing.world.blockers if shadow.reaches(low_m, high_m, tracing.placed[:, shadow.obstacle])
    ]


@compiled
def _box(start, end, asked):
    """(3,) lowest and (3,) highest coordinates of some of the points."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for r in range(len(start)):
        if asked[r]:
            for k in range(3):
                low[k] = min(low[k], start[r, k], end[r, k])
                high[k] = max(high[k], start[r, k], end[r, k])
    return low, high
