"""Bounds of facets, and of groups of neighbours with like normals, that tell which cannot mirror two points.

Where a surface is straight along some direction, as a cylinder or a cone, both legs rise alike along it, and the
problem is that of the plane across: there a facet as long as its post is as small as it is narrow, and the phone is
never within the ball round it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numba
import numpy as np
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Floats, Ints

LEAF = 12  # facets a group at most; measured fastest between 8 and 24 on a body of 5,000 facets
STRAIGHT = 0.03  # sine of the most by which normals may lean along a direction that counts as straight
LONG = 3.0  # so much longer than wide a cell must be for it to matter that it is straight
ROUNDING = 1e-9


class Cells(NamedTuple):
    """Bounds of C pieces of a surface; compiled functions take it whole.

    Attributes:
        center_m: (C, 3).
        radius_m: (C,) of the ball round each piece or, of a straight one, of the cylinder round it.
        axis: (C, 3) middle of its normals.
        spread_cos, spread_sin: (C,) of the greatest angle of a normal from the axis.
        straight: (C, 3) unit direction along which it is straight, 0 without one.
        lean: (C,) sine of the most by which its normals lean along that direction.
    """

    center_m: Floats
    radius_m: Floats
    axis: Floats
    spread_cos: Floats
    spread_sin: Floats
    straight: Floats
    lean: Floats


@dataclass(frozen=True)
class Clusters:
    """Facets in groups.

    Attributes:
        facet: (T,) facets in the order of the groups.
        start: (G + 1,) where each group begins in `facet`.
        groups, facets: bounds of each group and, in their own order, of each facet.
    """

    facet: Ints
    start: Ints
    groups: Cells
    facets: Cells


def clusters(corner_m: Floats, normal: Floats, sag_m: Floats) -> Clusters:
    """Group T facets from their corners (T, 3, 3), corner normals (T, 3, 3) and bulges (T,)."""
    center = corner_m.mean(axis=1)
    extent = max(float(np.ptp(center, axis=0).max(initial=0.0)), 1e-9)
    place = np.concatenate([center / extent, normal.mean(axis=1)], axis=1)
    facet, start = leaves(place, LEAF)
    each = np.arange(len(corner_m) + 1)
    along = _straight_edges(corner_m, normal)
    facets = _cells(corner_m, normal, sag_m, each, along)
    groups = _cells(corner_m[facet], normal[facet], sag_m[facet], start, _shared(facets.straight[facet], start))
    return Clusters(facet, start, groups, facets)


def leaves(place: Floats, most: int) -> tuple[Ints, Ints]:
    """Facets at places (T, D) in groups of `most` at most, group by group, and where each group begins."""
    tree = cKDTree(place, leafsize=most, compact_nodes=False, balanced_tree=False)
    nodes, ends = [tree.tree], []
    while nodes:
        node = nodes.pop()
        if node.split_dim == -1:
            ends.append((node.start_idx, node.end_idx))
        else:
            nodes += [node.greater, node.lesser]
    start = np.array([first for first, _ in ends] + [ends[-1][1]], dtype=np.int64)
    return tree.indices.astype(np.int64), start


def _cells(corner_m: Floats, normal: Floats, sag_m: Floats, start: Ints, along: Floats) -> Cells:
    """Bounds of pieces of facets in turn, each from `start` to the next; `along` (C, 3) may be straight."""
    piece = np.repeat(np.arange(len(start) - 1), np.diff(start))
    low = np.minimum.reduceat(corner_m.min(axis=1), start[:-1])
    high = np.maximum.reduceat(corner_m.max(axis=1), start[:-1])
    center = 0.5 * (low + high)
    away = corner_m - center[piece][:, None]
    across = away - np.einsum("tcx,tx->tc", away, along[piece])[:, :, None] * along[piece][:, None]
    radius, width = (
        np.maximum.reduceat(np.linalg.norm(vector, axis=2).max(axis=1) + sag_m, start[:-1]) for vector in (away, across)
    )
    lean = np.maximum.reduceat(np.abs(np.einsum("tcx,tx->tc", normal, along[piece])).max(axis=1), start[:-1])
    straight = along.any(axis=1) & (lean <= STRAIGHT) & (radius > LONG * width)
    along = straight[:, None] * along
    axis, cosine, sine = _cones(_across(normal, along[piece]), start, piece)
    return Cells(center, np.where(straight, width, radius), axis, cosine, sine, along, np.where(straight, lean, 0.0))


def _across(vector: Floats, along: Floats) -> Floats:
    """(T, 3, 3) unit vectors without their parts along (T, 3) directions."""
    across = vector - np.einsum("tcx,tx->tc", vector, along)[:, :, None] * along[:, None]
    return across / np.linalg.norm(across, axis=2, keepdims=True)


def _cones(normal: Floats, start: Ints, piece: Ints) -> tuple[Floats, Floats, Floats]:
    """Mean normals, and cosines and sines of the angle of the one that leans away most; -1, 0 where they cancel."""
    total = np.add.reduceat(normal.sum(axis=1), start[:-1])
    size = np.linalg.norm(total, axis=1)
    axis = total / np.maximum(size, 1e-300)[:, None]
    most = np.minimum.reduceat(np.einsum("tcx,tx->tc", normal, axis[piece]).min(axis=1), start[:-1])
    cosine = np.where(size > 1e-6, np.clip(most, -1.0, 1.0), -1.0)
    return axis, cosine, np.sqrt(1.0 - cosine**2)


def _straight_edges(corner_m: Floats, normal: Floats) -> Floats:
    """(T, 3) unit direction of the edge of each facet along which its normals lean least."""
    edge = corner_m[:, [1, 2, 0]] - corner_m
    edge /= np.linalg.norm(edge, axis=2, keepdims=True)
    lean = np.abs(np.einsum("tex,tcx->tec", edge, normal)).max(axis=2)
    return edge[np.arange(len(edge)), np.argmin(lean, axis=1)]


def _shared(straight: Floats, start: Ints) -> Floats:
    """(G, 3) mean straight direction of each group, whatever the sign; 0 where some facet has none."""
    first = np.repeat(straight[start[:-1]], np.diff(start), axis=0)
    sign = np.where(np.sum(straight * first, axis=1) < 0.0, -1.0, 1.0)
    total = np.add.reduceat(sign[:, None] * straight, start[:-1])
    every = np.logical_and.reduceat(straight.any(axis=1), start[:-1])
    return every[:, None] * total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300)


@numba.njit(cache=True)
def may_mirror(cells, c, closed, source, receiver):
    """Whether some normal of a piece may halve the angle between the ways to both points, on the side of both.

    Within a ball the unit vector to a point turns by asin(radius / distance) at most and changes by the chord of that
    angle; the sum of two, along the bisector, changes by both chords. At grazing incidence this sum is short, and
    turns by far more than the vectors themselves.
    """
    center, straight, axis = cells.center_m, cells.straight, cells.axis
    radius, cosine, sine = cells.radius_m[c], cells.spread_cos[c], cells.spread_sin[c]
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
    lean = cells.lean[c] * abs(rise_s - rise_r) / max(to_s + to_r - 2.0 * radius, 1e-300) + ROUNDING
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


@numba.njit(cache=True, inline="always")
def _side(along, turn_sine, turn_cosine, cosine, sine, lean):
    """1 if a point is in front of every tangent plane of a piece, -1 if behind all, 0 if neither is sure."""
    if cosine * turn_cosine <= sine * turn_sine:
        return 0
    reach = sine * turn_cosine + cosine * turn_sine + lean
    return 1 if along > reach else -1 if along < -reach else 0
