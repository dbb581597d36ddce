"""Whether the straight segment between two points is free of all obstacles."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
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
