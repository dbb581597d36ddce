"""What sharp edges in the way leave of the sound that another edge has diffracted: Fresnel's integral at their shadow.

A mirror path that a sharp edge hides is made up for by what that edge diffracts. What one edge diffracts and a second
one hides would need waves diffracted twice. As at the borders of mirrors (`diffraction.patch_borders`) the shadow of
the second edge by Kirchhoff's approximation stands in their place: with the detour d over it, beyond the straight way
from the first edge to a transducer, so much of the wave

    w erfc(sqrt(jkd)) / 2

arrives in the shadow, and is taken off beside it. Between mirrors the way is straight in their images. Of all edges
near the way on one side of the first edge that with the least detour counts. What hides the way must be one segment's
edge alone: the way over it is asked for, and must be free.

Two edges of one face, or an edge and its image in a mirror on which the face stands (`diffraction.faces_in_mirrors`),
are passed along the face. On it direct wave and reflection are one, and each of them is cut off by both edges as in the
open: a slab is two screens for the source and two for its image. Thin plates are left to `diffraction.panel_chains`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import distance
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import dot, norm
from simulator.diffraction.edge_view import at_poses
from simulator.diffraction.faces_in_mirrors import SQUARE_COSINE
from simulator.diffraction.patch_borders import BORDER_REACH_RAD, over_edge, own_detours_m, shadow_share
from simulator.diffraction.single import clear_of_faces, point_slot, views_of, within
from simulator.field.free_segments import displaced_segments, free_segments
from simulator.surfaces.near_balls import Groups
from simulator.world.candidates import Candidates
from simulator.world.frames import fill_rest
from simulator.world.interactions import Interaction
from simulator.world.line_of_sight import free_between
from simulator.world.mirrors import FLUSH_M
from simulator.world.search_context import Search
from simulator.world.visibility import COINCIDENT_M, OFFSET
from simulator.world.world import Tracing

CLOSE_M = 0.01  # an edge so close to where a way begins or ends is part of what is there: the rim of a plate has two


@dataclass(frozen=True)
class Passage:
    """What second edges do to R paths over one edge, on the way to it (0) and from it (1).

    Attributes:
        detour_m: (R, 2) least detour over a second edge beyond the straight way; infinite without one.
        hidden: (R, 2) whether something hides the straight way.
        passes: (R,) whether what hides a way is the second edge alone, and the way over that is free.
        own_m: (R, 3) detours over the first edge beyond the paths that end at it (`own_detours_m`).
        inside: (R,) whether a transducer lies inside the first edge, so that a face of that is in the way.
    """

    detour_m: Floats
    hidden: Flags
    passes: Flags
    own_m: Floats
    inside: Flags

    def share(self, wavenumber: Floats) -> Complexes:
        """(R, 3, K) what is left of the waves of each path that passes.

        Where a way to what lies inside the edge is free it goes by beside the end of the face, and nothing runs along.
        """
        left = np.ones((*self.own_m.shape, len(wavenumber)), dtype=np.complex128)
        for side in range(2):
            rows = np.flatnonzero(np.isfinite(self.detour_m[:, side]))
            shadow = shadow_share(self.detour_m[rows, side], self.own_m[rows], wavenumber)
            left[rows] *= np.where(self.hidden[rows, side, None, None], shadow, 1.0 - shadow)
        left[self.inside & ~self.hidden.any(axis=1)] = 0.0
        return left


def passes_over_edges(search: Search, found: Candidates) -> Flags:
    """(C,) whether what hides a path over an edge is a second edge on either side, the way over which is free."""
    passes = np.zeros(len(found), dtype=bool)
    if len(found) and _has_planes(search):
        rows, passage = _passages(search, found)
        passes[rows] = passage.passes
    return passes


def beside_edges(search: Search, found: Candidates, wavenumber: Floats) -> Complexes:
    """(C, 3, K) what second edges near the way of each path over an edge leave of its waves (`edge_terms`)."""
    left = np.ones((len(found), 3, len(wavenumber)), dtype=np.complex128)
    if len(found) and _has_planes(search):
        rows, passage = _passages(search, found)
        left[rows] = passage.share(wavenumber)
    return left


def _has_planes(search: Search) -> bool:
    """Whether mirrors are among the mechanisms: edges alone have no faces that tell second ones from them."""
    return len(search.tracing.world.patches) > 0


def _passages(search: Search, found: Candidates) -> tuple[Ints, Passage]:
    """Which of the paths (C,), all over one edge, come near a second one, and how they pass it."""
    near = _near_segments(search, found)
    rows = np.flatnonzero(np.isfinite(near.detour_m).any(axis=1))
    some, near = found[rows], near[rows]
    free = free_segments(search.tracing, some, search.tracing.world.sharp)
    after = np.arange(free.shape[1]) > point_slot(some)[:, None]
    sides = [_past_side(search.tracing, some, near, free, here) for here in (~after, after)]
    least, hidden, passes = (np.stack(column, axis=1) for column in zip(*sides, strict=True))
    view = views_of(search.tracing, some)[1]
    inside = ~np.logical_and(*within(view))
    return rows, Passage(least, hidden, np.logical_and.reduce(passes, axis=1), own_detours_m(view, some.part), inside)


def _past_side(
    tracing: Tracing, found: Candidates, near: _Near, free: Flags, here: Flags
) -> tuple[Floats, Flags, Flags]:
    """Least detour (R,), whether the way is hidden, and whether it passes, on the side of some segments (R, N + 1).

    A way that drops behind a face of the edge itself is hidden from there on; it passes along the face, in however many
    segments.
    """
    dark, every = here & ~free, np.arange(len(found))
    hidden: Flags = np.asarray(dark.any(axis=1))
    detour = np.where(np.where(hidden[:, None], dark, here), near.detour_m, np.inf)
    least, segment = detour.min(axis=1), detour.argmin(axis=1)
    slot, at = np.arange(dark.shape[1]), point_slot(found)[:, None]
    along = (~dark | (near.face >= 0)).all(axis=1)
    segment = np.where(hidden & along, (dark * np.abs(slot - at - 0.5)).argmax(axis=1), segment)
    face = near.face[every, segment]
    before = np.where(slot > at, slot < segment[:, None], slot > segment[:, None])
    other = dark & (slot != segment[:, None]) & ~(before & (face >= 0)[:, None])
    passes = ~hidden | (~other.any(axis=1) & np.isfinite(least))
    asked = np.flatnonzero(hidden & passes)
    passes[asked] = _free_over(tracing, found[asked], segment[asked], near[asked])
    return least, hidden, passes


def _free_over(tracing: Tracing, found: Candidates, segment: Ints, near: _Near) -> Flags:
    """(R,) whether the way over the edge near one segment of each path is free.

    The rim of a plate is passed clear of its other edge. Along a face of the edge that the path is over, what lies
    behind that face is taken for what lies on it.
    """
    every, sharp = np.arange(len(found)), tracing.world.sharp
    wedges = at_poses(tracing, near.edge[every, segment], found.pose)
    point = wedges.start_m + near.height_m[every, segment, None] * wedges.along
    rim = np.where(np.isfinite(wedges.sheet_m), 2.0 * wedges.sheet_m, 0.0)
    clearance = rim + OFFSET * max((shadow.extent_m for shadow in sharp), default=1.0)
    face = near.face[every, segment]
    normal = tracing.mirrors.normal[found.pose, face]
    free = np.ones(len(found), dtype=bool)
    for ends in displaced_segments(tracing, found):
        end = ends[every, segment]
        rise = np.maximum(clearance - dot(normal, end - point), 0.0)
        end = end + np.where(face >= 0, rise, 0.0)[:, None] * normal
        angle = np.mod(np.arctan2(dot(end - point, wedges.normal), dot(end - point, wedges.inwards)), 2.0 * np.pi)
        clear = point + clearance[:, None] * clear_of_faces(wedges, angle)
        free &= free_between(tracing, end, clear, found.pose, sharp)
    return free


@dataclass(frozen=True)
class _Near(Rows):
    """The edge that the way passes with the least detour at each segment of C paths.

    Attributes:
        detour_m: (C, N + 1) beyond the straight way; infinite without such an edge.
        edge: (C, N + 1) its number, -1 without one.
        height_m: (C, N + 1) how high above its start the way meets it.
        face: (C, N + 1) patch that it shares with the edge of the path, -1 without one.
    """

    detour_m: Floats
    edge: Ints
    height_m: Floats
    face: Ints

    @classmethod
    def nothing(cls, shape: tuple[int, ...]) -> _Near:
        """No edge at any segment."""
        return cls(np.full(shape, np.inf), np.full(shape, -1), np.zeros(shape), np.full(shape, -1))


def _near_segments(search: Search, found: Candidates) -> _Near:
    """Edges near the way from the edge of each path to either end, straight in the images of the mirrors."""
    world, at, step = search.tracing.world, point_slot(found), np.diff(found.points_m, axis=1)
    length = norm(step)
    path, k = np.nonzero((np.arange(length.shape[1]) <= found.order[:, None]) & (length > COINCIDENT_M))
    total = np.pad(np.cumsum(length, axis=1), ((0, 0), (1, 0)))
    turn, late = total[path, at[path] + 1], k > at[path]
    before = total[path, k] - np.where(late, turn, 0.0)
    beyond = np.where(late, total[path, -1], turn) - total[path, k + 1]
    ahead = step[path, k] / length[path, k, None]
    met = _planes_met(search.tracing, found, at, path, k)
    borders = met.copy()
    borders[~world.wedges.flat[found.edge[path]], 2:] = -1
    wedges, planes, plates = world.wedges, world.planes[world.wedges.patch], np.append(world.plates, -1)
    convex = wedges.free_angle_rad > np.pi  # others hide nothing
    edges = _Edges(wedges.start_m, wedges.end_m, convex, plates[planes], world.planes_at_ends, world.edge_groups)
    straight = _Straight(
        found.points_m[path, k] - before[:, None] * ahead,
        found.points_m[path, k + 1] + beyond[:, None] * ahead,
        before,
        before + length[path, k],
        found.pose[path],
        found.edge[path],
        plates[borders],
        met,
    )
    most = BORDER_REACH_RAD / search.wavenumber_1_m
    detour, edge, height = _nearest(straight, search.tracing.placed, edges, most)  # type: ignore[call-arg]
    shared = (met[:, 2:, None] == planes[edge, None]).any(axis=2) & (met[:, 2:] >= 0) & (edge >= 0)[:, None]
    own = world.wedges.patch[found.edge[path], np.argmax(shared, axis=1)]
    near = _Near.nothing(length.shape)
    near.detour_m[path, k], near.height_m[path, k], near.edge[path, k] = detour, height, edge
    near.face[path, k] = np.where(shared.any(axis=1), own, -1)
    return near


def _planes_met(tracing: Tracing, found: Candidates, at: Ints, path: Ints, segment: Ints) -> Ints:
    """(S, 4) planes in which segments of paths (S,) end and begin; -1 for none.

    These are the mirrors at either end, and the faces of the edge that the path is over. In mirrors square to it such a
    face goes on: up to the first other mirror it is one face with its images. Where the edge ends at a mirror, on
    whichever side of it that is met, the mirror is none.
    """
    faces, planes = tracing.world.wedges.patch[found.edge], tracing.world.planes
    point = found.points_m[:, 1:-1]
    apart = norm(point - point[np.arange(len(found)), at][:, None]) > COINCIDENT_M
    mirror = (found.interaction == Interaction.SPECULAR) & apart
    number = np.pad(found.sequence, ((0, 0), (1, 1)), constant_values=-1)
    reflects = np.pad(mirror, ((0, 0), (1, 1)))
    met = np.full((len(path), 4), -1)
    for end in range(2):
        rows = np.flatnonzero(reflects[path, segment + end])
        met[rows, end] = planes[number[path[rows], segment[rows] + end]]
    slot = np.arange(found.sequence.shape[1])
    first, last = np.minimum(segment, at[path]), np.maximum(segment - 1, at[path])
    between = (first[:, None] <= slot) & (slot <= last[:, None]) & mirror[path]
    for side in range(2):
        normal = tracing.mirrors.normal[found.pose, faces[:, side]]
        aslant = np.abs(dot(found.normal, normal[:, None])) > SQUARE_COSINE
        met[:, 2 + side] = np.where((aslant[path] & between).any(axis=1), -1, planes[faces[path, side]])
    return met


class _Edges(NamedTuple):
    """W edges that may hide something.

    Attributes:
        start, end: (W, 3) at rest.
        hides: (W,) whether they do.
        plate: (W, 2) thin plates or planes of their faces.
        at_ends: (W, 2, M) planes in which their starts and ends lie, -1 padded.
        groups: neighbours among them, of one obstacle each, at rest.
    """

    start: Floats
    end: Floats
    hides: Flags
    plate: Ints
    at_ends: Ints
    groups: Groups


class _Straight(NamedTuple):
    """What is asked about S segments, each part of a way that is straight in the images of mirrors.

    Attributes:
        here, there: (S, 3) ends of the way.
        first, last: (S,) between which lengths from `here` the way is the segment, and passes edges.
        pose: (S,).
        own: (S,) the edge of the path, which the way passes in a mirror on which its face stands; -1 for others.
        apart: (S, 4) thin plates or planes whose edges do not count.
        met: (S, 4) planes whose edges' ends do not count.
    """

    here: Floats
    there: Floats
    first: Floats
    last: Floats
    pose: Ints
    own: Ints
    apart: Ints
    met: Ints


@compiled
def _nearest(straight, placed, edges, most):
    """(S,) least detour over an edge of the way of each segment, the number of the edge, and where above its start.

    Args:
        straight: `_Straight`.
        placed: (N, O, 4) frames of the obstacles.
        edges: `_Edges`.
        most: detours that are no longer count.
    """
    here, there, first, last, pose, own, apart, met = straight
    start, end, hides, plate, at_ends, groups = edges
    least, edge, height = np.full(len(pose), np.inf), np.full(len(pose), -1), np.zeros(len(pose))
    a, b = np.empty(3), np.empty(3)
    for s in range(len(pose)):
        best, body, way = most, -1, distance(here[s], there[s])
        for g in range(len(groups.owner)):
            if groups.owner[g] != body:
                body = groups.owner[g]
                fill_rest(here[s], placed[pose[s], body], a)
                fill_rest(there[s], placed[pose[s], body], b)
            if distance(a, groups.ball[g, :3]) + distance(b, groups.ball[g, :3]) - way > best + 2.0 * groups.ball[g, 3]:
                continue
            for w in groups.member[groups.first[g] : groups.first[g + 1]]:
                if not hides[w] or _touched(apart[s], plate[w]):
                    continue
                h, to, fro = over_edge(a, b, start[w], end[w])
                detour, along = to + fro - way, 0.5 * (way + (to - fro) * (to + fro) / way)
                if detour > best or (detour == best and not w < edge[s]):  # of two in one place the first
                    continue
                aside = min(np.sqrt(max(to * to - along * along, 0.0)), CLOSE_M)
                low = max(first[s] - aside, 0.0)  # what the way passes right at a mirror is passed on either side of it
                close = CLOSE_M if w != own[s] else FLUSH_M
                if not low <= along <= min(last[s] + aside, way) or min(to, fro) < close:
                    continue
                if not _ends_there(met[s], at_ends[w], h, start[w], end[w]):
                    best, least[s], edge[s], height[s] = detour, max(detour, 0.0), w, h
    return least, edge, height


@inlined
def _touched(apart, plate):
    """Whether any of four plates is one of two, -1 apart."""
    touched = False
    for a in apart:
        touched = touched or (a >= 0 and (a == plate[0] or a == plate[1]))
    return touched


@inlined
def _ends_there(met, at_ends, height, start, end):
    """Whether a height is that of an edge's start or end in any of four planes: these have borders of their own."""
    which = 0 if height == 0.0 else 1
    found = False
    if height == 0.0 or height >= distance(start, end):
        for m in met:
            for plane in at_ends[which]:
                found = found or (m >= 0 and m == plane)
    return found
