"""Where an obstacle and the ground make a corner that echoes: the shortest path from a point to both and back.

A point and its image in the ground are the foci of ellipsoids; the smallest that touches the obstacle touches it where
sound that also meets the ground comes back first (Fermat). On an upright thing that is its foot; on one that leans it
is higher up. Each triangle is solved exactly: its inside by a mirror image, its edges by unfolding. No library at hand
solves this.
"""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Floats
from scenes.truth.nearest import dot, points_of_least_length

MIRROR = np.array([1.0, 1.0, -1.0])


def corner_points(mesh: trimesh.Trimesh, query_m: ArrayLike) -> Floats:
    """Points of a mesh with the least sum of distances to each of Q points and to its image in the plane z = 0.

    Args:
        mesh: any triangle mesh; degenerate triangles count as their edges.
        query_m: (Q, 3) points, m.

    Returns:
        (Q, 3) points, m.
    """
    query = np.atleast_2d(np.asarray(query_m, dtype=np.float64))
    return points_of_least_length(np.asarray(mesh.triangles), query, _sum, 2.0, _least_on_triangle)


def _sum(point: Floats, start: Floats) -> Floats:
    """Of the distances to a start and to its image."""
    return _length(point - start) + _length(point - start * MIRROR)


def _least_on_triangle(corners: Floats, start: Floats) -> Floats:
    """(P, 3) points of triangles (P, 3, 3) with the least sum of distances to (P, 3) starts and their images."""
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, ac = b - a, c - a
    normal = np.cross(ab, ac)
    crossed = _where_crossed(a, normal, start, start * MIRROR)
    s, t = dot(np.cross(crossed - a, ac), normal), dot(np.cross(ab, crossed - a), normal)
    area2 = dot(normal, normal)
    inside = (area2 > 0.0) & (s >= 0.0) & (t >= 0.0) & (s + t <= area2)
    edges = np.stack([_least_on_edge(*ends, start, start * MIRROR) for ends in ((a, b), (b, c), (c, a))])
    edge = edges[_sum(edges, start).argmin(axis=0), np.arange(len(start))]
    return np.where(inside[:, None], crossed, edge)


def _where_crossed(corner: Floats, normal: Floats, start: Floats, image: Floats) -> Floats:
    """Where the shortest path between two points that touches a plane meets it; `normal` may have any length."""
    before, after = dot(normal, start - corner), dot(normal, image - corner)
    onto = _ratio(np.where(before * after > 0.0, 2.0 * after, 0.0), dot(normal, normal))
    image = image - onto[:, None] * normal
    return start + _ratio(abs(before), abs(before) + abs(after))[:, None] * (image - start)


def _least_on_edge(first: Floats, second: Floats, start: Floats, image: Floats) -> Floats:
    """Both points rotated about the edge into one plane: the straight line between them crosses it at the least sum."""
    edge = second - first
    length2 = dot(edge, edge)
    along, along2 = _ratio(dot(start - first, edge), length2), _ratio(dot(image - first, edge), length2)
    beside = _length(start - first - along[:, None] * edge)
    beside2 = _length(image - first - along2[:, None] * edge)
    where = along + (along2 - along) * _ratio(beside, beside + beside2)
    return first + np.clip(where, 0.0, 1.0)[:, None] * edge


def _ratio(part: Floats, total: Floats) -> Floats:
    """Their ratio; 0 of nothing."""
    return np.divide(part, total, out=np.zeros_like(part), where=total > 0.0)


def _length(vector: Floats) -> Floats:
    return np.sqrt(dot(vector, vector))
