"""Which planar patches of an obstacle lie in one plane, in which of these planes its sharp edges end, and which planes
are the two faces of a thin plate."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.repeated import repeated
from simulator.meshes.pieces import components
from simulator.surfaces.reflectors import PlanarPatches
from simulator.surfaces.wedges import Wedges
from simulator.world.mirrors import FLUSH_M

AT_ONCE = 2**22  # heights of points over planes
BACK_TO_BACK = 1.0 - 1e-6  # cosine


def planes_of(patches: PlanarPatches) -> Ints:
    """(P,) number of the plane of each patch: the same for those of one obstacle that lie in one."""
    owner, corners = np.repeat(patches.obstacle, 4), patches.corner_m.reshape(-1, 3)
    corner, patch = _on_planes(patches, np.arange(len(patches)), corners, owner)
    pair, count = np.unique(np.column_stack([corner // 4, patch]), axis=0, return_counts=True)
    one, other = pair[count == 4].T
    return components(np.column_stack([one, other]), len(patches))


def planes_at_ends(wedges: Wedges, patches: PlanarPatches, planes: Ints) -> Ints:
    """(W, 2, M) planes of its obstacle in which the start and the end of each edge lie, -1 padded."""
    number, first = np.unique(planes, return_index=True)
    ends = np.stack([wedges.start_m, wedges.end_m], axis=1).reshape(-1, 3)
    end, which = _on_planes(patches, first, ends, np.repeat(wedges.obstacle, 2))
    count = np.bincount(end, minlength=len(ends))
    found = np.full((len(ends), count.max(initial=0)), -1)
    order = np.argsort(end, kind="stable")
    found[end[order], repeated(count)[1]] = number[which[order]]
    return found.reshape(len(wedges), 2, found.shape[1])


def plates_of(wedges: Wedges, patches: PlanarPatches, planes: Ints) -> Ints:
    """(L,) for each of the planes itself, but for the faces of a thin plate the same one of both."""
    plates = np.arange(planes.max(initial=-1) + 1)
    rims = np.flatnonzero(np.isfinite(wedges.sheet_m))
    face, first = np.unique(wedges.patch[rims, 0], return_index=True)
    for patch, sheet_m in zip(face, wedges.sheet_m[rims[first]], strict=True):
        others = face[(patches.obstacle[face] == patches.obstacle[patch]) & (face > patch)]
        behind = patches.normal[others] @ patches.normal[patch] < -BACK_TO_BACK
        apart = patches.offset_m[others] + patches.offset_m[patch]
        plates[planes[others[behind & (np.abs(apart - sheet_m) < FLUSH_M)]]] = plates[planes[patch]]
    return plates


def _on_planes(patches: PlanarPatches, chosen: Ints, point_m: Floats, obstacle: Ints) -> tuple[Ints, Ints]:
    """Pairs of points (R, 3) with planes of chosen patches (C,) of their own obstacles in which they lie."""
    points, planes = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    step = max(AT_ONCE // max(len(point_m), 1), 1)
    for begin in range(0, len(chosen), step):
        some = chosen[begin : begin + step]
        height = np.abs(point_m @ patches.normal[some].T - patches.offset_m[some])
        point, plane = np.nonzero((height < FLUSH_M) & (obstacle[:, None] == patches.obstacle[some]))
        points.append(point)
        planes.append(plane + begin)
    return np.concatenate(points), np.concatenate(planes)
