"""Whether the straight segment between two points is free of all obstacles."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.world.world import Tracing


def free_between(tracing: Tracing, start_m: Floats, end_m: Floats, pose: Ints) -> Flags:
    """(R,) whether nothing stands between points (R, 3) at poses (R,)."""
    free = np.ones(len(pose), dtype=bool)
    for shadow in tracing.world.blockers:
        free &= ~shadow.blocks_from(start_m, end_m, tracing.placed[:, shadow.obstacle], pose)
    return free
