"""Paths over one sharp edge with mirrors before and after it.

As for curved surfaces, a mirror only moves the point that the edge sees: the apex is found between the images of
speaker and microphone, and the mirrors' crossings afterwards from both sides. Every edge gives up to three rows: its
apex, if that lies on it, and its two ends. Each stands or falls with the visibility of its own point.

First order only. Against full-wave plates of 0.2-0.45 m at 1.5-3 m, peak of the matched filter: 0.04 dB and 0.2
samples (192 kHz) where the echo is above -20 dB re wall, 0.4 dB and 2.1 samples to -30 dB, 0.94 dB and 2.4 samples
below (30-60 degrees off the normal). Within some 10 degrees of edge-on a thin plate falls silent in truth, as nothing
moves against it, while its far edge alone keeps -35 dB: the waves from edge to edge that cancel it are in
`chain_integrals`.

Millions of pairs of images are listed and thousands are kept. A pair is two row numbers until it is wanted, and where
an image stands about its edge is worked out once, however many pairs it is part of.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import dot, norm
from simulator.diffraction.edge_view import APEX, END, START, EdgeView
from simulator.diffraction.faces_in_mirrors import bends_on, onto_faces
from simulator.diffraction.finite_edge import edge_terms, strength_bounds
from simulator.diffraction.patch_borders import border_share, own_detours_m
from simulator.diffraction.wedge_coordinates import at_poses, cylindrical, row_of, seen
from simulator.images.given_planes import last_image, mirrors_about, planes_met
from simulator.images.image_pairs import Pairs, matches
from simulator.images.image_tree import EdgeImages, images_lighting_edges
from simulator.images.unfolding import Turns, straightened, unfolded
from simulator.surfaces.wedges import Wedges
from simulator.world.candidates import Candidates
from simulator.world.interactions import Interaction
from simulator.world.mirrors import FLUSH_M, ON_BORDER_M
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.visibility import COINCIDENT_M
from simulator.world.world import Tracing

INTO_M = 0.01  # from an end on: an edge that a mirror shows there it shows up to its end
IN_PLANE_RAD = 1e-9  # from a mirror: what lies in its plane is its own image


@dataclass(frozen=True)
class EdgeSights(Rows):
    """I images and the edges that they see.

    Attributes:
        images: by pose, then wedge.
        radius_m, angle_rad, height_m: (I,) distance from the edge's line, angle from face 0, height above its start.
        least_m: (I,) what the way from an image to its edge is not shorter than.
    """

    images: EdgeImages
    radius_m: Floats
    angle_rad: Floats
    height_m: Floats
    least_m: Floats

    def place(self, rows: Ints) -> tuple[Floats, Floats, Floats]:
        """Distances, angles and heights of some rows."""
        return self.radius_m[rows], self.angle_rad[rows], self.height_m[rows]

    @property
    def last(self) -> Ints:
        """(I,) mirror met next to the edge, -1 for none."""
        images = self.images
        if images.sequence.shape[1] == 0:
            return np.full(len(images), -1)
        last = images.sequence[np.arange(len(images)), images.order - 1]
        return np.where(images.order > 0, last, -1)


@dataclass(frozen=True)
class EdgePairs:
    """R pairs of images over an edge.

    Attributes:
        before, after: images of the speaker and of both microphones that see an edge.
        left, right: (R,) rows of these.
        mic: (R,) microphone at which each pair ends.
    """

    before: EdgeSights
    after: EdgeSights
    left: Ints
    right: Ints
    mic: Ints

    def __len__(self) -> int:
        return len(self.left)

    def __getitem__(self, rows: Ints) -> EdgePairs:
        return EdgePairs(self.before, self.after, self.left[rows], self.right[rows], self.mic[rows])

    @property
    def wedge(self) -> Ints:
        """(R,) edge."""
        return self.before.images.wedge[self.left]

    @property
    def pose(self) -> Ints:
        """(R,)."""
        return self.before.images.pose[self.left]

    @property
    def order(self) -> Ints:
        """(R,) number of mirrors."""
        return self.before.images.order[self.left] + self.after.images.order[self.right]

    def images(self) -> Pairs:
        """The images themselves."""
        return Pairs(self.mic, self.before.images[self.left], self.after.images[self.right])

    def view(self, wedges: Wedges) -> EdgeView:
        """How the images of each pair see their edge, of all wedges in the scene."""
        source, receiver, wedge = self.before.place(self.left), self.after.place(self.right), self.wedge
        return EdgeView(*source, *receiver, wedges.length_m[wedge], wedges.open_angle_rad[wedge])

    def beside(self, mirror: Ints) -> Flags:
        """(R,) whether either image is one in a given mirror of each pair, next to the edge; never for -1."""
        met = (self.before.last[self.left] == mirror) | (self.after.last[self.right] == mirror)
        return (mirror >= 0) & met


def diffracted(search: Search, loudest: Floats) -> Candidates:
    """Apex and ends of every edge, with mirrors before and after, as far as they are audible beside the strongest echo.

    Args:
        loudest: (N, 2) strongest other echo at each pose and microphone.
    """
    audible = search.audible
    pairs, part, bound = _contributions(search, _edge_pairs(search))
    wedge, at, strongest = pairs.wedge, (pairs.pose, pairs.mic), loudest.copy()
    np.maximum.at(strongest, at, bound)
    kept = audible(bound, strongest[at])
    faint, loud = np.flatnonzero(~kept), np.flatnonzero(kept)

    def turns(rows: Ints, into_m: float = 0.0) -> Turns:
        return _turns(search, pairs[rows], part[rows], into_m)

    search.reject(  # whether the mirrors of what is faint would be met is not asked
        Reason.FAINT_EDGE, len(faint), lambda: Rejected(bound[faint], partial(straightened, search, turns(faint)))
    )

    def arrives(rows: Ints, missing: Candidates, some: Ints) -> Flags:
        over = replace(missing, edge=wedge[rows[some]], part=part[rows[some]])
        view = views_of(search.tracing, over)[1]
        with np.errstate(invalid="ignore"):  # NaN where a way runs along a mirror's plane
            share = left_by_mirrors(search.tracing, over, view, np.array([search.wavenumber_1_m]))
        left = np.abs(share).max(axis=(1, 2))
        return (left > 0.0) & audible(left * bound[rows[some]], strongest[at][rows[some]])

    def shown(rows: Ints, into_m: float) -> tuple[Candidates, Ints]:
        found, ok = unfolded(search, turns(rows, into_m), lambda: bound[rows], partial(arrives, rows))
        return found, rows[ok]

    found, rows = shown(loud, 0.0)
    at_end = _at_end(found, part[rows])
    before_end = np.isin(rows, shown(rows[at_end], INTO_M)[1]) if at_end.any() else at_end
    left = np.flatnonzero(~at_end | before_end)
    return replace(found[left], edge=wedge[rows[left]], part=part[rows[left]])


def _at_end(found: Candidates, part: Ints) -> Flags:
    """(C,) whether a mirror is met where the edge of a path ends: whether it shows the edge, what is before tells."""
    each = np.arange(len(found))
    end = found.points_m[each, 1 + point_slot(found)]
    met = (norm(found.points_m[:, 1:-1] - end[:, None]) < FLUSH_M) & (found.interaction == Interaction.SPECULAR)
    on_mirror: Flags = (part != APEX) & np.logical_or.reduce(met, axis=1)
    return on_mirror


def _contributions(search: Search, pairs: EdgePairs) -> tuple[EdgePairs, Ints, Floats]:
    """What each pair of images receives of its edge, one row each: the pair, the part, and a bound of the gain."""
    wedges = search.tracing.world.wedges
    view, radiates = pairs.view(wedges), wedges.radiates.take(pairs.wedge, axis=0)
    parts = APEX, START, END
    exists = [_has(radiates, view, part) & _has_partner(wedges, pairs, part, search.max_order) for part in parts]
    exists[APEX] |= _apex_on_mirror(search.tracing, pairs, view)
    rows, part, bound = strength_bounds(view, np.array(exists), search.wavenumber_1_m, search.limit_m)
    return pairs[rows], part, bound


def _has(radiates: Flags, view: EdgeView, part: int) -> Flags:
    """(R,) whether an apex lies on its edge, or an end is one that radiates, (R, 2)."""
    return view.has(part) if part == APEX else radiates[:, part - START]


def _apex_on_mirror(tracing: Tracing, pairs: EdgePairs, view: EdgeView) -> Flags:
    """(R,) whether an apex lies right where its edge runs into the mirror next to it in the path.

    With the mirror on the other side of the edge it lies there as well. Rounding would say of either by itself whether
    it is on the edge; so both are, and `field.twins` keeps one.
    """
    there, height = np.zeros(len(pairs), dtype=bool), view.apex_height_m
    past = np.stack([height, height - view.length_m], axis=1)
    row, end = np.nonzero((np.abs(past) <= ON_BORDER_M) & ~tracing.world.wedges.radiates.take(pairs.wedge, axis=0))
    some, at = pairs[row], row_of(tracing, pairs.wedge[row], pairs.pose[row])
    point = np.where((end == 0)[:, None], tracing.wedges.start_m[at], tracing.wedges.end_m[at])
    for mirror in (some.before.last[some.left], some.after.last[some.right]):
        normal, offset = (each[some.pose, mirror] for each in (tracing.mirrors.normal, tracing.mirrors.offset_m))
        there[row[(mirror >= 0) & (np.abs(dot(point, normal) - offset) < FLUSH_M)]] = True
    return there


def _has_partner(wedges: Wedges, pairs: EdgePairs, part: int, max_order: int) -> Flags:
    """(R,) whether an end that stands on a mirror comes with what nearly cancels it: the end of the edge's image.

    Its path has that mirror on both sides where this one has it on neither.
    """
    if part == APEX:
        return np.ones(len(pairs), dtype=bool)
    mirror = wedges.leans_on[pairs.wedge, part - START]
    return (mirror < 0) | pairs.beside(mirror) | (pairs.order + 3 <= max_order)


def _turns(search: Search, pairs: EdgePairs, part: Ints, into_m: float) -> Turns:
    """Paths over apexes and ends (R,), or over what is so far before the ends, and half an edge at most."""
    tracing = search.tracing
    row, view = row_of(tracing, pairs.wedge, pairs.pose), pairs.view(tracing.world.wedges)
    start, end = (each.take(row, axis=0) for each in (tracing.wedges.start_m, tracing.wedges.end_m))
    along = np.minimum(into_m / view.length_m, 0.5)[:, None] * (end - start)
    point = edge_points(start + along, end - along, view, part)
    number = tracing.world.numbering.number(Interaction.EDGE, pairs.wedge)
    return Turns(pairs.images(), point[:, None], number[:, None])


def _edge_pairs(search: Search) -> EdgePairs:
    """Images of the speaker with those of a microphone at the same pose and edge, within order and range.

    What a face on a mirror and its image diffract has that mirror before it or not: behind it, it would be the same.
    """
    wedges, mirrors = search.tracing.world.wedges, search.max_order - 1
    lit = _sights(search, search.tracing.source_m)
    parts = []
    for mic in range(2):
        received = _sights(search, search.tracing.mics_m[:, mic])
        mirror = wedges.mirror[received.images.wedge]
        received = received[np.flatnonzero((mirror < 0) | (received.last != mirror))]
        key, other = (each.images.pose * len(wedges) + each.images.wedge for each in (lit, received))
        left, right = matches(key, lit.images.order, other, received.images.order, mirrors)
        parts.append(_kept(search, EdgePairs(lit, received, left, right, np.full(len(left), mic))))
    after = EdgeSights.joined([part.after for part in parts])
    left, right, mics = (np.concatenate([getattr(part, name) for part in parts]) for name in ("left", "right", "mic"))
    return EdgePairs(lit, after, left, right + mics * len(parts[0].after), mics)


def _sights(search: Search, point_m: Floats) -> EdgeSights:
    """Images of (N, 3) points, one a pose, and the edges that they see from outside."""
    tracing = search.tracing
    wedges, rest = tracing.wedges, tracing.world.wedges
    start, end = (each.reshape(len(tracing.pose), len(rest), 3) for each in (wedges.start_m, wedges.end_m))
    allowed = np.ones((search.max_order - 1, len(search.large_mirrors)), dtype=bool)
    allowed[1:] &= search.large_mirrors
    images = images_lighting_edges(
        tracing.mirrors, rest, start, end, allowed, search.large_towards, point_m, search.limit_m
    )
    row = row_of(tracing, images.wedge, images.pose)
    radius, angle, height = cylindrical(wedges, row, images.point_m)
    middle = (0.5 * (wedges.start_m + wedges.end_m)).take(row, axis=0)
    least = norm(images.point_m - middle) - 0.5 * rest.length_m[images.wedge]
    turn = rest.open_angle_rad[images.wedge]
    reached = (angle >= 0.0) & (angle <= turn)
    behind = np.flatnonzero(~reached)
    reached[behind] = bends_on(search, images[behind], radius[behind], angle[behind])
    sights = EdgeSights(images, radius, angle, height, least)
    return sights[reached & _before_mirror(sights, rest)]


def _before_mirror(sights: EdgeSights, wedges: Wedges) -> Flags:
    """(I,) whether images about corners come from before the mirror there: its image in it lies beyond, and only that.

    Behind a sheet that is folded a corner opens on the one side, and what is on the other has no part in it.
    """
    wedge = sights.images.wedge
    past = sights.angle_rad - wedges.free_angle_rad[wedge]
    mirrored = sights.last == wedges.mirror[wedge]
    return (wedges.mirror[wedge] < 0) | (np.where(mirrored, -past, past) <= IN_PLANE_RAD)


def _kept(search: Search, pairs: EdgePairs) -> EdgePairs:
    """Those within the range that may be met, on this side of their edge, and whose mirrors are large or one at most.

    Either may lie inside the edge: what runs along a face of it bends on there (`faces_in_mirrors`).
    """
    wedges = search.tracing.world.wedges
    least = pairs.before.least_m[pairs.left] + pairs.after.least_m[pairs.right]
    pairs = pairs[np.flatnonzero(least <= search.limit_m)]
    pairs = pairs[_by_large_patches(search, pairs)]
    view = pairs.view(wedges)
    return pairs[np.flatnonzero(_this_side(view, wedges.sheet_m[pairs.wedge]))]


def _by_large_patches(search: Search, pairs: EdgePairs) -> Ints:
    """Rows all of whose mirrors and a face of whose edge are large, or that have one mirror at most.

    So it is for paths without edges: what a small patch reflects and what its borders diffract nearly cancel, and one
    of them alone is far too loud.
    """
    wedges = search.tracing.world.wedges
    large = np.append(search.large_mirrors, True)  # -1: curved, or no mirror
    towards = np.pad(search.large_towards, ((0, 1), (0, 0)), constant_values=True)
    several = pairs.order > 1
    rows = np.flatnonzero(several)
    some = pairs[rows]
    kept = large[wedges.patch[some.wedge]].any(axis=1)
    for sights, row in ((some.before, some.left), (some.after, some.right)):
        met = towards[sights.images.sequence, wedges.obstacle[sights.images.wedge, None]]
        kept &= np.logical_and.reduce(met, axis=1)[row]
    several[rows] = ~kept
    return np.flatnonzero(~several)


def diffracted_once(tracing: Tracing, wedge: Ints, pose: int, mic: int, wavenumber: Floats) -> Complexes:
    """(K,) what some rigid edges (E,) diffract alone at one pose, with its travel phase, whatever stands between."""
    every = np.full(len(wedge), pose)
    wedges = at_poses(tracing, wedge, every)
    view = seen(wedges, tracing.source_m[every], tracing.mics_m[every, mic])
    there = outside(view, wedges.sheet_m)
    total = np.zeros(len(wavenumber), dtype=np.complex128)
    for part in (APEX, START, END):
        some = view[np.flatnonzero(there & _has(wedges.radiates, view, part))]
        which = np.full(len(some), part)
        phase = np.exp(-1j * some.path_m(which)[:, None] * wavenumber)
        total += (edge_terms(some, which, wavenumber).sum(axis=1) * phase).sum(axis=0)
    return total


def left_by_mirrors(tracing: Tracing, found: Candidates, view: EdgeView, wavenumber: Floats) -> Complexes:
    """(C, 3, K) what mirrors that end leave of paths (C,) over edges seen so, by the groups of `edge_terms`."""
    own_m = own_detours_m(view, found.part)
    return border_share(tracing, onto_faces(tracing, found, view), point_slot(found), own_m, wavenumber)


def outside(view: EdgeView, sheet_m: Floats) -> Flags:
    """(R,) whether source and receiver see the edge: in its open angle, and on this side of a plate so thick."""
    return np.asarray(np.logical_and(*within(view)) & _this_side(view, sheet_m))


def within(view: EdgeView) -> tuple[Flags, Flags]:
    """(R,) whether the source and the receiver are in the open angle of the edge."""
    angles = view.source_angle_rad, view.receiver_angle_rad
    return tuple((angle >= 0.0) & (angle <= view.open_angle_rad) for angle in angles)  # type: ignore[return-value]


def _this_side(view: EdgeView, sheet_m: Floats) -> Flags:
    """(R,) whether both are off the edge's line, and on this side of a plate so thick."""
    rise = view.source_radius_m * np.sin(view.source_angle_rad)
    rise = rise + view.receiver_radius_m * np.sin(view.receiver_angle_rad)
    apart = np.minimum(view.source_radius_m, view.receiver_radius_m) > COINCIDENT_M
    return np.asarray((rise + sheet_m > 0.0) & apart)


def edge_points(start_m: Floats, end_m: Floats, view: EdgeView, part: Ints) -> Floats:
    """(R, 3) apex or end of edges."""
    share = view.apex_height_m / view.length_m
    apex = start_m + share[:, None] * (end_m - start_m)
    part = part[:, None]
    return np.where(part == APEX, apex, np.where(part == START, start_m, end_m))


def point_slot(found: Candidates) -> Ints:
    """(C,) place of the edge or cell in the sequence of reflectors; meaningless for paths without one."""
    return np.argmax(found.interaction >= Interaction.EDGE, axis=1).astype(np.int64)


def views_of(tracing: Tracing, found: Candidates) -> tuple[Wedges, EdgeView]:
    """Edges and views of paths (C,) that all have an edge, the mirrors unfolded."""
    at, wedges = point_slot(found), at_poses(tracing, found.edge, found.pose)
    planes, (early, late) = planes_met(found), mirrors_about(found, at, at)
    source = last_image(found.points_m[:, 0], *planes, early)
    receiver = last_image(found.points_m[:, -1], *planes, late)
    return wedges, seen(wedges, source, receiver)


def off_faces(tracing: Tracing, found: Candidates) -> tuple[Floats, Floats]:
    """(C, 3) unit vectors by which the arriving and the leaving segment stand clear of the edge's own faces."""
    wedges, view = views_of(tracing, found)
    return tuple(clear_of_faces(wedges, angle) for angle in (view.source_angle_rad, view.receiver_angle_rad))  # type: ignore[return-value]


def clear_of_faces(wedges: Wedges, angle_rad: Floats) -> Floats:
    """Direction off the edge nearest to a segment's own that leaves the planes of both faces.

    At 135 degrees from the face, not at 90: there a segment square to one face of a box or a plate would end in the
    plane of the other face or the rim, and rounding would decide whether it is free.

    Where a face stands on a mirror, the direction between the two.
    """
    turn = wedges.open_angle_rad
    margin = np.minimum(0.75 * np.pi, 0.5 * turn)
    corner = wedges.free_angle_rad < turn
    angle = np.where(corner, 0.25 * turn, np.clip(angle_rad, margin, turn - margin))
    return wedges.direction_at(angle)
