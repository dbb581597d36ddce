"""Sheets that lie on one another count once: the front one, as seen from where the sound comes from or goes to.

Embree tells what hides what to within its float32, so it lets the last micrometres before a surface pass: two sheets
closer than that would both echo. Here the gap is resolved in float64. Of sheets closer than `RESOLVED_M`, which no
coordinate tells apart, one that shows on both sides lies upon the face of a body, as a mat lies on the ground; of two
alike the first listed is in front.

The mesh of a smooth surface stands off it, so that what lies closer than that over it hides nothing there either. Of
two such surfaces each has a path of its own, and the shorter one is over that in front.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import distance, dot
from obstaclewatch.support.distinct_rows import distinct
from obstaclewatch.support.vectors import dot as dot_rows
from obstaclewatch.support.vectors import norm
from simulator.diffraction.edge_view import at_poses
from simulator.images.image_method import inside_patch, place_on_patch
from simulator.world.candidates import Candidates
from simulator.world.interactions import Interaction
from simulator.world.visibility import OFFSET
from simulator.world.world import Tracing

RESOLVED_M = 1e-12  # rounding of coordinates up to some 1000 m
PARALLEL_COS = np.cos(np.deg2rad(1.0))
WITHIN_M = 1e-3  # of the ends of an edge: corners are moved by up to 0.1 mm onto planes that are not quite level
INWARDS = 0.03  # of that, off the edge: a corner of 2 degrees has it inside, as the half of a face that is no plane
BLIND = 4.0  # times `OFFSET` of the largest coordinate: what Embree may let pass, along and across


def covered(tracing: Tracing, found: Candidates) -> Flags:
    """(C,) whether a sheet lies on a reflecting surface or sharp edge of a path, on the side of the path."""
    blind_m = BLIND * max(tracing.world.clear_m, OFFSET * float(np.abs(found.points_m).max(initial=0.0)))
    own, within = _own_patches(tracing, found)
    under_sheets: Flags = _covered(tracing.mirrors, own, within, found.pose, found.points_m, blind_m)  # type: ignore[call-arg]
    return under_sheets | _under_skins(tracing, found)


def _under_skins(tracing: Tracing, found: Candidates) -> Flags:
    """(C,) whether a smooth surface lies over one that a path meets, by no more than their meshes stand off both."""
    rows = np.flatnonzero((found.interaction == Interaction.CURVED).any(axis=1))
    some, under = found[rows], np.zeros(len(found), dtype=bool)
    met = some.interaction == Interaction.CURVED
    else_met = np.where(met, -2, some.sequence)
    alike = distinct(np.column_stack([some.pose, some.mic, some.edge, some.part, else_met]))[1]
    length = some.length_m
    order = np.lexsort((length, alike))
    for step in range(1, np.bincount(alike).max(initial=0)):
        front, back = order[:-step], order[step:]
        near = norm(some.points_m[front, 1:-1] - some.points_m[back, 1:-1]) <= (
            some.standoff_m[front] + some.standoff_m[back] + tracing.world.clear_m
        )
        near &= dot_rows(some.normal[front], some.normal[back]) > PARALLEL_COS
        two = (some.sequence[front] != some.sequence[back]).any(axis=1) & (alike[front] == alike[back])
        stacked = np.flatnonzero(two & (near | ~met[front]).all(axis=1))
        front, back = front[stacked], back[stacked]
        first = (length[back] - length[front] > RESOLVED_M) | (some.sequence[front] < some.sequence[back]).any(axis=1)
        under[rows[np.where(first, back, front)]] = True
    return under


def _own_patches(tracing: Tracing, found: Candidates) -> tuple[Ints, Floats]:
    """(C, N, 2) planar patches at each point of a path, and (C, N, 2, 3) points on them: a mirror, or both faces of a
    sharp edge; -1 without.

    Beside an edge, and within its ends, they are a touch inside: a plane that goes on where the face ends covers
    nothing of it. A mirror that is met on its border or beside it, where its shadow arrives, is left out: of the top of
    a box, on half of which another stands, the free half is not under the other one.
    """
    own = np.full((*found.sequence.shape, 2), -1)
    mirror = np.where(found.interaction == Interaction.SPECULAR, found.sequence, -1)
    own[..., 0] = _met_inside(tracing.mirrors, mirror, found.pose, found.points_m)  # type: ignore[call-arg]
    within = np.repeat(found.points_m[:, 1:-1, None], 2, axis=2)
    row, place = np.nonzero(found.interaction == Interaction.EDGE)
    number = found.sequence[row, place] - tracing.world.numbering.first[Interaction.EDGE]
    wedges = at_poses(tracing, number, found.pose[row])
    own[row, place] = wedges.patch
    own[row, place, 1] = np.where(wedges.patch[:, 0] == wedges.patch[:, 1], -1, wedges.patch[:, 1])
    to_middle = 0.5 * (wedges.start_m + wedges.end_m) - within[row, place, 0]
    along = np.sign(dot_rows(to_middle, wedges.along))[:, None] * wedges.along
    step_m = np.minimum(WITHIN_M, 0.25 * wedges.length_m)
    for face, inwards in enumerate((wedges.inwards, wedges.direction_at(wedges.open_angle_rad))):
        within[row, place, face] += step_m[:, None] * (along + INWARDS * inwards)
    return own, within


@compiled
def _met_inside(mirrors, mirror, pose, points):
    """(C, N) the mirrors that paths meet within their border, -1 for others."""
    found = np.full(mirror.shape, -1)
    for r in range(len(mirror)):
        for k in range(mirror.shape[1]):
            x, y, z = points[r, k + 1]
            if mirror[r, k] >= 0 and place_on_patch(mirrors, pose[r], mirror[r, k], x, y, z) > 0:
                found[r, k] = mirror[r, k]
    return found


@compiled
def _covered(mirrors, own, within, pose, points, blind):
    out = np.zeros(len(pose), np.bool_)
    for r in range(len(pose)):
        n = pose[r]
        for k in range(own.shape[1]):
            if max(own[r, k, 0], own[r, k, 1]) < 0:
                continue
            for p in range(len(mirrors.radius_m)):
                height = dot(points[r, k + 1], mirrors.normal[n, p]) - mirrors.offset_m[n, p]
                if abs(height) > blind or p == own[r, k, 0] or p == own[r, k, 1]:
                    continue
                for face in range(2):
                    patch = own[r, k, face]
                    if patch < 0 or abs(dot(mirrors.normal[n, p], mirrors.normal[n, patch])) <= PARALLEL_COS:
                        continue
                    for end in (points[r, k], points[r, k + 2]):
                        if _hides(mirrors, n, p, patch, within[r, k, face], end, height):
                            out[r] = True
    return out


@inlined
def _hides(mirrors, n, p, own, point, end, height):
    """Whether a patch at a small height under a point hides it from an end."""
    there = dot(end, mirrors.normal[n, p]) - mirrors.offset_m[n, p]
    if abs(there) <= RESOLVED_M:  # in the sheet's own plane, as the next reflection in a corner: it hides nothing there
        return False
    if there < 0.0 and mirrors.one_sided[p]:  # nor does its back, which is inside a body, in a corner at its border
        return False
    if distance(point, mirrors.center_m[n, p]) > 1.01 * mirrors.radius_m[p]:
        return False
    if abs(height) <= RESOLVED_M:
        upon = (mirrors.one_sided[p], p) < (mirrors.one_sided[own], own)
        return upon and inside_patch(mirrors, n, p, point[0], point[1], point[2])
    if height * there >= 0.0:
        return False
    crossing, share = np.empty(3), height / (height - there)
    for x in range(3):
        crossing[x] = point[x] + share * (end[x] - point[x])
    return inside_patch(mirrors, n, p, crossing[0], crossing[1], crossing[2])
