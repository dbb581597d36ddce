"""Planar specular reflection: image sources over merged patches, in float64 throughout.

A path is a sequence of patches. The source is mirrored in each in turn; the path runs from the receiver back to
the last image, and every crossing must lie inside its patch and come from its front. A crossing on the border of
a patch counts as inside: the twin it creates on the adjoining patch is removed later, by its image.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from simulator.pruning import aside, dot, far_or_aside, grown
from simulator.reflectors import PlanarPatches

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BORDER_M = 1e-9  # crossings this close to a border are on it: rounding of coordinates up to some 100 m
REACHED, BEHIND, OUTSIDE = 0, 1, 2


def facing(patches: PlanarPatches, moves: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(P, P) whether patch j may follow patch i: each has some corner in front of the other.

    Args:
        moves: (O,) which obstacles move relative to the others; their patches may face any of another obstacle.
    """
    count = len(patches)
    if count == 0:
        return np.zeros((0, 0), dtype=bool)
    corners = patches.edge_m[:, 0]
    height = corners @ patches.normal.T - patches.offset_m
    span = patches.edge_start[:-1]
    highest = np.maximum.reduceat(height, span, axis=0).T
    lowest = np.minimum.reduceat(height, span, axis=0).T
    ahead = np.where(patches.one_sided[:, None], highest > BORDER_M, (highest > BORDER_M) | (lowest < -BORDER_M))
    free = moves[patches.obstacle][:, None] | moves[patches.obstacle][None, :]
    other = patches.obstacle[:, None] != patches.obstacle[None, :]
    return (ahead & ahead.T) | (free & other)


def arrays(patches: PlanarPatches) -> tuple:
    """The patches as plain arrays, in the order the kernels take them."""
    return (
        patches.normal, patches.offset_m, patches.one_sided, patches.obstacle,
        patches.center_m, patches.radius_m, patches.edge_m, patches.edge_start,
    )  # fmt: skip


@numba.njit(cache=True)
def _placed(normal, offset, center, obstacle, frame, world_normal, world_offset, world_center):
    """Planes and centres of all patches where their obstacles stand: frame rows are x, y, z, yaw."""
    for p in range(len(offset)):
        x, y, z, yaw = frame[obstacle[p]]
        c, s = np.cos(yaw), np.sin(yaw)
        for vector, out in ((normal[p], world_normal[p]), (center[p], world_center[p])):
            out[0], out[1], out[2] = c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2]
        world_offset[p] = offset[p] + world_normal[p, 0] * x + world_normal[p, 1] * y + world_normal[p, 2] * z
        world_center[p, 0] += x
        world_center[p, 1] += y
        world_center[p, 2] += z


@numba.njit(cache=True)
def _inside(point, frame, normal, edges):
    """Even-odd test of a world point on the plane of a patch, in the patch's rest frame; the border is inside."""
    c, s = np.cos(frame[3]), np.sin(frame[3])
    dx, dy = point[0] - frame[0], point[1] - frame[1]
    local = (c * dx + s * dy, -s * dx + c * dy, point[2] - frame[2])
    drop = 0
    for k in range(1, 3):
        if abs(normal[k]) > abs(normal[drop]):
            drop = k
    i, j = (drop + 1) % 3, (drop + 2) % 3
    u, v = local[i], local[j]
    odd = False
    for e in range(len(edges)):
        ui, vi, uj, vj = edges[e, 0, i], edges[e, 0, j], edges[e, 1, i], edges[e, 1, j]
        du, dv = uj - ui, vj - vi
        length2 = du * du + dv * dv
        t = 0.0 if length2 == 0.0 else min(1.0, max(0.0, ((u - ui) * du + (v - vi) * dv) / length2))
        if (u - ui - t * du) ** 2 + (v - vi - t * dv) ** 2 <= BORDER_M**2:
            return True
        if (vi > v) != (vj > v) and u < ui + (v - vi) / dv * du:
            odd = not odd
    return odd


@numba.njit(cache=True)
def _backtrack(
    images, sequence, depth, target, normal, offset, one_sided, obstacle, rest_normal, edges, start, frame, hits
):
    """Reflection points of a sequence from its receiver back to its source; REACHED, BEHIND or OUTSIDE."""
    end = target.copy()
    for k in range(depth - 1, -1, -1):
        p = sequence[k]
        here, there = dot(end, normal[p]) - offset[p], dot(images[k], normal[p]) - offset[p]
        if there > 0.0:
            here, there = -here, -there
            if one_sided[p]:
                return BEHIND
        if there == 0.0 or here < -BORDER_M:
            return BEHIND
        here = max(here, 0.0)  # in a corner the next crossing lies on this plane, on either side by rounding
        for x in range(3):
            hits[k, x] = end[x] + (images[k, x] - end[x]) * (here / (here - there))
        if not _inside(hits[k], frame[obstacle[p]], rest_normal[p], edges[start[p] : start[p + 1]]):
            return OUTSIDE
        end[:] = hits[k]
    return REACHED


@numba.njit(cache=True)
def planar_paths(
    source,
    receivers,
    frames,
    normal,
    offset,
    one_sided,
    obstacle,
    center,
    radius,
    edges,
    start,
    follows,
    max_order,
    limit,
    keep_missed,
):
    """Every sequence of up to `max_order` patches that carries sound from a source to a receiver, walls transparent.

    Args:
        source: (N, 3); receivers: (N, M, 3); frames: (N, O, 4) where obstacles stand (x, y, z, yaw) at each pose.
        normal ... start: the patches; follows: (P, P) from `facing`.
        limit: longest path, m.
        keep_missed: return sequences that miss their patches as well; their hits mean nothing.

    Returns:
        where: (R, 4) pose, receiver, order, code; sequence: (R, max_order), -1 padded; hits: (R, max_order, 3);
        counts: (3,) sequences REACHED, BEHIND and OUTSIDE.
    """
    patches, width = len(offset), max(max_order, 1)
    where, sequences = np.empty((256, 4), np.int64), np.empty((256, width), np.int64)
    points = np.empty((256, width, 3))
    found, counts = 0, np.zeros(3, np.int64)
    world_normal, world_offset, world_center = np.empty((patches, 3)), np.empty(patches), np.empty((patches, 3))
    images, hits = np.empty((width, 3)), np.zeros((width, 3))
    sequence = np.full(width, -1)
    for n in range(len(source)):
        _placed(normal, offset, center, obstacle, frames[n], world_normal, world_offset, world_center)
        goal = receivers[n, 0]
        goal_radius = 0.0
        for m in range(receivers.shape[1]):
            goal_radius = max(goal_radius, np.sqrt(np.sum((receivers[n, m] - goal) ** 2)))
        depth, sequence[0] = 0, -1
        while depth >= 0 and max_order > 0:
            sequence[depth] += 1
            p = sequence[depth]
            if p == patches:
                sequence[depth] = -1
                depth -= 1
                continue
            before = source[n] if depth == 0 else images[depth - 1]
            if depth > 0:
                last = sequence[depth - 1]
                if not follows[last, p] or far_or_aside(
                    before, world_center[p], radius[p], world_center[last], radius[last], goal, goal_radius, limit
                ):
                    continue
            else:
                if one_sided[p] and dot(before, world_normal[p]) - world_offset[p] <= 0.0:
                    continue
                if far_or_aside(before, world_center[p], radius[p], world_center[p], 0.0, goal, goal_radius, limit):
                    continue
            height = dot(before, world_normal[p]) - world_offset[p]
            for x in range(3):
                images[depth, x] = before[x] - 2.0 * height * world_normal[p, x]
            for m in range(receivers.shape[1]):
                if np.sqrt(np.sum((images[depth] - receivers[n, m]) ** 2)) > limit:
                    continue
                code = _backtrack(
                    images, sequence, depth + 1, receivers[n, m], world_normal, world_offset, one_sided, obstacle,
                    normal, edges, start, frames[n], hits,
                )  # fmt: skip
                counts[code] += 1
                if code != REACHED and not keep_missed:
                    continue
                if found == len(where):
                    where, sequences, points = grown(where), grown(sequences), grown(points)
                where[found, 0], where[found, 1], where[found, 2], where[found, 3] = n, m, depth + 1, code
                sequences[found] = -1
                sequences[found, : depth + 1] = sequence[: depth + 1]
                points[found] = 0.0
                points[found, : depth + 1] = hits[: depth + 1]
                found += 1
            if depth + 1 < max_order:
                depth += 1
                sequence[depth] = -1
    return where[:found], sequences[:found], points[:found], counts


@numba.njit(cache=True)
def images_towards(
    source, frames, normal, offset, one_sided, obstacle, center, radius, edges, start, follows, max_order, limit,
    goal, goal_radius, goal_obstacle,
):  # fmt: skip
    """Images of sources in up to `max_order` patches that can light a sphere (N, 3), radius goal_radius.

    The unmirrored source comes first for every pose. Returns (R,) pose, (R,) order, (R, max_order) sequence,
    (R, 3) image.
    """
    patches, width = len(offset), max(max_order, 1)
    pose, order = np.empty(256, np.int64), np.empty(256, np.int64)
    sequences, image = np.empty((256, width), np.int64), np.empty((256, 3))
    found = 0
    world_normal, world_offset, world_center = np.empty((patches, 3)), np.empty(patches), np.empty((patches, 3))
    images = np.empty((width, 3))
    sequence = np.full(width, -1)
    for n in range(len(source)):
        _placed(normal, offset, center, obstacle, frames[n], world_normal, world_offset, world_center)
        depth = -1
        while True:
            if depth >= 0:
                sequence[depth] += 1
                p = sequence[depth]
                if p == patches:
                    sequence[depth] = -1
                    depth -= 1
                    if depth < 0:
                        break
                    continue
                before = source[n] if depth == 0 else images[depth - 1]
                height = dot(before, world_normal[p]) - world_offset[p]
                if depth == 0 and one_sided[p] and height <= 0.0:
                    continue
                if depth > 0 and not follows[sequence[depth - 1], p]:
                    continue
                if obstacle[p] == goal_obstacle:
                    continue
                rise = dot(goal[n], world_normal[p]) - world_offset[p]
                if one_sided[p] and rise < -goal_radius:
                    continue
                last_center = world_center[p] if depth == 0 else world_center[sequence[depth - 1]]
                last_radius = 0.0 if depth == 0 else radius[sequence[depth - 1]]
                if far_or_aside(
                    before, world_center[p], radius[p], last_center, last_radius, goal[n], goal_radius, limit
                ):
                    continue
                for x in range(3):
                    images[depth, x] = before[x] - 2.0 * height * world_normal[p, x]
                lit = not aside(images[depth], goal[n], goal_radius, world_center[p], radius[p])
                reach = np.sqrt(np.sum((images[depth] - goal[n]) ** 2)) - goal_radius
            else:
                lit, reach = True, np.sqrt(np.sum((source[n] - goal[n]) ** 2)) - goal_radius
            if lit and reach <= limit:
                if found == len(pose):
                    pose, order = grown(pose), grown(order)
                    sequences, image = grown(sequences), grown(image)
                pose[found], order[found] = n, depth + 1
                sequences[found] = -1
                sequences[found, : depth + 1] = sequence[: depth + 1]
                image[found] = source[n] if depth < 0 else images[depth]
                found += 1
            if depth + 1 < max_order:
                depth += 1
                sequence[depth] = -1
            elif depth < 0:
                break
    return pose[:found], order[:found], sequences[:found], image[:found]


@numba.njit(cache=True)
def crossings(
    source, target, frames, pose, order, sequence, normal, offset, one_sided, obstacle, center, radius, edges, start
):
    """Reflection points of given sequences from sources to targets: (R,) code and (R, K, 3) points."""
    rows, width = sequence.shape
    code, points = np.zeros(rows, np.int64), np.zeros((rows, width, 3))
    patches = len(offset)
    world_normal, world_offset, world_center = np.empty((patches, 3)), np.empty(patches), np.empty((patches, 3))
    images = np.empty((max(width, 1), 3))
    placed = -1
    for r in range(rows):
        if pose[r] != placed:
            placed = pose[r]
            _placed(normal, offset, center, obstacle, frames[placed], world_normal, world_offset, world_center)
        before = source[r]
        for k in range(order[r]):
            p = sequence[r, k]
            height = dot(before, world_normal[p]) - world_offset[p]
            for x in range(3):
                images[k, x] = before[x] - 2.0 * height * world_normal[p, x]
            before = images[k]
        code[r] = _backtrack(
            images, sequence[r], order[r], target[r], world_normal, world_offset, one_sided, obstacle, normal,
            edges, start, frames[placed], points[r],
        )  # fmt: skip
    return code, points


@numba.njit(cache=True)
def straight_crossings(
    source, target, frames, pose, order, sequence, normal, offset, one_sided, obstacle, center, radius, edges, start
):
    """Where the straight ways to the last images of given sequences cross the planes, patches or not.

    Returns (R, K, 3) points, NaN where a way runs along a plane, and (R,) distances of the last images.
    """
    rows, width = sequence.shape
    points, length = np.zeros((rows, width, 3)), np.empty(rows)
    patches = len(offset)
    world_normal, world_offset, world_center = np.empty((patches, 3)), np.empty(patches), np.empty((patches, 3))
    images = np.empty((width + 1, 3))
    for r in range(rows):
        _placed(normal, offset, center, obstacle, frames[pose[r]], world_normal, world_offset, world_center)
        images[0] = source[r]
        for k in range(order[r]):
            p = sequence[r, k]
            height = dot(images[k], world_normal[p]) - world_offset[p]
            images[k + 1] = images[k] - 2.0 * height * world_normal[p]
        length[r] = np.sqrt(np.sum((images[order[r]] - target[r]) ** 2))
        end = target[r].copy()
        for k in range(order[r] - 1, -1, -1):
            p = sequence[r, k]
            here = dot(end, world_normal[p]) - world_offset[p]
            there = dot(images[k + 1], world_normal[p]) - world_offset[p]
            share = here / (here - there) if here != there else np.nan
            end = end + share * (images[k + 1] - end)
            points[r, k] = end
    return points, length


def mirrored(point_m: Floats, normal: Floats, offset_m: Floats) -> Floats:
    """(R, 3) images of points in planes, one plane a row."""
    return point_m - 2.0 * (np.sum(point_m * normal, axis=-1) - offset_m)[..., None] * normal
