"""Images of speaker and microphones that can light sharp edges."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.images.image_pruning import aside, distance, dot, grown
from simulator.images.image_tree import Goal, Images, image_levels, in_turn
from simulator.world.frames import out_of_rest
from simulator.world.mirrors import BORDER_M
from simulator.world.world import Tracing


@dataclass(frozen=True)
class EdgeImages(Images):
    """One row for each edge that an image can light, sorted by pose, then wedge.

    Attributes:
        wedge: (I,).
    """

    wedge: Ints


def images_of(tracing: Tracing, point_m: Floats, max_order: int, limit_m: float) -> EdgeImages:
    """Images of (N, 3) points, one a pose, with up to `max_order` mirrors; the point itself has none."""
    patches, mirrors = tracing.world.patches, tracing.mirrors
    start, end = placed_edges(tracing)
    goal = Goal(point_m, limit_m, limit_m)  # what is nearer than the limit may have an edge
    parts = []
    for level in image_levels(mirrors, np.ones(len(patches), dtype=bool), point_m, max_order, goal):
        row, wedge = _lit(
            mirrors, level.order, level.pose, level.sequence, level.images_m, start, end,
            tracing.world.wedges.patch, tracing.world.wedges.mirror, limit_m,
        )  # type: ignore[call-arg]  # fmt: skip
        parts.append((*level.lit(row), wedge))
    found = EdgeImages(*(np.concatenate(column) for column in zip(*parts, strict=True)))
    return found[in_turn(found.pose, found.sequence, found.wedge)]


def placed_edges(tracing: Tracing) -> tuple[Floats, Floats]:
    """(N, W, 3) starts and ends of all edges at all poses."""
    wedges, poses = tracing.world.wedges, len(tracing.pose)
    frame = tracing.placed[:, wedges.obstacle]
    shape = (poses, len(wedges), 3)
    return (
        np.ascontiguousarray(out_of_rest(np.broadcast_to(wedges.start_m, shape), frame)),
        np.ascontiguousarray(out_of_rest(np.broadcast_to(wedges.end_m, shape), frame)),
    )


@numba.njit(cache=True)
def _lit(mirrors, order, pose, sequence, images, start, end, patch, own_mirror, limit):
    """(R,) image and (R,) edge of all that can light an edge; a crease is lit through its own mirror as well."""
    rows, wedges = np.empty(256, np.int64), np.empty(256, np.int64)
    middle = 0.5 * (start + end)
    half = np.empty(middle.shape[:2])
    for n in range(half.shape[0]):
        for w in range(half.shape[1]):
            half[n, w] = 0.5 * distance(end[n, w], start[n, w])
    found = 0
    for r in range(len(pose)):
        n, image = pose[r], images[r, order]
        for w in range(start.shape[1]):
            if distance(image, middle[n, w]) - half[n, w] > limit:
                continue
            if order > 0:
                p = sequence[r, order - 1]
                if p == patch[w, 0] or p == patch[w, 1]:
                    continue
                through = _through(mirrors, n, p, image, start[n, w], end[n, w], middle[n, w], half[n, w])
                if p != own_mirror[w] and not through:
                    continue
            if found == len(rows):
                rows, wedges = grown(rows), grown(wedges)
            rows[found], wedges[found] = r, w
            found += 1
    return rows[:found], wedges[:found]


@numba.njit(cache=True)
def _through(mirrors, n, p, image, start, end, middle, half):
    """Whether some of an edge lies beyond a mirror as its image sees it."""
    normal, offset = mirrors.normal[n, p], mirrors.offset_m[n, p]
    side = -1.0 if dot(image, normal) - offset > 0.0 else 1.0
    rise = max(side * (dot(start, normal) - offset), side * (dot(end, normal) - offset))
    return rise > BORDER_M and not aside(image, middle, half, mirrors.center_m[n, p], mirrors.radius_m[p])
