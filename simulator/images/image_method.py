"""The image method: reflection points in planar patches, in float64 throughout.

A path is a sequence of patches. The source is mirrored in each in turn (`image_tree`); the path runs from the receiver
back to the last image, and every crossing must lie inside its patch and come from its front. A crossing on the border
of a patch counts as inside: the twin it creates on the adjoining patch is removed later, by its image. Where two
patches meet, both are met at once; that is a reflection off either only within their corner.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import distance, dot
from simulator.images.given_planes import fill_image
from simulator.images.image_tree import Goal, image_levels, in_turn
from simulator.world.candidates import Candidates, candidates, with_plane_normals
from simulator.world.frames import fill_rest, rotated_back
from simulator.world.mirrors import ON_BORDER_M
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing

JOINT_M = 4.0 * ON_BORDER_M  # crossings of two patches this close to each other lie where these meet
BESIDE_M = 1e-6  # of such a point, where it is asked how a patch goes on
REACHED, BEHIND, OUTSIDE = 0, 1, 2
MISSES = {BEHIND: Reason.BEHIND_PATCH, OUTSIDE: Reason.OUTSIDE_PATCH}


def planar(search: Search) -> tuple[Candidates, Candidates]:
    """Image sources in planar patches, and those beside a blunt one, in whose border they fade (`blunt_mirrors`).

    What falls beside other patches is rejected.
    """
    tracing = search.tracing
    where, sequence, hits, counts = _reached(search)
    code = where[:, 3]
    for miss, reason in MISSES.items():
        rows = np.flatnonzero(code == miss)
        search.reject(reason, counts[miss], partial(_missed, tracing, where[rows], sequence[rows]))
    rows = np.flatnonzero(code == REACHED)
    found = candidates(tracing, where[rows, 0], where[rows, 1], sequence[rows], hits[rows])
    found, beside = with_plane_normals(tracing, found), _beside_blunt(tracing, found)
    return found[~beside], found[beside]


def _beside_blunt(tracing: Tracing, found: Candidates) -> Flags:
    """(C,) whether paths miss a mirror that is blunt."""
    beside, rows = np.zeros(len(found), dtype=bool), np.flatnonzero(tracing.world.is_blunt(found.sequence).any(axis=1))
    some = found[rows]
    ends = some.points_m[:, 0], tracing.mics_m[some.pose, some.mic]
    beside[rows] = crossed(tracing, *ends, some.pose, some.order, some.sequence)[0] != REACHED
    return beside


def _reached(search: Search) -> tuple[Ints, Ints, Floats, Ints]:
    """Every sequence of patches that carries sound from the speaker to a microphone, whatever stands between.

    Blunt patches go on for ever: what falls beside them fades (`blunt_mirrors`).

    Returns:
        where: (R, 4) pose, microphone, order, code; sequence: (R, max_order), -1 padded; hits: (R, max_order, 3);
        counts: (3,) sequences REACHED, BEHIND and OUTSIDE, kept or not.
    """
    tracing, limit_m, max_order = search.tracing, search.limit_m, search.max_order
    mirrors, mics = tracing.mirrors._replace(endless=tracing.world.blunt), np.ascontiguousarray(tracing.mics_m)
    spread = float(np.linalg.norm(mics - mics[:, :1], axis=2).max())
    parts, counts = [], np.zeros(3, dtype=np.int64)
    allowed = np.ones((max_order, len(tracing.world.patches)), dtype=bool)
    allowed[2:] &= search.large_mirrors
    goal = Goal(np.ascontiguousarray(mics[:, 0]), spread, limit_m)
    for level in image_levels(mirrors, allowed, tracing.source_m, goal):
        if level.order == 0:
            continue
        apart = np.linalg.norm(level.images_m[:, level.order, None] - mics[level.pose], axis=2)
        row, mic = np.nonzero(apart <= limit_m)
        pose, sequence, order = level.pose[row], level.sequence[row], np.full(len(row), level.order)
        code, hits = _crossings(mirrors, tracing.source_m[pose], mics[pose, mic], pose, order, sequence)  # type: ignore[call-arg]
        counts += np.bincount(code, minlength=3)
        kept = np.flatnonzero((code == REACHED) | (search.log.listed > 0))
        parts.append((np.column_stack([pose, mic, order, code])[kept], sequence[kept], hits[kept]))
    where, sequence, hits = (np.concatenate(column) for column in zip(*parts, strict=True))
    rows = in_turn(where[:, 0], sequence)
    return where[rows], sequence[rows], hits[rows], counts


def _missed(tracing: Tracing, where: Ints, sequence: Ints) -> Rejected:
    """Sequences that miss a patch; their level is that of the image, as if the patches went on for ever."""
    source, mic = tracing.source_m[where[:, 0]], tracing.mics_m[where[:, 0], where[:, 1]]
    hits, length = straight(tracing, source, mic, where[:, 0], where[:, 2], sequence)

    def chosen(index: Ints) -> Candidates:
        found = candidates(tracing, where[index, 0], where[index, 1], sequence[index], hits[index])
        return with_plane_normals(tracing, found)

    return Rejected(1.0 / length, chosen)


def crossed(
    tracing: Tracing, start_m: Floats, target_m: Floats, pose: Ints, order: Ints, sequence: Ints
) -> tuple[Ints, Floats]:
    """(R,) code and (R, N, 3) reflection points of given sequences from starts to targets."""
    ends = np.ascontiguousarray(start_m), np.ascontiguousarray(target_m)
    return _crossings(tracing.mirrors, *ends, pose, order, sequence)  # type: ignore[call-arg]


def straight(
    tracing: Tracing, start_m: Floats, target_m: Floats, pose: Ints, order: Ints, sequence: Ints
) -> tuple[Floats, Floats]:
    """(R, N, 3) where unfolded paths cross their planes, inside the patches or not, and (R,) their lengths."""
    ends = np.ascontiguousarray(start_m), np.ascontiguousarray(target_m)
    return _straight_crossings(tracing.mirrors, *ends, pose, order, sequence)  # type: ignore[call-arg]


@compiled
def _crossings(mirrors, source, target, pose, order, sequence):
    """Reflection points of given sequences from sources to targets (R, 3): (R,) code and (R, K, 3) points."""
    rows, width = sequence.shape
    code, points = np.zeros(rows, np.int64), np.zeros((rows, width, 3))
    images = np.empty((width + 1, 3))
    for r in range(rows):
        fill_images(mirrors, pose[r], source[r], sequence[r], order[r], images)
        code[r] = backtrack(mirrors, pose[r], images, sequence[r], order[r], target[r], points[r])
        if code[r] == REACHED and _round_a_fold(
            mirrors, pose[r], sequence[r], order[r], source[r], target[r], points[r]
        ):
            code[r] = OUTSIDE
    return code, points


@compiled
def _straight_crossings(mirrors, source, target, pose, order, sequence):
    """Where the straight lines to the last images of given sequences cross the planes, patches or not.

    Returns (R, K, 3) points, NaN where a way runs along a plane, and (R,) distances of the last images.
    """
    rows, width = sequence.shape
    points, length = np.zeros((rows, width, 3)), np.empty(rows)
    images, end = np.empty((width + 1, 3)), np.empty(3)
    for r in range(rows):
        n = pose[r]
        fill_images(mirrors, n, source[r], sequence[r], order[r], images)
        length[r] = distance(images[order[r]], target[r])
        for x in range(3):
            end[x] = target[r, x]
        for k in range(order[r] - 1, -1, -1):
            p = sequence[r, k]
            here = dot(end, mirrors.normal[n, p]) - mirrors.offset_m[n, p]
            there = dot(images[k + 1], mirrors.normal[n, p]) - mirrors.offset_m[n, p]
            share = here / (here - there) if here != there else np.nan
            for x in range(3):
                end[x] += share * (images[k + 1, x] - end[x])
                points[r, k, x] = end[x]
    return points, length


@compiled
def fill_images(mirrors, n, source, sequence, order, images):
    """Fill in (order + 1, 3) the source and its images in a sequence at pose n."""
    for x in range(3):
        images[0, x] = source[x]
    for k in range(order):
        fill_image(images[k], mirrors.normal[n, sequence[k]], mirrors.offset_m[n, sequence[k]], images[k + 1])


@compiled
def backtrack(mirrors, n, images, sequence, depth, target, hits):
    """Reflection points of a sequence at pose n from its receiver back to its source; REACHED, BEHIND or OUTSIDE.

    Args:
        images: (depth + 1, 3) the source, then its images.
        hits: (depth, 3) filled in.
    """
    # numbers, not parts of arrays: to count references to these took five times as long as all else
    x, y, z = target[0], target[1], target[2]
    for k in range(depth - 1, -1, -1):
        p = sequence[k]
        a, b, c = mirrors.normal[n, p, 0], mirrors.normal[n, p, 1], mirrors.normal[n, p, 2]
        u, v, w, offset = images[k + 1, 0], images[k + 1, 1], images[k + 1, 2], mirrors.offset_m[n, p]
        here, there = x * a + y * b + z * c - offset, u * a + v * b + w * c - offset
        if there > 0.0 or (there == 0.0 and here < 0.0):
            here, there = -here, -there
            if mirrors.one_sided[p]:
                return BEHIND
        if here < -ON_BORDER_M or (there == 0.0 and (here == 0.0 or k > 0)):  # a source may lie on its first mirror
            return BEHIND
        here = max(here, 0.0)  # in a corner the next crossing lies on this plane, on either side by rounding
        share = here / (here - there)
        x, y, z = x + (u - x) * share, y + (v - y) * share, z + (w - z) * share
        hits[k, 0], hits[k, 1], hits[k, 2] = x, y, z
        if not (mirrors.endless[p] or inside_patch(mirrors, n, p, x, y, z)):
            return OUTSIDE
    return REACHED


@compiled
def _round_a_fold(mirrors, n, sequence, depth, source, target, hits):
    """Whether a path meets two patches at once from outside, in their common edge: it is not reflected off both."""
    for k in range(depth - 1):
        p, q, x, y, z = sequence[k], sequence[k + 1], hits[k, 0], hits[k, 1], hits[k, 2]
        if abs(x - hits[k + 1, 0]) + abs(y - hits[k + 1, 1]) + abs(z - hits[k + 1, 2]) < JOINT_M:
            before, after = source if k == 0 else hits[k - 1], target if k + 2 == depth else hits[k + 2]
            lit_p, lit_q = _lit_side(mirrors, n, p, before), _lit_side(mirrors, n, q, after)
            if not _in_corner(mirrors, n, p, q, lit_p, lit_q, x, y, z):
                return True
    return False


@inlined
def _lit_side(mirrors, n, p, point):
    """On which side of a patch a point is, 1 or -1; 0 on it, where a third patch is met at once."""
    height = dot(point, mirrors.normal[n, p]) - mirrors.offset_m[n, p]
    return 0.0 if abs(height) < JOINT_M else np.sign(height)


@compiled
def _in_corner(mirrors, n, p, q, lit_p, lit_q, x, y, z):
    """Whether patches that meet at a point make a corner for sound on these sides, -1 to 1: both go on there."""
    a, b, c = mirrors.normal[n, p, 0], mirrors.normal[n, p, 1], mirrors.normal[n, p, 2]
    u, v, w = mirrors.normal[n, q, 0], mirrors.normal[n, q, 1], mirrors.normal[n, q, 2]
    cosine = a * u + b * v + c * w
    step_p, step_q = lit_q * BESIDE_M, lit_p * BESIDE_M
    return inside_patch(
        mirrors, n, p, x + step_p * (u - cosine * a), y + step_p * (v - cosine * b), z + step_p * (w - cosine * c)
    ) and inside_patch(
        mirrors, n, q, x + step_q * (a - cosine * u), y + step_q * (b - cosine * v), z + step_q * (c - cosine * w)
    )


@inlined
def inside_patch(mirrors, n, p, x, y, z):
    """Whether a world point on the plane of patch p at pose n is on it; the border is."""
    return place_on_patch(mirrors, n, p, x, y, z) >= 0


@compiled
def place_on_patch(mirrors, n, p, x, y, z):
    """1 for a world point inside patch p at pose n, in whose plane it is, 0 on its border, -1 beside it.

    An even-odd test in the patch's rest frame.
    """
    frames, o = mirrors.frames, mirrors.obstacle[p]
    x, y, z, yaw = x - frames[n, o, 0], y - frames[n, o, 1], z - frames[n, o, 2], frames[n, o, 3]
    if yaw != 0.0:
        x, y = rotated_back(x, y, np.cos(yaw), np.sin(yaw))
    a, b, c = abs(mirrors.rest.normal[p, 0]), abs(mirrors.rest.normal[p, 1]), abs(mirrors.rest.normal[p, 2])
    i, j, u, v = 1, 2, y, z
    if c > max(a, b):
        i, j, u, v = 0, 1, x, y
    elif b > a:
        i, j, u, v = 2, 0, z, x
    edges, odd = mirrors.rest.edge_m, False
    for e in range(mirrors.rest.edge_start[p], mirrors.rest.edge_start[p + 1]):
        ui, vi, uj, vj = edges[e, 0, i], edges[e, 0, j], edges[e, 1, i], edges[e, 1, j]
        if max(vi, vj) < v - ON_BORDER_M or min(vi, vj) > v + ON_BORDER_M or max(ui, uj) < u - ON_BORDER_M:
            continue  # not on the edge, and the edge not to the right
        du, dv = uj - ui, vj - vi
        if min(ui, uj) <= u + ON_BORDER_M:
            length2 = du * du + dv * dv
            t = 0.0 if length2 == 0.0 else min(1.0, max(0.0, ((u - ui) * du + (v - vi) * dv) / length2))
            if (u - ui - t * du) ** 2 + (v - vi - t * dv) ** 2 <= ON_BORDER_M**2:
                return 0
        if (vi > v) != (vj > v) and u < ui + (v - vi) / dv * du:
            odd = not odd
    return 1 if odd else -1


@compiled
def nearest_border_m(mirrors, point, pose, sequence):
    """(R,) distance of points (N, 3) at poses (R,) from outlines of mirrors (R, K), -1 padded; infinite from none."""
    least, at = np.full(len(pose), np.inf), np.empty(3)
    for r in range(len(pose)):
        for p in sequence[r]:
            if p < 0:
                continue
            frame = mirrors.frames[pose[r], mirrors.obstacle[p]]
            fill_rest(point[pose[r]], frame, at)
            for e in range(mirrors.rest.edge_start[p], mirrors.rest.edge_start[p + 1]):
                least[r] = min(least[r], _from_segment(at, mirrors.rest.edge_m[e]))
    return least


@inlined
def _from_segment(at, edge):
    """Distance of a point from a segment (2, 3)."""
    along = square = miss = 0.0
    for k in range(3):
        step = edge[1, k] - edge[0, k]
        along, square = along + (at[k] - edge[0, k]) * step, square + step * step
    share = min(1.0, max(0.0, along / square)) if square > 0.0 else 0.0
    for k in range(3):
        miss += (at[k] - edge[0, k] - share * (edge[1, k] - edge[0, k])) ** 2
    return np.sqrt(miss)
