"""Images of speaker and microphones that can light a body."""

from __future__ import annotations

from typing import Protocol

import numba
import numpy as np

from obstaclewatch.support.arrays import Floats
from simulator.images.image_pruning import aside, distance, dot
from simulator.images.image_tree import Goal, Images, image_levels, in_turn
from simulator.world.frames import out_of_rest
from simulator.world.world import Tracing


class Body(Protocol):
    """What lighting needs to know of a surface: its obstacle and bounding sphere."""

    @property
    def obstacle(self) -> int: ...

    @property
    def center_m(self) -> Floats: ...

    @property
    def radius_m(self) -> float: ...


def images_lighting(
    tracing: Tracing, surface: Body, point_m: Floats, max_order: int, limit_m: float, extent_m: float = 0.0
) -> Images:
    """Images of a point in the patches from which the surface's bounding sphere, and `extent_m` around, is reached.

    Patches of the surface's own obstacle are no mirrors.
    """
    world, mirrors = tracing.world, tracing.mirrors
    center = out_of_rest(np.broadcast_to(surface.center_m, point_m.shape), tracing.placed[:, surface.obstacle])
    goal = Goal(np.ascontiguousarray(center), surface.radius_m + extent_m, limit_m)
    parts = []
    for level in image_levels(mirrors, world.patches.obstacle != surface.obstacle, point_m, max_order, goal):
        lit = _lit(
            mirrors, level.order, level.pose, level.sequence, level.images_m, goal.center_m, goal.radius_m, limit_m
        )  # type: ignore[call-arg]
        parts.append(level.lit(np.flatnonzero(lit)))
    found = Images(*(np.concatenate(column) for column in zip(*parts, strict=True)))
    return found[in_turn(found.pose, found.sequence)]


@numba.njit(cache=True)
def _lit(mirrors, order, pose, sequence, images, center, radius, limit):
    """(I,) whether an image sees the ball, within the limit and, if it is one, through its last mirror."""
    out = np.zeros(len(pose), np.bool_)
    for r in range(len(pose)):
        n, image = pose[r], images[r, order]
        if distance(image, center[n]) - radius > limit:
            continue
        out[r] = True
        if order > 0:
            p = sequence[r, order - 1]
            rise = dot(center[n], mirrors.normal[n, p]) - mirrors.offset_m[n, p]
            behind = mirrors.one_sided[p] and rise < -radius
            out[r] = not behind and not aside(image, center[n], radius, mirrors.center_m[n, p], mirrors.radius_m[p])
    return out
