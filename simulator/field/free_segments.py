"""Whether every segment of a path is free: ends on a surface are displaced off the mesh along the normal."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import dot, norm
from simulator.diffraction.edge_view import at_poses
from simulator.diffraction.single import off_faces, point_slot
from simulator.surfaces.wedges import Wedges
from simulator.world.candidates import Candidates
from simulator.world.line_of_sight import free_between
from simulator.world.visibility import COINCIDENT_M, Blocker
from simulator.world.world import Tracing

PAST = 1.5  # thicknesses of a thin plate, from whose edge a segment begins, that lie within its rim
FLATTEST = 0.1  # sine between a segment and a plate: what runs along a plate is in its rim for ten times as long


def segments_free(tracing: Tracing, found: Candidates, blockers: tuple[Blocker, ...]) -> Flags:
    """(C,) whether none of the blockers stands between any two points of a path in turn."""
    return np.asarray(free_segments(tracing, found, blockers).all(axis=1))


def free_segments(tracing: Tracing, found: Candidates, blockers: tuple[Blocker, ...]) -> Flags:
    """(C, N + 1) whether none of the blockers stands in each segment; what is beyond the end of a path is free.

    The rim of a thin plate has two edges, and for sound they are one: neither hides the other.
    """
    start, end = displaced_segments(tracing, found)
    free = np.ones(start.shape[:2], dtype=bool)

    def ask(row: Ints, k: Ints) -> None:
        free[row, k] = free_between(tracing, start[row, k], end[row, k], found.pose[row], blockers)

    ask(*np.nonzero(np.arange(start.shape[1]) <= found.order[:, None]))
    over = np.flatnonzero(found.edge >= 0)
    over = over[np.isfinite(tracing.world.wedges.sheet_m[found.edge[over]])]
    for step, off_edge, other in ((0, end, start), (1, start, end)):
        k = point_slot(found[over]) + step
        hidden = np.flatnonzero(~free[over, k])
        row, k = over[hidden], k[hidden]
        rims = at_poses(tracing, found.edge[row], found.pose[row])
        off_edge[row, k] = _past_rim(off_edge[row, k], other[row, k], rims)
        ask(row, k)
    return free


def _past_rim(point_m: Floats, towards_m: Floats, rims: Wedges) -> Floats:
    """(R, 3) where segments from points on the edges of plates have passed their thickness, or are half done."""
    step = towards_m - point_m
    slant = np.maximum(np.abs(dot(step, rims.normal)), FLATTEST * norm(step))
    passed: Floats = point_m + np.minimum(PAST * rims.sheet_m / slant, 0.5)[:, None] * step
    return passed


def displaced_segments(tracing: Tracing, found: Candidates) -> tuple[Floats, Floats]:
    """(C, N + 1, 3) starts and ends of the segments, clear of the surfaces that they leave and meet."""
    clear_m = tracing.world.clear_m
    clearance = found.standoff_m + clear_m
    displaced = found.points_m.copy()
    inner = np.arange(found.sequence.shape[1])[None, :] < found.order[:, None]
    displaced[:, 1:-1] += np.where(inner[:, :, None], clearance[:, :, None] * found.normal, 0.0)
    start, end = displaced[:, :-1].copy(), displaced[:, 1:]
    over = np.flatnonzero(found.edge >= 0)
    if not len(over):
        return start, end
    at, (arriving, leaving) = point_slot(found[over]), off_faces(tracing, found[over])
    end[over, at] += clear_m * arriving
    start[over, at + 1] += clear_m * leaving
    _part_from_corner(found, over, at, -1, end, start)
    _part_from_corner(found, over, at + 1, 1, start, end)
    return start, end


def _part_from_corner(found: Candidates, over: Ints, segment: Ints, step: int, here: Floats, there: Floats) -> None:
    """Where an edge (R,) stands on the mirror beside it, the segment between them has no length: clear both of both.

    Args:
        segment: (R,) the segment from the edge to the mirror; the mirror's other segment is `step` further.
        here, there: (C, N + 1, 3) ends of all segments: at the edge for `segment`, and at the mirror.
    """
    length = np.linalg.norm(found.points_m[over, segment + 1] - found.points_m[over, segment], axis=1)
    rows = np.flatnonzero((length < COINCIDENT_M) & (segment + step >= 0) & (segment < found.order[over] + (step < 0)))
    row, at = over[rows], segment[rows]
    offset = here[row, at] + there[row, at] - found.points_m[row, at] - found.points_m[row, at + 1]
    point = found.points_m[row, at] + offset
    here[row, at] = there[row, at] = here[row, at + step] = point
