"""Planar patches as mirrors: where they stand at every pose, and which may follow which."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.surfaces.reflectors import PlanarPatches
from simulator.world.frames import out_of_rest, rotated

ON_BORDER_M = 1e-9  # crossings this close to a border are on it: rounding of coordinates up to some 100 m
FLUSH_M = 1e-5  # what rises no higher over a plane lies in it: files of float32 round by up to 1e-6 m at 10 m


class Mirrors(NamedTuple):
    """P patches at N poses; compiled functions take it whole.

    Attributes:
        normal, offset_m, center_m: (N, P, 3), (N, P) and (N, P, 3) planes and centres in the world.
        corner_m: (N, P, 4, 3) rectangles round the patches, in the world.
        radius_m, one_sided, obstacle: (P,) as in `PlanarPatches`.
        ahead: (2, P, P) from `those_ahead`.
        frames: (N, O, 4) where the obstacles stand (x, y, z, yaw).
        rest_normal: (P, 3) in the rest frame of the obstacle.
        edge_m, edge_start: outlines in the rest frame, as in `PlanarPatches`.
        endless: (P,) patches that sound is reflected off beside their outlines as well.
    """

    normal: Floats
    offset_m: Floats
    center_m: Floats
    corner_m: Floats
    radius_m: Floats
    one_sided: Flags
    obstacle: Ints
    ahead: Flags
    frames: Floats
    rest_normal: Floats
    edge_m: Floats
    edge_start: Ints
    endless: Flags


def placed_mirrors(patches: PlanarPatches, ahead: Flags, frames: Floats) -> Mirrors:
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
        patches.obstacle, ahead, frames, patches.normal, patches.edge_m, patches.edge_start,
        np.zeros(len(patches), dtype=bool),
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


def those_ahead(patches: PlanarPatches, moves: Flags) -> Flags:
    """(2, P, P) whether patch j has some corner ahead of the front of patch i, and of its back; a body has no back.

    Args:
        moves: (O,) which obstacles move relative to the others; their patches may face any of another obstacle.
    """
    count = len(patches)
    if count == 0:
        return np.zeros((2, 0, 0), dtype=bool)
    height = patches.edge_m.reshape(-1, 3) @ patches.normal.T - patches.offset_m  # segments run either way: both ends
    span = 2 * patches.edge_start[:-1]
    highest = np.maximum.reduceat(height, span, axis=0).T
    lowest = np.minimum.reduceat(height, span, axis=0).T
    ahead = np.stack([highest > FLUSH_M, (lowest < -FLUSH_M) & ~patches.one_sided[:, None]])
    free = moves[patches.obstacle][:, None] | moves[patches.obstacle][None, :]
    other = patches.obstacle[:, None] != patches.obstacle[None, :]
    return ahead | (free & other)


def facing(ahead: Flags) -> Flags:
    """(P, P) whether one patch may follow another on some side: `those_ahead` of either hold the other."""
    either: Flags = np.logical_or.reduce(ahead)
    return either & either.T
