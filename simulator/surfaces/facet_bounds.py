"""Bounds of facets, and of groups of neighbours with like normals, that tell which cannot mirror two points.

Where a surface is straight along some direction, as a cylinder or a cone, both segments rise alike along it, and the
problem is that of the plane across: there a facet as long as its post is as small as it is narrow, and the phone is
never within the ball round it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.compiled import inlined
from obstaclewatch.support.compiled_vectors import dot
from obstaclewatch.support.vectors import norm

SIZES = (768, 96, 12)  # facets that a piece of each level holds at most; within a tenth of the fastest on 128-20,480
STRAIGHT = 0.03  # sine of the most by which normals may lean along a direction that counts as straight
LONG = 3.0  # so much longer than wide a piece must be for it to matter that it is straight
ROUNDING = 1e-9


class Pieces(NamedTuple):
    """Bounds of C pieces of a surface; compiled functions take it whole.

    Attributes:
        center_m: (C, 3).
        ball_m: (C,) radius of the ball round each piece.
        radius_m: (C,) the same or, of a straight piece, that of the cylinder round it.
        axis: (C, 3) middle of its normals.
        spread_cos, spread_sin: (C,) of the greatest angle of a normal from the axis.
        straight: (C, 3) unit direction along which it is straight, 0 without one.
        lean: (C,) sine of the most by which its normals lean along that direction.
    """

    center_m: Floats
    ball_m: Floats
    radius_m: Floats
    axis: Floats
    spread_cos: Floats
    spread_sin: Floats
    straight: Floats
    lean: Floats


@dataclass(frozen=True)
class Clusters:
    """Facets in groups of groups: M pieces of a surface in turn, each before the pieces that it is made of.

    Attributes:
        bounds: of every piece.
        facet: (M,) the facet that a piece is, -1 for groups.
        after: (M,) the first piece that is no part of this one.
        spot_m: (G, 3) middles of the smallest groups.
    """

    bounds: Pieces
    facet: Ints
    after: Ints
    spot_m: Floats


def clusters(corner_m: Floats, normal: Floats, sag_m: Floats) -> Clusters:
    """Group T facets from their corners (T, 3, 3), corner normals (T, 3, 3) and bulges (T,)."""
    center = corner_m.mean(axis=1)
    extent = max(float(np.ptp(center, axis=0).max(initial=0.0)), 1e-9)
    facet, *starts = nested_leaves(np.concatenate([center / extent, normal.mean(axis=1)], axis=1), SIZES)
    corner_m, normal, sag_m = corner_m[facet], normal[facet], sag_m[facet]
    facets = _pieces(corner_m, normal, sag_m, np.arange(len(facet) + 1), _straight_edges(corner_m, normal))
    levels = [_pieces(corner_m, normal, sag_m, start, _shared(facets.straight, start)) for start in starts] + [facets]
    starts.append(np.arange(len(facet) + 1))
    first, last = (np.concatenate([start[side] for start in starts]) for side in (slice(-1), slice(1, None)))
    level = np.repeat(np.arange(len(starts)), [len(start) - 1 for start in starts])
    order = np.lexsort((level, first))
    alike = (np.diff(first[order]) == 0) & (np.diff(last[order]) == 0)  # a piece made of a single piece
    order = order[np.concatenate([~alike, [True]])]
    return Clusters(
        Pieces(*(np.concatenate(column)[order] for column in zip(*levels, strict=True))),
        np.where(level[order] == len(SIZES), facet[first[order]], -1),
        np.searchsorted(first[order], last[order]), levels[-2].center_m,
    )  # fmt: skip


def leaves(place: Floats, most: int) -> tuple[Ints, Ints]:
    """Facets at places (T, D) in groups of `most` at most, group by group, and where each group begins."""
    facet, start = nested_leaves(place, (most,))
    return facet, start


def nested_leaves(place: Floats, sizes: tuple[int, ...]) -> list[Ints]:
    """Facets at places (T, D) in groups within groups of at most so many, and for each size where the groups begin."""
    tree = cKDTree(place, leafsize=sizes[-1], compact_nodes=False, balanced_tree=False)
    starts: list[list[int]] = [[] for _ in sizes]
    nodes = [(tree.tree, len(place) + sizes[0] + 1)]
    while nodes:
        node, above = nodes.pop()
        size = node.end_idx - node.start_idx
        for start, most in zip(starts, sizes, strict=True):
            if size <= most < above:
                start.append(node.start_idx)
        if node.split_dim != -1:
            nodes += [(node.greater, size), (node.lesser, size)]
    return [tree.indices.astype(np.int64)] + [np.array([*start, len(place)], dtype=np.int64) for start in starts]


def _pieces(corner_m: Floats, normal: Floats, sag_m: Floats, start: Ints, along: Floats) -> Pieces:
    """Bounds of pieces of facets in turn, each from `start` to the next; `along` (C, 3) may be straight."""
    piece = np.repeat(np.arange(len(start) - 1), np.diff(start))
    low = np.minimum.reduceat(corner_m.min(axis=1), start[:-1])
    high = np.maximum.reduceat(corner_m.max(axis=1), start[:-1])
    center = 0.5 * (low + high)
    away = corner_m - center[piece][:, None]
    across = away - np.einsum("tcx,tx->tc", away, along[piece])[:, :, None] * along[piece][:, None]
    radius, width = (np.maximum.reduceat(norm(vector).max(axis=1) + sag_m, start[:-1]) for vector in (away, across))
    lean = np.maximum.reduceat(np.abs(np.einsum("tcx,tx->tc", normal, along[piece])).max(axis=1), start[:-1])
    straight = along.any(axis=1) & (lean <= STRAIGHT) & (radius > LONG * width)
    along = straight[:, None] * along
    axis, cosine, sine = _cones(_across(normal, along[piece]), start, piece)
    width = np.where(straight, width, radius)
    return Pieces(center, radius, width, axis, cosine, sine, along, np.where(straight, lean, 0.0))


def _across(vector: Floats, along: Floats) -> Floats:
    """(T, 3, 3) unit vectors without their parts along (T, 3) directions."""
    across = vector - np.einsum("tcx,tx->tc", vector, along)[:, :, None] * along[:, None]
    return across / norm(across)[..., None]


def _cones(normal: Floats, start: Ints, piece: Ints) -> tuple[Floats, Floats, Floats]:
    """Mean normals, and cosines and sines of the angle of the one that leans away most; -1, 0 where they cancel."""
    total = np.add.reduceat(normal.sum(axis=1), start[:-1])
    size = norm(total)
    axis = total / np.maximum(size, 1e-300)[:, None]
    most = np.minimum.reduceat(np.einsum("tcx,tx->tc", normal, axis[piece]).min(axis=1), start[:-1])
    cosine = np.where(size > 1e-6, np.clip(most, -1.0, 1.0), -1.0)
    return axis, cosine, np.sqrt(1.0 - cosine**2)


def _straight_edges(corner_m: Floats, normal: Floats) -> Floats:
    """(T, 3) unit direction of the edge of each facet along which its normals lean least."""
    edge = corner_m[:, [1, 2, 0]] - corner_m
    edge /= norm(edge)[..., None]
    lean = np.abs(np.einsum("tex,tcx->tec", edge, normal)).max(axis=2)
    return edge[np.arange(len(edge)), np.argmin(lean, axis=1)]


def _shared(straight: Floats, start: Ints) -> Floats:
    """(G, 3) mean straight direction of each group, whatever the sign; 0 where some facet has none."""
    first = np.repeat(straight[start[:-1]], np.diff(start), axis=0)
    sign = np.where(np.sum(straight * first, axis=1) < 0.0, -1.0, 1.0)
    total = np.add.reduceat(sign[:, None] * straight, start[:-1])
    every = np.logical_and.reduceat(straight.any(axis=1), start[:-1])
    return every[:, None] * total / np.maximum(norm(total)[..., None], 1e-300)


@inlined
def beyond(half_space, center, radius):
    """Whether a ball lies outside some of (K, 4) half-spaces."""
    outside = False
    for k in range(len(half_space)):
        outside = outside or dot(half_space[k], center) - half_space[k, 3] < -radius
    return outside


@inlined
def may_mirror(pieces, c, closed, source, receiver):
    """Whether some normal of a piece may halve the angle between the lines to both points, on the side of both.

    Within a ball the unit vector to a point turns by asin(radius / distance) at most and changes by the chord of that
    angle; the sum of two, along the bisector, changes by both chords. At grazing incidence this sum is short, and
    turns by far more than the vectors themselves.
    """
    center, straight, axis = pieces.center_m, pieces.straight, pieces.axis
    radius, cosine, sine = pieces.radius_m[c], pieces.spread_cos[c], pieces.spread_sin[c]
    rise_s = rise_r = 0.0
    for k in range(3):
        rise_s += (source[k] - center[c, k]) * straight[c, k]
        rise_r += (receiver[k] - center[c, k]) * straight[c, k]
    to_s = to_r = product = along_s = along_r = 0.0
    for k in range(3):
        s = source[k] - center[c, k] - rise_s * straight[c, k]
        r = receiver[k] - center[c, k] - rise_r * straight[c, k]
        to_s, to_r, product = to_s + s * s, to_r + r * r, product + s * r
        along_s, along_r = along_s + s * axis[c, k], along_r + r * axis[c, k]
    to_s, to_r = np.sqrt(to_s), np.sqrt(to_r)
    if to_s <= radius or to_r <= radius or cosine <= 0.0:
        return True
    along_s, along_r = along_s / to_s, along_r / to_r
    sine_s, sine_r = radius / to_s, radius / to_r
    cosine_s, cosine_r = np.sqrt(1.0 - sine_s * sine_s), np.sqrt(1.0 - sine_r * sine_r)
    lean = pieces.lean[c] * abs(rise_s - rise_r) / max(to_s + to_r - 2.0 * radius, 1e-300) + ROUNDING
    side_s = _side(along_s, sine_s, cosine_s, cosine, sine, lean)
    side_r = _side(along_r, sine_r, cosine_r, cosine, sine, lean)
    if side_s * side_r < 0 or (closed and min(side_s, side_r) < 0):
        return False
    size = np.sqrt(max(2.0 + 2.0 * product / (to_s * to_r), 0.0))
    change = sine_s * np.sqrt(2.0 / (1.0 + cosine_s)) + sine_r * np.sqrt(2.0 / (1.0 + cosine_r)) + lean * size
    if change >= size:
        return True
    along, turn = (along_s + along_r) / size, change / size
    if not closed:
        along = abs(along)
    return along >= cosine * np.sqrt(1.0 - turn * turn) - sine * turn - ROUNDING


@inlined
def _side(along, turn_sine, turn_cosine, cosine, sine, lean):
    """1 if a point is in front of every tangent plane of a piece, -1 if behind all, 0 if neither is sure."""
    if cosine * turn_cosine <= sine * turn_sine:
        return 0
    reach = sine * turn_cosine + cosine * turn_sine + lean
    return 1 if along > reach else -1 if along < -reach else 0
