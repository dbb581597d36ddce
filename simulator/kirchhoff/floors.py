"""Mirrors of other obstacles that a body stands on and that go on beside it, as a floor does: its image continues it.

A lid or a band of the body's own outline ends with it. Taken for a floor, such a lid made the echo of a bin 4 dB too
loud for a phone at the lid's height.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled
from obstaclewatch.support.compiled_vectors import dot
from simulator.images.image_method import inside_patch
from simulator.world.corners import STANDS_ON_M
from simulator.world.frames import out_of_rest, rotated
from simulator.world.mirrors import gaps_to_others
from simulator.world.world import Tracing

BESIDE_M = 3e-3
"""What a floor reaches beyond a body at least. A lid that stands over a bin by 1 or 2 mm makes echoes 2 to 5 dB too
loud where it counts as a floor; from 3 mm on they are within 0.5 dB."""
LEAST_SINE = 0.1  # between a surface's normal and a mirror's: what lies flatter has no side on which the mirror goes on


def gaps_to_floors(
    tracing: Tracing, pose: int, obstacle: int, point_m: Floats, normal: Floats
) -> tuple[Floats, Floats]:
    """Distances (B, M) of points of an obstacle, with unit normals (B, 3), both in its rest frame, from mirrors of
    others; infinite where these are not touched, or end beside the point.

    The second result holds the mirrors' (M, 3) normals.
    """
    mirrors = tracing.mirrors
    gap, plane = gaps_to_others(mirrors, pose, obstacle, point_m)
    gap = np.where(gap < STANDS_ON_M, gap, np.inf)
    row, column = np.nonzero(np.isfinite(gap))
    out = rotated(normal[row], tracing.placed[pose, obstacle, 3])
    out = out - np.sum(out * plane[column], axis=1)[:, None] * plane[column]
    size = np.linalg.norm(out, axis=1)
    beside = out_of_rest(point_m[row], tracing.placed[pose, obstacle])
    beside = beside + BESIDE_M * out / np.maximum(size, LEAST_SINE)[:, None]
    patch = np.flatnonzero(mirrors.obstacle != obstacle)[column]
    ends = (size >= LEAST_SINE) & ~_inside(mirrors, pose, patch, beside)  # type: ignore[call-arg]
    gap[row[ends], column[ends]] = np.inf
    return gap, plane


@compiled
def _inside(mirrors, pose, patch, point):
    """(R,) whether the feet of points (R, 3) on the planes of patches (R,) lie within these at a pose."""
    found = np.zeros(len(patch), np.bool_)
    for r in range(len(patch)):
        p = patch[r]
        foot = point[r] - (dot(point[r], mirrors.normal[pose, p]) - mirrors.offset_m[pose, p]) * mirrors.normal[pose, p]
        found[r] = inside_patch(mirrors, pose, p, foot[0], foot[1], foot[2])
    return found
