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

from dataclasses import replace
from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from simulator.diffraction.edge_pairs import EdgePairs, edge_pairs
from simulator.diffraction.edge_view import APEX, END, START, EdgeView
from simulator.diffraction.finite_edge import edge_terms, strength_bound
from simulator.diffraction.patch_borders import border_share, own_detour_m
from simulator.diffraction.wedge_coordinates import at_poses, edge_points, outside, seen
from simulator.images.given_planes import last_image
from simulator.images.unfolding import Turns, straightened, unfolded
from simulator.surfaces.wedges import Wedges
from simulator.world.candidates import Candidates
from simulator.world.interactions import Interaction
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing


def diffracted(search: Search, loudest: Floats) -> Candidates:
    """Apex and ends of every edge, with mirrors before and after, as far as they are audible beside the strongest echo.

    Args:
        loudest: (N, 2) strongest other echo at each pose and microphone.
    """
    audible = search.audible
    pairs, part, bound = _contributions(search, edge_pairs(search))
    wedge, at, strongest = pairs.wedge, (pairs.pose, pairs.mic), loudest.copy()
    np.maximum.at(strongest, at, bound)
    kept = audible(bound, strongest[at])
    faint, loud = np.flatnonzero(~kept), np.flatnonzero(kept)

    def turns(rows: Ints) -> Turns:
        return _turns(search, pairs[rows], part[rows])

    search.reject(  # whether the mirrors of what is faint would be met is not asked
        Reason.FAINT_EDGE, len(faint), lambda: Rejected(bound[faint], partial(straightened, search, turns(faint)))
    )

    def arrives(missing: Candidates, rows: Ints) -> Flags:
        over = replace(missing, edge=wedge[loud[rows]], part=part[loud[rows]])
        view = views_of(search.tracing, over)[1]
        left = np.abs(left_by_mirrors(search.tracing, over, view, np.array([search.wavenumber_1_m]))[:, 0])
        return (left > 0.0) & audible(left * bound[loud[rows]], strongest[at][loud[rows]])

    found, ok = unfolded(search, turns(loud), lambda: bound[loud], arrives)
    return replace(found, edge=wedge[loud[ok]], part=part[loud[ok]])


def _contributions(search: Search, pairs: EdgePairs) -> tuple[EdgePairs, Ints, Floats]:
    """What each pair of images receives of its edge, one row each: the pair, the part, and a bound of the gain."""
    wedges = search.tracing.world.wedges
    rows_of, parts, bounds = [], [], []
    view = pairs.view(wedges)
    for part in (APEX, START, END):
        rows = np.flatnonzero(_has_partner(wedges, pairs, part, search.max_order))
        rows = rows[_has(wedges.radiates[pairs.wedge[rows]], view[rows], part)]
        seen = view[rows]
        near = np.flatnonzero(seen.path_m(np.full(len(seen), part)) <= search.limit_m)
        rows_of.append(rows[near])
        parts.append(np.full(len(near), part))
        bounds.append(strength_bound(seen[near], parts[-1], search.wavenumber_1_m))
    return pairs[np.concatenate(rows_of)], np.concatenate(parts), np.concatenate(bounds)


def _has(radiates: Flags, view: EdgeView, part: int) -> Flags:
    """(R,) whether an apex lies on its edge, or an end is one that radiates, (R, 2)."""
    return view.has(part) if part == APEX else radiates[:, part - START]


def _has_partner(wedges: Wedges, pairs: EdgePairs, part: int, max_order: int) -> Flags:
    """(R,) whether an end that stands on a mirror comes with what nearly cancels it: the end of the edge's image.

    Its path has that mirror on both sides where this one has it on neither.
    """
    if part == APEX:
        return np.ones(len(pairs), dtype=bool)
    mirror = wedges.leans_on[pairs.wedge, part - START]
    return (mirror < 0) | pairs.beside(mirror) | (pairs.order + 3 <= max_order)


def _turns(search: Search, pairs: EdgePairs, part: Ints) -> Turns:
    """Paths over apexes and ends (R,)."""
    tracing = search.tracing
    wedges = at_poses(tracing, pairs.wedge, pairs.pose)
    point = edge_points(wedges, pairs.view(tracing.world.wedges), part)
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


def point_slot(found: Candidates) -> Ints:
    """(C,) place of the edge or cell in the sequence of reflectors; meaningless for paths without one."""
    return np.argmax(found.interaction >= Interaction.EDGE, axis=1).astype(np.int64)


def views_of(tracing: Tracing, found: Candidates) -> tuple[Wedges, EdgeView]:
    """Edges and views of paths (C,) that all have an edge, the mirrors unfolded."""
    at, wedges = point_slot(found), at_poses(tracing, found.edge, found.pose)
    planes = found.normal, np.sum(found.normal * found.points_m[:, 1:-1], axis=2)
    width = found.sequence.shape[1]
    early = [(k, k < at) for k in range(width)]
    late = [(k, (k > at) & (k < found.order)) for k in reversed(range(width))]
    source = last_image(found.points_m[:, 0], *planes, early)
    receiver = last_image(found.points_m[:, -1], *planes, late)
    return wedges, seen(wedges, source, receiver)


def left_by_mirrors(tracing: Tracing, found: Candidates, view: EdgeView, wavenumber: Floats) -> Complexes:
    """(C, K) what mirrors that end leave of paths (C,) over edges seen so."""
    return border_share(tracing, found, point_slot(found), own_detour_m(view, found.part), wavenumber)


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
    angle = np.where(corner, 0.25 * turn, np.clip(angle_rad, margin, turn - margin))[:, None]
    return np.cos(angle) * wedges.inwards + np.sin(angle) * wedges.normal
