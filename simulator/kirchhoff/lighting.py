"""Which spots of a body an image of speaker or microphone sees: asked of Embree once for each spot.

A spot is a patch of the skin, and one of its facets speaks for it. The three transducers of a phone see nearly the
same, and so do the poses of a walk that lie near each other: spots may be asked once for all of them.
"""

from __future__ import annotations

from dataclasses import dataclass

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

AT_ONCE = 2**17  # rays: what is kept in memory of them, however many images there are
SAMPLE = 8  # one spot in so many is asked first: an image that sees none of them sees nothing
NORMAL_STEPS = 2  # for a normal's component from 0 to 1: each range is some 30 degrees wide


@dataclass(frozen=True)
class Light:
    """How finely the light on a body is asked for.

    Attributes:
        spot_m: size of the spots; no larger than a facet asks for each facet.
        held: how far the phone may move on, re its distance from the body, until it is asked for again; 0 asks for each
            pose and each transducer.
    """

    spot_m: float
    held: float


@dataclass(frozen=True)
class Spots:
    """Spots of a body's skin.

    Attributes:
        of_facet: (F,) spot of each facet.
        facet: (S,) the facet that speaks for each.
    """

    of_facet: Ints
    facet: Ints


@dataclass(frozen=True)
class Sights:
    """E images from which a body may be seen.

    Attributes:
        pose, side: (E,) pose, and 0 for the speaker, 1 and 2 for the microphones.
        order, sequence, point_m: (E,), (E, N), (E, 3) as in `Images`.
    """

    pose: Ints
    side: Ints
    order: Ints
    sequence: Ints
    point_m: Floats


def spots_of(facets: Facets, spot_m: float) -> Spots:
    """Facets by voxel and direction of their normal; each facet by itself where the voxels are no larger."""
    if spot_m**2 <= float(facets.area_m2.mean()):
        every = np.arange(len(facets))
        return Spots(every, every)
    rows, start = _grouped(facets.middle_m, facets.normal, spot_m)
    spot = np.repeat(np.arange(len(start)), np.diff(np.append(start, len(rows))))
    middle = np.add.reduceat(facets.middle_m[rows], start) / np.diff(np.append(start, len(rows)))[:, None]
    miss = np.linalg.norm(facets.middle_m[rows] - middle[spot], axis=1)
    first = np.lexsort((miss, spot))
    of_facet = np.empty(len(facets), dtype=np.int64)
    of_facet[rows] = spot
    return Spots(of_facet, rows[first[start]])


def _grouped(point_m: Floats, normal: Floats, voxel_m: float) -> tuple[Ints, Ints]:
    """(F,) rows by voxel and direction of the normal, and (S,) where each group begins among them."""
    voxel = np.floor(point_m / voxel_m).astype(np.int64)
    direction = np.rint(NORMAL_STEPS * normal).astype(np.int64)
    _, which, count = np.unique(np.column_stack([voxel, direction]), axis=0, return_inverse=True, return_counts=True)
    return np.argsort(which.ravel(), kind="stable"), np.cumsum(count) - count


def lit_spots(tracing: Tracing, facets: Facets, spots: Spots, sights: Sights, light: Light) -> Flags:
    """(E, S) spots that each image sees: facing it, and nothing between on any leg."""
    asked, side = sights.pose, sights.side
    transducers = np.concatenate([tracing.source_m[:, None], tracing.mics_m], axis=1)
    if light.held > 0.0:
        asked, side = _held_poses(tracing, facets, transducers.mean(axis=1), light.held)[sights.pose], 0 * side
        transducers = np.repeat(transducers.mean(axis=1, keepdims=True), 3, axis=1)
    key = np.column_stack([asked, side, sights.sequence])
    _, rows, which = np.unique(key, axis=0, return_index=True, return_inverse=True)
    start = transducers[asked[rows], side[rows]]
    point = into_rest(sights.point_m[rows], tracing.placed[sights.pose[rows], facets.obstacle])
    facing = _facing(facets, spots.facet, point)
    images = Images(asked[rows], sights.order[rows], sights.sequence[rows], sights.point_m[rows])

    sample = facing & (np.arange(len(spots.facet)) % SAMPLE == 0)
    lit = _reached_among(tracing, facets, spots, start, images, sample)
    seen = np.asarray(lit.any(axis=1))[:, None]  # most images of second order see nothing of the body
    return (lit | _reached_among(tracing, facets, spots, start, images, facing & ~sample & seen))[which.ravel()]


def _reached_among(
    tracing: Tracing, facets: Facets, spots: Spots, start: Floats, images: Images, wanted: Flags
) -> Flags:
    """(I, S) which of the wanted spots sound from each image's origin comes to."""
    lit = np.zeros_like(wanted)
    image, spot = np.nonzero(wanted)
    for first in range(0, len(image), AT_ONCE):
        some = image[first : first + AT_ONCE], spot[first : first + AT_ONCE]
        lit[some] = _reached(tracing, facets, start[some[0]], images[some[0]], spots.facet[some[1]])
    return lit


def _held_poses(tracing: Tracing, facets: Facets, phone_m: Floats, held: float) -> Ints:
    """(N,) the pose whose light each takes: the middle one of a run in which nothing moves far relative to the body."""
    frame = tracing.placed[:, facets.obstacle]
    seen_from = into_rest(phone_m, frame)
    others = into_rest(tracing.placed[:, :, :3], frame[:, None])
    distance = np.linalg.norm(seen_from - facets.center_m, axis=1)
    first = np.zeros(len(phone_m), dtype=np.int64)
    for n in range(1, len(phone_m)):
        k = first[n - 1]
        moved = np.linalg.norm(seen_from[n] - seen_from[k]) + np.linalg.norm(others[n] - others[k], axis=1).max()
        first[n] = k if moved <= held * distance[n] else n
    run = np.searchsorted(np.unique(first), first)
    last = np.append(np.unique(first)[1:], len(first))[run] - 1
    return (first + last) // 2


def _facing(facets: Facets, facet: Ints, point_m: Floats) -> Flags:
    """(I, S) which of some facets have their outside towards points of the rest frame; all of an open surface's."""
    if not facets.closed:
        return np.ones((len(point_m), len(facet)), dtype=bool)
    normal = facets.normal[facet]
    return point_m @ normal.T > np.sum(facets.middle_m[facet] * normal, axis=1)


def _reached(tracing: Tracing, facets: Facets, start: Floats, images: Images, facet: Ints) -> Flags:
    """(R,) whether sound from each image's origin comes to each facet through its mirrors, with every leg free."""
    world, frame = tracing.world, tracing.placed[images.pose, facets.obstacle]
    target = out_of_rest(facets.middle_m[facet], frame)
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
