"""Facets cut where the corner of another one lies on their edge: no gap is there, yet neither finds its neighbour.

Modellers leave such places wherever one of two facets is cut, and where a sliver between them is dropped.
"""

from __future__ import annotations

import numpy as np
import trimesh

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.repeated import repeated
from obstaclewatch.support.vectors import dot, norm

MOST_ROUNDS = 256  # each cuts a facet once


def stitched(mesh: trimesh.Trimesh, within_m: float) -> trimesh.Trimesh:
    """A mesh whose facets are cut at corners that lie on their free edges; itself if there are none.

    Args:
        mesh: equal vertices merged, no facets without area.
        within_m: how far off an edge such a corner may lie.

    >>> square = trimesh.Trimesh([[0, 0, 0], [2, 0, 0], [1, 1, 0], [0, -1, 0], [2, -1, 0], [1, 0, 0]],
    ...                          [[0, 1, 2], [5, 0, 3], [5, 3, 4], [5, 4, 1]], process=False)
    >>> len(square.face_adjacency), len(stitched(square, 1e-5).face_adjacency)
    (2, 5)
    """
    for _ in range(MOST_ROUNDS):
        edge, vertex = _on_free_edges(mesh, within_m)
        if len(edge) == 0:
            break
        mesh = _cut(mesh, edge, vertex)
    return mesh


def _on_free_edges(mesh: trimesh.Trimesh, within_m: float) -> tuple[Ints, Ints]:
    """Edges, by their rows, that have one facet, and a corner of others on each: one edge a facet."""
    every, point = np.asarray(mesh.edges), np.asarray(mesh.vertices)
    _, which, count = np.unique(np.asarray(mesh.edges_sorted), axis=0, return_inverse=True, return_counts=True)
    free = np.flatnonzero(count[which.ravel()] == 1)
    row, vertex = _next_along(every[free])
    ends = point[every[free]]
    share, off_m, length_m = _beside(ends[row], point[vertex])
    inner = (off_m < within_m) & (np.minimum(share, 1.0 - share) * length_m > within_m)
    row, vertex, share = free[row[inner]], vertex[inner], share[inner]
    others = (mesh.faces[row // 3] != vertex[:, None]).all(axis=1)
    row, vertex, share = row[others], vertex[others], share[others]
    order = np.argsort(np.abs(share - 0.5), kind="stable")
    _, first = np.unique(row[order] // 3, return_index=True)
    chosen = order[first]
    return row[chosen], vertex[chosen]


def _next_along(edge: Ints) -> tuple[Ints, Ints]:
    """Pairs of free edges (E, 2) and corners to which another free edge leads from one of their ends.

    From the end of an uncut edge the first piece of the cut one beside it leads to the first corner on both.
    """
    start, to = np.concatenate([edge, edge[:, ::-1]]).T
    order = np.argsort(start, kind="stable")
    first, last = (np.searchsorted(start, start, side, sorter=order) for side in ("left", "right"))
    which, place = repeated(last - first)
    return which % max(len(edge), 1), to[order[first[which] + place]]


def _beside(ends_m: Floats, point_m: Floats) -> tuple[Floats, Floats, Floats]:
    """(K,) where beside edges (K, 2, 3) points lie, as a share of the length, how far off them, and the lengths."""
    along, to = ends_m[:, 1] - ends_m[:, 0], point_m - ends_m[:, 0]
    share = dot(to, along) / dot(along, along)
    return share, norm(to - share[:, None] * along), norm(along)


def _cut(mesh: trimesh.Trimesh, edge: Ints, vertex: Ints) -> trimesh.Trimesh:
    """The mesh with the facets of some edges, one each, cut in two from a vertex on that edge."""
    facet, side = np.divmod(edge, 3)
    start, end, apex = (mesh.faces[facet, (side + step) % 3] for step in range(3))
    faces = np.array(mesh.faces)
    faces[facet] = np.column_stack([start, vertex, apex])
    return trimesh.Trimesh(mesh.vertices, np.concatenate([faces, np.column_stack([vertex, end, apex])]), process=False)
