"""Planar patches as mirrors: where they stand at every pose, and which may follow which."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import dot
from simulator.surfaces.reflectors import PlanarPatches
from simulator.world.frames import out_of_rest, rotated

ON_BORDER_M = 1e-9  # crossings this close to a border are on it: rounding of coordinates up to some 100 m
FLUSH_M = 1e-5  # what rises no higher over a plane lies in it: files of float32 round by up to 1e-6 m at 10 m


class Planes(NamedTuple):
    """P patches of O obstacles where they stand at time 0: which lies ahead of which is asked pair by pair.

    All pairs of the 10^5 patches of a scan would fill 20 GB.

    Attributes:
        normal, offset_m, one_sided, obstacle, edge_m, edge_start: as in `PlanarPatches`.
        frame: (O,) number of the rest frame of each obstacle; patches in two of them may all face one another.
    """

    normal: Floats
    offset_m: Floats
    one_sided: Flags
    obstacle: Ints
    edge_m: Floats
    edge_start: Ints
    frame: Ints

    @classmethod
    def of(cls, patches: PlanarPatches, frame: Ints) -> Planes:
        """The planes of patches."""
        return cls(
            patches.normal, patches.offset_m, patches.one_sided, patches.obstacle, patches.edge_m, patches.edge_start,
            frame,
        )  # fmt: skip


class Mirrors(NamedTuple):
    """P patches at N poses; compiled functions take it whole.

    Attributes:
        normal, offset_m, center_m: (N, P, 3), (N, P) and (N, P, 3) planes and centres in the world.
        corner_m: (N, P, 4, 3) rectangles round the patches, in the world.
        radius_m, one_sided, obstacle: (P,) as in `PlanarPatches`.
        rest: their planes and outlines in the rest frames of their obstacles, which say what lies ahead of what.
        frames: (N, O, 4) where the obstacles stand (x, y, z, yaw).
        endless: (P,) patches that sound is reflected off beside their outlines as well.
    """

    normal: Floats
    offset_m: Floats
    center_m: Floats
    corner_m: Floats
    radius_m: Floats
    one_sided: Flags
    obstacle: Ints
    rest: Planes
    frames: Floats
    endless: Flags


def placed_mirrors(patches: PlanarPatches, rest: Planes, frames: Floats) -> Mirrors:
    """All patches where their obstacles stand, frames (N, O, 4)."""
    frame = frames[:, patches.obstacle]
    shape = (len(frames), len(patches), 3)
    normal = rotated(np.broadcast_to(patches.normal, shape), frame[..., 3])
    offset = patches.offset_m + normal[..., 0] * frame[..., 0]
    for x in (1, 2):
        offset = offset + normal[..., x] * frame[..., x]
    center = out_of_rest(np.broadcast_to(patches.center_m, shape), frame)
    corner = out_of_rest(np.broadcast_to(patches.corner_m, (*shape[:2], 4, 3)), frame[:, :, None])
    whole = np.ascontiguousarray
    return Mirrors(
        whole(normal), whole(offset), whole(center), whole(corner), patches.radius_m, patches.one_sided,
        patches.obstacle, rest, frames, np.zeros(len(patches), dtype=bool),
    )  # fmt: skip


def gaps_to_others(mirrors: Mirrors, pose: int, obstacle: int, point_m: Floats) -> tuple[Floats, Floats]:
    """Distances (B, M) of points of an obstacle, in its rest frame, from the M mirrors of others at a pose.

    Infinite from mirrors that do not reach there. The second result holds the mirrors' (M, 3) normals.
    """
    others = np.flatnonzero(mirrors.obstacle != obstacle)
    point, normal = out_of_rest(point_m, mirrors.frames[pose, obstacle]), mirrors.normal[pose, others]
    gap = np.abs(point @ normal.T - mirrors.offset_m[pose, others])
    near = np.linalg.norm(point[:, None] - mirrors.center_m[pose, others], axis=2) <= mirrors.radius_m[others]
    return np.where(near, gap, np.inf), normal


@compiled
def lies_ahead(planes, side, one, other):
    """Whether a patch has some corner ahead of the front (0) of another one, or of its back (1); a body has no back."""
    if planes.frame[planes.obstacle[one]] != planes.frame[planes.obstacle[other]]:
        return True
    if side == 1 and planes.one_sided[one]:
        return False
    up = 1.0 - 2.0 * side
    for e in range(planes.edge_start[other], planes.edge_start[other + 1]):  # segments run either way: both ends
        for end in range(2):
            if up * (dot(planes.edge_m[e, end], planes.normal[one]) - planes.offset_m[one]) > FLUSH_M:
                return True
    return False


@inlined
def _face(planes, i, j):
    """Whether two patches may follow one another: either lies ahead of a side of the other."""
    there = lies_ahead(planes, 0, i, j) or lies_ahead(planes, 1, i, j)
    return there and (lies_ahead(planes, 0, j, i) or lies_ahead(planes, 1, j, i))


@compiled
def facing(planes, one, other):
    """(R,) whether patches (R,) and (R,) may follow one another."""
    found = np.empty(len(one), np.bool_)
    for r in range(len(one)):
        found[r] = _face(planes, one[r], other[r])
    return found


@compiled
def any_facing(planes):
    """Whether any two patches may follow one another."""
    for i in range(len(planes.offset_m)):
        for j in range(i + 1):
            if _face(planes, i, j):
                return True
    return False


@compiled
def any_ahead(planes):
    """(P,) whether any patch lies ahead of some side of each."""
    count = len(planes.offset_m)
    found = np.zeros(count, np.bool_)
    for i in range(count):
        for j in range(count):
            if lies_ahead(planes, 0, i, j) or lies_ahead(planes, 1, i, j):
                found[i] = True
                break
    return found
