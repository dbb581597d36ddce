"""Which facets of a body an image of speaker or microphone lights: asked of Embree once for every image."""

from __future__ import annotations

import numba
import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.images import image_method as specular
from simulator.images.image_tree import Images
from simulator.images.planar import crossed
from simulator.surfaces.facets import Facets
from simulator.world.frames import into_rest, out_of_rest, turned
from simulator.world.visibility import OFFSET
from simulator.world.world import Tracing

IMAGES_AT_ONCE = 8  # times facets: what is asked of Embree in one batch
SAMPLES = (0.0, 0.33, 0.67, 1.0)  # places in a piece that are asked first


def lit_facets(tracing: Tracing, facets: Facets, start_m: Floats, images: Images) -> Flags:
    """(R, F) facets that each image sees: turned towards it, and nothing between on any leg."""
    key = np.column_stack([images.pose, images.sequence])
    first, which = np.unique(key, axis=0, return_index=True, return_inverse=True)[1:]
    lit = np.zeros((len(first), len(facets)), dtype=bool)
    for start in range(0, len(first), IMAGES_AT_ONCE):
        some = images[first[start : start + IMAGES_AT_ONCE]]
        lit[start : start + len(some.pose)] = _lit(tracing, facets, start_m, some)
    return lit[which.ravel()]


def _lit(tracing: Tracing, facets: Facets, start_m: Floats, images: Images) -> Flags:
    """(I, F) facets lit; where a piece's samples agree they speak for all of it, where not every facet is asked."""
    facing = _facing(tracing, facets, images)
    lit = np.zeros_like(facing)
    count = np.diff(facets.start)
    samples = np.unique(
        np.concatenate([facets.start[:-1] + (share * (count - 1)).astype(np.int64) for share in SAMPLES])
    )
    _ask(tracing, facets, start_m, images, facing, samples, lit)
    asked = np.zeros(len(facets), dtype=bool)
    asked[samples] = True
    seen, hidden = (np.add.reduceat(flags & asked, facets.start[:-1], axis=1) for flags in (lit, facing & ~lit))
    piece = np.repeat(np.arange(len(count)), count)
    mixed = ((seen > 0) & (hidden > 0))[:, piece]
    _ask(tracing, facets, start_m, images, facing & mixed & ~asked, np.arange(len(facets)), lit)
    return lit | (facing & ~mixed & (seen > 0)[:, piece])


def _facing(tracing: Tracing, facets: Facets, images: Images) -> Flags:
    """(I, F) facets whose outside is turned to the image; all of an open surface's."""
    point = into_rest(images.point_m, tracing.placed[images.pose, facets.obstacle])
    if not facets.closed:
        return np.ones((len(point), len(facets)), dtype=bool)
    return point @ facets.normal.T > np.sum(facets.middle_m * facets.normal, axis=1)


def _ask(
    tracing: Tracing, facets: Facets, start_m: Floats, images: Images, wanted: Flags, among: Ints, lit: Flags
) -> None:
    """Mark in `lit` (I, F) those of the wanted facets among some that sound from each image's origin reaches."""
    image, place = np.nonzero(wanted[:, among])
    facet = among[place]
    lit[image, facet] = _reached(tracing, facets, start_m, images[image], facet)


def _reached(tracing: Tracing, facets: Facets, start_m: Floats, images: Images, facet: Ints) -> Flags:
    """(R,) whether sound from each image's origin comes to each facet through its mirrors, with every leg free."""
    world, frame = tracing.world, tracing.placed[images.pose, facets.obstacle]
    target = out_of_rest(facets.middle_m[facet], frame)
    start = np.ascontiguousarray(start_m[images.pose])
    code, hits = crossed(tracing, start, target, images.pose, images.order, images.sequence)
    normal = turned(facets.normal[facet], frame[:, 3])
    gap = OFFSET * max(shadow.extent_m for shadow in world.blockers)
    patches = world.patches.normal, world.patches.obstacle
    stops = _lifted_stops(
        start, hits, target, normal, facets.lift_m[facet], images.pose, images.order, images.sequence, *patches,
        tracing.placed, gap,
    )  # type: ignore[call-arg]  # fmt: skip
    free = code == specular.REACHED
    for k in range(images.sequence.shape[1] + 1):
        for shadow in world.blockers:
            rows = np.flatnonzero(free & (images.order >= k))
            placed = tracing.placed[:, shadow.obstacle]
            free[rows] &= ~shadow.blocks_from(stops[rows, k], stops[rows, k + 1], placed, images.pose[rows])
    return free


@numba.njit(cache=True)
def _lifted_stops(start, hits, target, normal, lift, pose, order, sequence, plane, obstacle, frames, gap):
    """(R, K + 2, 3) start, crossings of the mirrors lifted by `gap`, and the facet's lifted middle, row by row.

    Args:
        start, target, normal, lift: (R, 3), (R, 3), (R, 3), (R,) where sound starts, and the facets, world frame.
        hits, pose, order, sequence: of the mirrors.
        plane, obstacle: (P, 3) normals of the patches in the rest frames of their obstacles.
        frames: (N, O, 4).
    """
    stops = np.zeros((len(pose), hits.shape[1] + 2, 3))
    across = np.empty(3)
    for r in range(len(pose)):
        stops[r, 0] = start[r]
        before = start[r]
        for k in range(order[r]):
            p = sequence[r, k]
            yaw = frames[pose[r], obstacle[p], 3]
            c, s = np.cos(yaw), np.sin(yaw)
            across[0], across[1] = c * plane[p, 0] - s * plane[p, 1], s * plane[p, 0] + c * plane[p, 1]
            across[2] = plane[p, 2]
            rise = 0.0
            for x in range(3):
                rise += across[x] * (before[x] - hits[r, k, x])
            side = gap if rise >= 0.0 else -gap
            for x in range(3):
                stops[r, k + 1, x] = hits[r, k, x] + side * across[x]
            before = hits[r, k]
        rise = 0.0
        for x in range(3):
            rise += normal[r, x] * (before[x] - target[r, x])
        side = lift[r] if rise >= 0.0 else -lift[r]
        for x in range(3):
            stops[r, order[r] + 1, x] = target[r, x] + side * normal[r, x]
    return stops
