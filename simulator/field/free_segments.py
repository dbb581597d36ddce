"""Whether every leg of a path is free: ends on a surface are lifted off the mesh along the normal."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats
from simulator.diffraction.single import lifts, point_slot
from simulator.world.candidates import Candidates
from simulator.world.sight import free_between
from simulator.world.visibility import OFFSET
from simulator.world.world import Tracing


def legs_free(tracing: Tracing, found: Candidates) -> Flags:
    """(C,) whether nothing stands between any two points of a path in turn."""
    start, end = _lifted_legs(tracing, found)
    free = np.ones(len(found), dtype=bool)
    for k in range(start.shape[1]):
        rows = np.flatnonzero(free & (found.order >= k))
        if len(rows) == 0:
            continue
        free[rows] = free_between(tracing, start[rows, k], end[rows, k], found.pose[rows])
    return free


def _lifted_legs(tracing: Tracing, found: Candidates) -> tuple[Floats, Floats]:
    """(C, N + 1, 3) starts and ends of the legs, clear of the surfaces that they leave and meet."""
    extent = max((shadow.extent_m for shadow in tracing.world.blockers), default=1.0)
    lift = found.lift_m + OFFSET * extent
    lifted = found.points_m.copy()
    inner = np.arange(found.sequence.shape[1])[None, :] < found.order[:, None]
    lifted[:, 1:-1] += np.where(inner[:, :, None], lift[:, :, None] * found.normal, 0.0)
    start, end = lifted[:, :-1].copy(), lifted[:, 1:]
    over = np.flatnonzero(found.edge >= 0)
    at, (arriving, leaving) = point_slot(tracing, found[over]), lifts(tracing, found[over])
    end[over, at] += OFFSET * extent * arriving
    start[over, at + 1] += OFFSET * extent * leaving
    return start, end
