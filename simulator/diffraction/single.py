"""Paths over one sharp edge with mirrors before and after it.

As for curved surfaces, a mirror only moves the point that the edge sees: the apex is found between the images of
speaker and microphone, and the mirrors' crossings afterwards from both sides. Every edge gives up to three rows: its
apex, if that lies on it, and its two ends. Each stands or falls with the visibility of its own point.

First order only. Against full-wave plates of 0.2-0.45 m at 1.5-3 m, peak of the matched filter: 0.04 dB and 0.2
samples (192 kHz) where the echo is above -20 dB re wall, 0.4 dB and 2.1 samples to -30 dB, 0.94 dB and 2.4 samples
below (30-60 degrees off the normal). Within some 10 degrees of edge-on a thin plate falls silent in truth, as nothing
moves against it, while its far edge alone keeps -35 dB: the waves from edge to edge that cancel it are in
`chain_integrals`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from obstaclewatch.support.vectors import dot, norm
from simulator.diffraction.edge_pairs import EdgePairs, edge_pairs
from simulator.diffraction.edge_view import APEX, END, START, EdgeView, at_poses, row_of, seen, this_side
from simulator.diffraction.faces_in_mirrors import onto_faces
from simulator.diffraction.finite_edge import edge_terms, strength_bounds
from simulator.diffraction.patch_borders import border_share, own_detours_m
from simulator.images.given_planes import last_image, mirrors_about, planes_met
from simulator.images.unfolding import Turns, straightened, unfolded
from simulator.surfaces.wedges import Wedges
from simulator.world.candidates import Candidates
from simulator.world.interactions import Interaction
from simulator.world.mirrors import FLUSH_M, ON_BORDER_M
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing

INTO_M = 0.01  # from an end on: an edge that a mirror shows there it shows up to its end
AT_ONCE = 2**17  # contributions: what is kept in memory of all of them is little


@dataclass(frozen=True)
class _Contributions:
    """R contributions of edges.

    Attributes:
        pairs: the pair of images of each.
        part: (R,) apex or end of the edge.
        bound: (R,) of the gain.
    """

    pairs: EdgePairs
    part: Ints
    bound: Floats

    def __len__(self) -> int:
        return len(self.part)

    def __getitem__(self, rows: Ints) -> _Contributions:
        return _Contributions(self.pairs[rows], self.part[rows], self.bound[rows])

    @classmethod
    def joined(cls, some: Sequence[_Contributions]) -> _Contributions:
        """All of several, part by part."""
        pairs, part, bound = zip(*((each.pairs, each.part, each.bound) for each in some), strict=True)
        every = cls(EdgePairs.joined(pairs), np.concatenate(part), np.concatenate(bound))
        return every[np.argsort(every.part, kind="stable")]

    @property
    def at(self) -> tuple[Ints, Ints]:
        """(R,) pose and microphone."""
        return self.pairs.pose, self.pairs.mic


def diffracted(search: Search, loudest: Floats) -> Candidates:
    """Apex and ends of every edge, with mirrors before and after, as far as they are audible beside the strongest echo.

    Args:
        loudest: (N, 2) strongest other echo at each pose and microphone.
    """
    strongest, kept = loudest.copy(), []
    for some_pairs in edge_pairs(search):
        some = _contributions(search, some_pairs)
        np.maximum.at(strongest, some.at, some.bound)
        kept.append(_audible(search, some, strongest))
    loud = _audible(search, _Contributions.joined(kept), strongest)
    blocks = np.array_split(np.arange(len(loud)), len(loud) // AT_ONCE + 1)
    return Candidates.joined([_shown(search, loud[rows], strongest) for rows in blocks])


def _audible(search: Search, some: _Contributions, strongest: Floats) -> _Contributions:
    """Those that are loud enough beside the strongest echo (N, 2) at each pose and microphone."""
    kept = search.audible(some.bound, strongest[some.at])

    def described() -> Rejected:  # whether the mirrors of what is faint would be met is not asked
        faint = some[np.flatnonzero(~kept)]
        return Rejected(faint.bound, partial(straightened, search, _turns(search, faint)))

    search.reject(Reason.FAINT_EDGE, len(kept) - int(kept.sum()), described)
    return some[np.flatnonzero(kept)]


def _shown(search: Search, some: _Contributions, strongest: Floats) -> Candidates:
    """The paths over edges that mirrors show, and over those beside what they show that arrive all the same."""

    def arrives(rows: Ints, missing: Candidates, beside: Ints) -> Flags:
        these = some[rows[beside]]
        over = replace(missing, edge=these.pairs.wedge, part=these.part)
        view = views_of(search.tracing, over)[1]
        with np.errstate(invalid="ignore"):  # NaN where a way runs along a mirror's plane
            share = left_by_mirrors(search.tracing, over, view, np.array([search.wavenumber_1_m]))
        left = np.abs(share).max(axis=(1, 2))
        return (left > 0.0) & search.audible(left * these.bound, strongest[these.at])

    def shown(rows: Ints, into_m: float) -> tuple[Candidates, Ints]:
        these = some[rows]
        turns = _turns(search, these, into_m)
        found, ok = unfolded(search, turns, lambda: these.bound, partial(arrives, rows))
        return found, rows[ok]

    found, rows = shown(np.arange(len(some)), 0.0)
    at_end = _at_end(found, some.part[rows])
    before_end = np.isin(rows, shown(rows[at_end], INTO_M)[1]) if at_end.any() else at_end
    left = np.flatnonzero(~at_end | before_end)
    these = some[rows[left]]
    return replace(found[left], edge=these.pairs.wedge, part=these.part)


def _at_end(found: Candidates, part: Ints) -> Flags:
    """(C,) whether a mirror is met where the edge of a path ends: whether it shows the edge, what is before tells."""
    each = np.arange(len(found))
    end = found.points_m[each, 1 + point_slot(found)]
    met = (norm(found.points_m[:, 1:-1] - end[:, None]) < FLUSH_M) & (found.interaction == Interaction.SPECULAR)
    on_mirror: Flags = (part != APEX) & np.logical_or.reduce(met, axis=1)
    return on_mirror


def _contributions(search: Search, pairs: EdgePairs) -> _Contributions:
    """What each pair of images receives of its edge."""
    wedges = search.tracing.world.wedges
    view, radiates = pairs.view(wedges), wedges.radiates.take(pairs.wedge, axis=0)
    parts = APEX, START, END
    exists = [_has(radiates, view, part) & _has_partner(wedges, pairs, part, search.max_order) for part in parts]
    exists[APEX] |= _apex_on_mirror(search.tracing, pairs, view)
    rows, part, bound = strength_bounds(view, np.array(exists), search.wavenumber_1_m, search.limit_m)
    return _Contributions(pairs[rows], part, bound)


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


def _turns(search: Search, some: _Contributions, into_m: float = 0.0) -> Turns:
    """Paths over apexes and ends (R,), or over what is so far before the ends, and half an edge at most."""
    tracing, pairs = search.tracing, some.pairs
    row, view = row_of(tracing, pairs.wedge, pairs.pose), pairs.view(tracing.world.wedges)
    start, end = (each.take(row, axis=0) for each in (tracing.wedges.start_m, tracing.wedges.end_m))
    along = np.minimum(into_m / view.length_m, 0.5)[:, None] * (end - start)
    point = edge_points(start + along, end - along, view, some.part)
    number = tracing.world.numbering.number(Interaction.EDGE, pairs.wedge)
    return Turns(pairs.images(), point[:, None], number[:, None])


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
    return np.asarray(np.logical_and(*within(view)) & this_side(view, sheet_m))


def within(view: EdgeView) -> tuple[Flags, Flags]:
    """(R,) whether the source and the receiver are in the open angle of the edge."""
    angles = view.source_angle_rad, view.receiver_angle_rad
    return tuple((angle >= 0.0) & (angle <= view.open_angle_rad) for angle in angles)  # type: ignore[return-value]


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
