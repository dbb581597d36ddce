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
from simulator.diffraction.edge_view import APEX, END, START, EdgeView
from simulator.diffraction.finite_edge import edge_terms, strength_bound
from simulator.diffraction.patch_borders import border_share, own_detour_m
from simulator.images.given_planes import last_image
from simulator.images.image_pairs import Pairs, joined_pairs, matches
from simulator.images.image_tree import EdgeImages, Images, images_lighting_edges
from simulator.images.unfolding import Turns, straightened, unfolded
from simulator.surfaces.wedges import Wedges
from simulator.world.candidates import Candidates
from simulator.world.frames import out_of_rest, rotated
from simulator.world.interactions import Interaction
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.visibility import COINCIDENT_M
from simulator.world.world import Tracing

ON_FACE_RAD = 1e-9  # a source this close to a face's plane by rounding stands on it


def diffracted(search: Search, loudest: Floats) -> Candidates:
    """Apex and ends of every edge, with mirrors before and after, as far as they are audible beside the strongest echo.

    Args:
        loudest: (N, 2) strongest other echo at each pose and microphone.
    """
    audible = search.audible
    pairs, wedge = _edge_pairs(search)
    pair, part, point, bound = _contributions(search, pairs, wedge)
    pairs, wedge, strongest = pairs[pair], wedge[pair], loudest.copy()
    at = pairs.pose, pairs.mic
    np.maximum.at(strongest, at, bound)
    kept = audible(bound, strongest[at])
    number = search.tracing.world.numbering.number(Interaction.EDGE, wedge)
    turns, faint, loud = Turns(pairs, point[:, None], number[:, None]), np.flatnonzero(~kept), np.flatnonzero(kept)
    search.reject(  # whether the mirrors of what is faint would be met is not asked
        Reason.FAINT_EDGE, len(faint), lambda: Rejected(bound[faint], partial(straightened, search, turns[faint]))
    )

    def arrives(missing: Candidates, rows: Ints) -> Flags:
        over = replace(missing, edge=wedge[loud[rows]], part=part[loud[rows]])
        view = views_of(search.tracing, over)[1]
        left = np.abs(left_by_mirrors(search.tracing, over, view, np.array([search.wavenumber_1_m]))[:, 0])
        return (left > 0.0) & audible(left * bound[loud[rows]], strongest[at][loud[rows]])

    found, ok = unfolded(search, turns[loud], lambda: bound[loud], arrives)
    return replace(found, edge=wedge[loud[ok]], part=part[loud[ok]])


def _edge_pairs(search: Search) -> tuple[Pairs, Ints]:
    """Images of the speaker with those of a microphone at the same pose and edge, within the order, and (R,) edges.

    What a face on a mirror and its image diffract has that mirror before it or not: behind it, it would be the same.
    """
    tracing, max_order = search.tracing, search.max_order
    wedges, edges = tracing.world.wedges, _placed_edges(tracing)

    def images_of(point_m: Floats) -> EdgeImages:
        allowed = np.ones((max_order - 1, len(search.large_mirrors)), dtype=bool)
        allowed[1:] &= search.large_mirrors
        return images_lighting_edges(tracing.mirrors, wedges, *edges, allowed, point_m, search.audible.limit_m)

    def least_m(images: EdgeImages) -> Floats:
        start, end = (each[images.pose, images.wedge] for each in edges)
        return np.linalg.norm(images.point_m - 0.5 * (start + end), axis=1) - 0.5 * wedges.length_m[images.wedge]

    lit, parts, edge = images_of(tracing.source_m), [], []
    for mic in range(2):
        received = images_of(tracing.mics_m[:, mic])
        received = received[~_beside(received, wedges.mirror[received.wedge])]
        key, other = (each.pose * len(wedges) + each.wedge for each in (lit, received))
        left, right = matches(key, lit.order, other, received.order, max_order - 1)
        near = np.flatnonzero(least_m(lit)[left] + least_m(received)[right] <= search.limit_m)
        before, after = lit[left[near]], received[right[near]]
        keep = np.flatnonzero(_by_large_patches(search, before, after))
        parts.append(Pairs(np.full(len(keep), mic), before[keep], after[keep]))
        edge.append(before.wedge[keep])
    return joined_pairs(parts), np.concatenate(edge)


def _by_large_patches(search: Search, before: EdgeImages, after: EdgeImages) -> Flags:
    """(R,) whether all mirrors and a face of the edge are large, or there is one mirror at most.

    So it is for paths without edges: what a small patch reflects and what its borders diffract nearly cancel, and one
    of them alone is far too loud.
    """
    rows, large = np.flatnonzero(before.order + after.order > 1), np.append(search.large_mirrors, True)  # -1: curved
    met = np.concatenate([before.sequence[rows], after.sequence[rows]], axis=1)
    kept = np.ones(len(before), dtype=bool)
    kept[rows] = large[met].all(axis=1) & large[search.tracing.world.wedges.patch[before.wedge[rows]]].any(axis=1)
    return kept


def _beside(images: Images, mirror: Ints) -> Flags:
    """(I,) whether the last mirror of an image is a given one; never for -1."""
    last = images.sequence[np.arange(len(images)), images.order - 1] if images.sequence.shape[1] else images.order
    return (images.order > 0) & (mirror >= 0) & (last == mirror)


def _placed_edges(tracing: Tracing) -> tuple[Floats, Floats]:
    """(N, W, 3) starts and ends of all edges at all poses."""
    wedges, poses = tracing.world.wedges, len(tracing.pose)
    frame = tracing.placed[:, wedges.obstacle]
    shape = (poses, len(wedges), 3)
    return (
        np.ascontiguousarray(out_of_rest(np.broadcast_to(wedges.start_m, shape), frame)),
        np.ascontiguousarray(out_of_rest(np.broadcast_to(wedges.end_m, shape), frame)),
    )


def placed(tracing: Tracing, wedge: Ints, frame: Floats) -> Wedges:
    """(R,) edges in frames (R, 4) of their obstacles, world coordinates."""
    rest = tracing.world.wedges[wedge]
    return replace(
        rest, start_m=out_of_rest(rest.start_m, frame), end_m=out_of_rest(rest.end_m, frame),
        inwards=rotated(rest.inwards, frame[:, 3]), normal=rotated(rest.normal, frame[:, 3]),
    )  # fmt: skip


def at_poses(tracing: Tracing, wedge: Ints, pose: Ints) -> Wedges:
    """(R,) edges where they stand at poses (R,)."""
    return placed(tracing, wedge, tracing.placed[pose, tracing.world.wedges.obstacle[wedge]])


def seen(wedges: Wedges, source_m: Floats, receiver_m: Floats) -> EdgeView:
    """Cylindrical coordinates of sources and receivers (R, 3) about edges; angles beyond the open side lie inside."""
    coordinates = [_cylindrical(wedges, point) for point in (source_m, receiver_m)]
    return EdgeView(*coordinates[0], *coordinates[1], wedges.length_m, wedges.open_angle_rad)


def _cylindrical(wedges: Wedges, point_m: Floats) -> tuple[Floats, Floats, Floats]:
    """(R,) distance from the edge's line, angle from face 0 over its normal, height above the start."""
    along = (wedges.end_m - wedges.start_m) / wedges.length_m[:, None]
    offset = point_m - wedges.start_m
    x, y = np.sum(offset * wedges.inwards, axis=1), np.sum(offset * wedges.normal, axis=1)
    angle = np.mod(np.arctan2(y, x), 2.0 * np.pi)
    angle = np.where(2.0 * np.pi - angle < ON_FACE_RAD, 0.0, angle)
    beyond = angle - wedges.open_angle_rad
    angle = np.where((beyond > 0.0) & (beyond < ON_FACE_RAD), wedges.open_angle_rad, angle)
    return np.hypot(x, y), angle, np.sum(offset * along, axis=1)


def outside(wedges: Wedges, view: EdgeView) -> Flags:
    """(R,) whether source and receiver see the edge: in its open angle, and on this side of a thin plate."""
    turn = view.open_angle_rad
    rise = view.source_radius_m * np.sin(view.source_angle_rad)
    rise = rise + view.receiver_radius_m * np.sin(view.receiver_angle_rad)
    apart = np.minimum(view.source_radius_m, view.receiver_radius_m) > COINCIDENT_M
    return (view.source_angle_rad <= turn) & (view.receiver_angle_rad <= turn) & (rise + wedges.sheet_m > 0.0) & apart


def _contributions(search: Search, pairs: Pairs, wedge: Ints) -> tuple[Ints, Ints, Floats, Floats]:
    """What each pair of images receives of its edge: (R,) pair, (R,) part, (R, 3) point, (R,) bound of the gain."""
    wedges = at_poses(search.tracing, wedge, pairs.pose)
    view = seen(wedges, pairs.before.point_m, pairs.after.point_m)
    facing = np.flatnonzero(outside(wedges, view))
    wedges, view, pairs = wedges[facing], view[facing], pairs[facing]
    rows_of, parts, points, bounds = [], [], [], []
    for part in (APEX, START, END):
        which = np.full(len(view), part)
        there = _has(wedges, view, part) & _has_partner(wedges, pairs, part, search.max_order)
        rows = np.flatnonzero(there & (view.path_m(which) <= search.limit_m))
        rows_of.append(facing[rows])
        parts.append(which[rows])
        points.append(edge_points(wedges[rows], view[rows], part))
        bounds.append(strength_bound(view[rows], which[rows], search.wavenumber_1_m))
    return np.concatenate(rows_of), np.concatenate(parts), np.concatenate(points), np.concatenate(bounds)


def _has(wedges: Wedges, view: EdgeView, part: int) -> Flags:
    """(R,) whether an apex lies on its edge, or an end is one that radiates."""
    return view.has(part) if part == APEX else wedges.radiates[:, part - START]


def _has_partner(wedges: Wedges, pairs: Pairs, part: int, max_order: int) -> Flags:
    """(R,) whether an end that stands on a mirror comes with what nearly cancels it: the end of the edge's image.

    Its path has that mirror on both sides where this one has it on neither.
    """
    if part == APEX:
        return np.ones(len(wedges), dtype=bool)
    mirror = wedges.leans_on[:, part - START]
    neither = (mirror >= 0) & ~_beside(pairs.before, mirror) & ~_beside(pairs.after, mirror)
    return ~neither | (pairs.before.order + pairs.after.order + 3 <= max_order)


def diffracted_once(tracing: Tracing, wedge: Ints, pose: int, mic: int, wavenumber: Floats) -> Complexes:
    """(K,) what some rigid edges (E,) diffract alone at one pose, with its travel phase, whatever stands between."""
    every = np.full(len(wedge), pose)
    wedges = at_poses(tracing, wedge, every)
    view = seen(wedges, tracing.source_m[every], tracing.mics_m[every, mic])
    there = outside(wedges, view)
    total = np.zeros(len(wavenumber), dtype=np.complex128)
    for part in (APEX, START, END):
        some = view[np.flatnonzero(there & _has(wedges, view, part))]
        which = np.full(len(some), part)
        phase = np.exp(-1j * some.path_m(which)[:, None] * wavenumber)
        total += (edge_terms(some, which, wavenumber).sum(axis=1) * phase).sum(axis=0)
    return total


def edge_points(wedges: Wedges, view: EdgeView, part: int) -> Floats:
    """(R, 3) apex or end."""
    if part != APEX:
        return wedges.start_m if part == START else wedges.end_m
    share = view.apex_height_m / view.length_m
    return wedges.start_m + share[:, None] * (wedges.end_m - wedges.start_m)


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
