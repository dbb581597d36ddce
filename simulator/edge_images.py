"""Images of speaker and microphones in sequences of mirrors that can light sharp edges."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from simulator.frames import out_of_rest, turned
from simulator.pruning import aside, dot, far_or_aside, grown
from simulator.reflectors import PlanarPatches
from simulator.specular import BORDER_M
from simulator.world import Tracing

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class EdgeImages:
    """Images of one point per pose, one row for each edge that an image can light.

    Attributes:
        pose, wedge: (I,) sorted by pose, then wedge.
        order: (I,) number of mirrors.
        sequence: (I, N) patches from the point on, -1 padded.
        point_m: (I, 3) the image.
    """

    pose: Ints
    wedge: Ints
    order: Ints
    sequence: Ints
    point_m: Floats

    def __getitem__(self, index: NDArray) -> EdgeImages:
        return EdgeImages(*(getattr(self, name)[index] for name in self.__dataclass_fields__))


def images_of(tracing: Tracing, point_m: Floats, max_order: int, limit_m: float) -> EdgeImages:
    """Images of (N, 3) points, one a pose, with up to `max_order` mirrors; the point itself has none."""
    world = tracing.world
    start, end = placed_edges(tracing)
    found = _search(
        np.ascontiguousarray(point_m), *_placed_patches(world.patches, tracing.placed), world.follows,
        start, end, world.wedges.patch, max_order, limit_m,
    )  # type: ignore[call-arg]  # fmt: skip
    order = np.lexsort((found[1], found[0]))
    return EdgeImages(*(column[order] for column in found))


def placed_edges(tracing: Tracing) -> tuple[Floats, Floats]:
    """(N, W, 3) starts and ends of all edges at all poses."""
    wedges, poses = tracing.world.wedges, len(tracing.pose)
    frame = tracing.placed[:, wedges.obstacle]
    shape = (poses, len(wedges), 3)
    return (
        np.ascontiguousarray(out_of_rest(np.broadcast_to(wedges.start_m, shape), frame)),
        np.ascontiguousarray(out_of_rest(np.broadcast_to(wedges.end_m, shape), frame)),
    )


def _placed_patches(patches: PlanarPatches, placed: Floats) -> tuple:
    """World normals (N, P, 3), offsets (N, P), centres (N, P, 3), radii (P,) and sidedness (P,)."""
    frame = placed[:, patches.obstacle]
    shape = (len(placed), len(patches), 3)
    normal = turned(np.broadcast_to(patches.normal, shape), frame[..., 3])
    offset = patches.offset_m + np.sum(normal * frame[..., :3], axis=2)
    center = out_of_rest(np.broadcast_to(patches.center_m, shape), frame)
    return tuple(np.ascontiguousarray(a) for a in (normal, offset, center)) + (patches.radius_m, patches.one_sided)


@numba.njit(cache=True)
def _lit_edge(image, mirror, height, p, normal, offset, center, radius, start, end, patch, limit):
    """Whether an image, made by a mirror from a point `height` above it, can light an edge through the mirror."""
    middle, half = 0.5 * (start + end), 0.5 * np.sqrt(np.sum((end - start) ** 2))
    if np.sqrt(np.sum((image - middle) ** 2)) - half > limit:
        return False
    if not mirror:
        return True
    if p == patch[0] or p == patch[1]:
        return False
    side = 1.0 if height > 0.0 else -1.0
    rise = max(side * (dot(start, normal[p]) - offset[p]), side * (dot(end, normal[p]) - offset[p]))
    return rise > BORDER_M and not aside(image, middle, half, center[p], radius[p])


@numba.njit(cache=True)
def _search(point, normal, offset, center, radius, one_sided, follows, start, end, patch, max_order, limit):
    """(R,) pose, (R,) wedge, (R,) order, (R, max_order) sequence and (R, 3) image of all that can light an edge."""
    patches, width = normal.shape[1], max(max_order, 1)
    pose, wedge, order = np.empty(256, np.int64), np.empty(256, np.int64), np.empty(256, np.int64)
    sequences, points = np.empty((256, width), np.int64), np.empty((256, 3))
    found = 0
    images, sequence = np.empty((width, 3)), np.full(width, -1)
    for n in range(len(point)):
        depth = -1
        while True:
            height, p = 0.0, -1
            image = point[n]
            if depth >= 0:
                sequence[depth] += 1
                p = sequence[depth]
                if p == patches:
                    sequence[depth] = -1
                    depth -= 1
                    if depth < 0:
                        break
                    continue
                before = point[n] if depth == 0 else images[depth - 1]
                height = dot(before, normal[n, p]) - offset[n, p]
                if height == 0.0 or (depth == 0 and one_sided[p] and height < 0.0):
                    continue
                if depth > 0:
                    last = sequence[depth - 1]
                    if not follows[last, p] or far_or_aside(
                        before, center[n, p], radius[p], center[n, last], radius[last], point[n], limit, limit
                    ):
                        continue
                elif np.sqrt(np.sum((before - center[n, p]) ** 2)) - radius[p] > limit:
                    continue
                for x in range(3):
                    images[depth, x] = before[x] - 2.0 * height * normal[n, p, x]
                image = images[depth]
            for w in range(start.shape[1]):
                if not _lit_edge(
                    image, depth >= 0, height, p, normal[n], offset[n], center[n], radius, start[n, w], end[n, w],
                    patch[w], limit,
                ):  # fmt: skip
                    continue
                if found == len(pose):
                    pose, wedge, order = grown(pose), grown(wedge), grown(order)
                    sequences, points = grown(sequences), grown(points)
                pose[found], wedge[found], order[found] = n, w, depth + 1
                sequences[found] = -1
                sequences[found, : depth + 1] = sequence[: depth + 1]
                points[found] = image
                found += 1
            if depth + 1 < max_order:
                depth += 1
                sequence[depth] = -1
            elif depth < 0:
                break
    return pose[:found], wedge[:found], order[:found], sequences[:found], points[:found]
