"""Normals and curvatures at the vertices of the smooth pieces of a mesh, by the best means that each piece allows.

A sphere, cylinder or cone is recognised as such; elsewhere a quadric is fitted round each vertex; a vertex that no
quadric fits takes the mean of what the facets round it show.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import dot, norm
from simulator.surfaces.round_bodies import recognised
from simulator.surfaces.vertex_fits import fit_quadrics, rings

LONG = 4.0  # an edge so many times longer than its vertex's shortest runs along a straight line of the surface


def vertex_geometry(
    point_m: Floats, facet: Ints, facet_normal: Floats, mean_normal: Floats, held: Flags
) -> tuple[Floats, Floats]:
    """(V, 3) unit normals and (V, 3, 3) curvature tensors, dn = K dx, 1/m, at the vertices of smooth pieces.

    Args:
        point_m: (V, 3) vertices, split at creases.
        facet: (T, 3) vertices of the facets.
        facet_normal: (T, 3).
        mean_normal: (V, 3) first estimate, on the side to stay on.
        held: (V,) whether that estimate is exact (the vertex belongs to a flat panel as well).
    """
    pairs = facet[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    held_slope = held | _on_strip(pairs, len(point_m))
    normal, curvature, true = fit_quadrics(point_m, mean_normal, held_slope, rings(pairs, len(point_m)))
    normal = np.where((true | held_slope)[:, None], normal, _across_long_edges(point_m, pairs, normal, mean_normal))
    refused = np.isnan(curvature[:, 0, 0])
    if refused.any():
        curvature[refused] = _mean_curvature(point_m, facet, normal)[refused]
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(point_m), len(point_m)))
    count, piece = connected_components(graph, directed=False)
    for label in range(count):
        rows = np.flatnonzero(piece == label)
        body = None if held[rows].any() else recognised(point_m[rows], facet_normal[piece[facet[:, 0]] == label])
        if body is not None:
            side = np.sign(dot(body[0], mean_normal[rows]))
            normal[rows], curvature[rows] = side[:, None] * body[0], side[:, None, None] * body[1]
    return normal, curvature


def _on_strip(pairs: Ints, count: int) -> Flags:
    """(count,) vertices that, like all their neighbours, lie on a rim: nothing tells the slope across the strip."""
    edge, used = np.unique(np.sort(pairs, axis=1), axis=0, return_counts=True)
    rim = np.zeros(count, dtype=bool)
    rim[edge[used == 1].ravel()] = True
    strip = rim.copy()
    for a, b in (edge.T, edge.T[::-1]):
        strip[a[~rim[b]]] = False
    return strip


def _across_long_edges(point_m: Floats, pairs: Ints, normal: Floats, mean_normal: Floats) -> Floats:
    """(V, 3) mean normals rotated to be at right angles to each vertex's longest edge, where that is much its longest.

    The other normals stay. Where a ball runs into a long fillet no quadric fits, and a small tilt would belly the
    fillet's long facets; meshes have long edges where the surface is straight along them.
    """
    both = np.concatenate([pairs, pairs[:, ::-1]])
    edge = point_m[both[:, 1]] - point_m[both[:, 0]]
    length = norm(edge)
    order = np.lexsort((length, both[:, 0]))
    last = np.searchsorted(both[order, 0], np.arange(len(point_m)), "right") - 1
    first = np.searchsorted(both[order, 0], np.arange(len(point_m)), "left")
    longest, shortest = order[last], order[first]
    along = edge[longest] / length[longest, None]
    rotated = mean_normal - dot(mean_normal, along)[..., None] * along
    rotated /= norm(rotated)[..., None]
    return np.where((length[longest] > LONG * length[shortest])[:, None], rotated, normal)


def _mean_curvature(point_m: Floats, facet: Ints, normal: Floats) -> Floats:
    """(V, 3, 3) mean over the facets round each vertex of the tensor that turns edges into changes of the normal."""
    edge = point_m[facet[:, [1, 2, 0]]] - point_m[facet]
    turn = normal[facet[:, [1, 2, 0]]] - normal[facet]
    tensor = np.einsum("tki,tkj->tij", turn, np.linalg.pinv(edge).transpose(0, 2, 1))
    total = np.zeros((len(point_m), 3, 3))
    np.add.at(total, facet.ravel(), np.repeat(0.5 * (tensor + tensor.transpose(0, 2, 1)), 3, axis=0))
    total /= np.maximum(np.bincount(facet.ravel(), minlength=len(point_m)), 1)[:, None, None]
    onto = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    return onto @ total @ onto
