"""Bodies that touch along edges, read apart again where a file has joined their vertices.

Of two blocks side by side four facets then meet on one edge, which no closed surface has. Round such an edge solid and
air alternate: the two facets that bound the same solid belong to one body.
"""

from __future__ import annotations

import numpy as np
import trimesh

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.distinct_rows import distinct
from obstaclewatch.support.vectors import dot, unit
from simulator.meshes.pieces import components, with_own_corners

FLUSH_RAD = 1e-5  # facets at angles that differ by less lie on one another


def read_apart(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy with vertices of its own for each body round an edge; the same mesh where it is not clear.

    It is not where a border is free, facets are wound against each other, or bodies overlap.
    """
    begin, end = mesh.faces.ravel(), np.roll(mesh.faces, -1, axis=1).ravel()
    side = np.column_stack([np.minimum(begin, end), np.maximum(begin, end)])
    edge = distinct(side)[1]
    one, other = _partners(mesh, side, edge, begin < end)
    if len(one) * 2 != len(begin):
        return mesh
    following = np.roll(np.arange(len(begin)).reshape(-1, 3), -1, axis=1).ravel()
    alike = np.concatenate([np.column_stack([one, following[other]]), np.column_stack([following[one], other])])
    return with_own_corners(mesh, components(alike, len(begin)))


def _partners(mesh: trimesh.Trimesh, side: Ints, edge: Ints, forth: Flags) -> tuple[Ints, Ints]:
    """Sides (S, 2) of facets that one body has on the same edge: (E,) those along it and (E,) those against it.

    Args:
        edge: (S,) which edge each is.
        forth: (S,) whether a facet runs along it.
    """
    order = np.lexsort((forth, edge))
    count = np.bincount(edge)
    start = np.cumsum(count) - count
    along = np.bincount(edge, forth, len(count)).astype(np.int64)
    fair = 2 * along == count
    plain = start[fair & (count == 2)]
    one, other = [order[plain + 1]], [order[plain]]
    for k in np.flatnonzero(fair & (count > 2)):
        some = order[start[k] : start[k] + count[k]]
        first, second = _round_an_edge(mesh, side[some[0]], some, forth[some])
        one.append(first)
        other.append(second)
    return np.concatenate(one), np.concatenate(other)


def _round_an_edge(mesh: trimesh.Trimesh, ends: Ints, some: Ints, forth: Flags) -> tuple[Ints, Ints]:
    """Sides (M,) of one edge, along it and against it, of facets that bound the same solid; none where they overlap.

    A facet that runs against the edge has its solid at larger angles round it, one that runs along it at smaller ones.
    """
    angle = _angles(mesh, ends, some)
    turn = np.argsort(angle)
    gap = np.diff(angle[turn], append=angle[turn[0]] + 2.0 * np.pi)
    turn, gap = np.roll(turn, -1 - int(gap.argmax())), np.roll(gap, -1 - int(gap.argmax()))
    place = np.concatenate([[0], np.cumsum(gap[:-1] > FLUSH_RAD)])
    turn = turn[np.lexsort((~forth[turn], place))]  # of facets that lie on one another solid ends before it begins
    turn = np.roll(turn, -int(forth[turn[0]]))
    if (forth[turn[1::2]] & ~forth[turn[::2]]).all():
        return some[turn[1::2]], some[turn[::2]]
    return some[:0], some[:0]


def _angles(mesh: trimesh.Trimesh, ends: Ints, some: Ints) -> Floats:
    """(M,) angles of facets round their edge, rad."""
    start, end = mesh.vertices[ends]
    along = unit(end - start)
    opposite = np.roll(mesh.faces, -2, axis=1).ravel()[some]
    out = mesh.vertices[opposite] - start
    across = unit(out[0] - dot(out[0], along) * along)
    return np.arctan2(dot(out, np.cross(along, across)), dot(out, across))
