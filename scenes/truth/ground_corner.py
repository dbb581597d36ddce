"""Where an obstacle and the ground make a corner that echoes: the shortest path from a point to both and back.

A point and its image in the ground are the foci of ellipsoids; the smallest that touches the obstacle touches it where
sound that also meets the ground comes back first (Fermat). On an upright thing that is its foot; on one that leans it
is higher up. Each triangle is solved exactly: its inside by a mirror image, its edges by unfolding. No library at hand
solves this.
"""

from __future__ import annotations

import numba
import numpy as np
import trimesh
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Floats
from scenes.truth.nearest import spheres


def corner_points(mesh: trimesh.Trimesh, query_m: ArrayLike) -> Floats:
    """Points of a mesh with the least sum of distances to each of Q points and to its image in the plane z = 0.

    Args:
        mesh: any triangle mesh; degenerate triangles count as their edges.
        query_m: (Q, 3) points, m.

    Returns:
        (Q, 3) points, m.
    """
    query = np.atleast_2d(np.asarray(query_m, dtype=np.float64))
    return _corner_points(np.ascontiguousarray(mesh.triangles, dtype=np.float64), np.ascontiguousarray(query))


@numba.njit(cache=True, nogil=True)
def _corner_points(triangles: Floats, query: Floats) -> Floats:
    center, radius = spheres(triangles)
    result = np.empty_like(query)
    mirror = np.array([1.0, 1.0, -1.0])
    for q in range(len(query)):
        start, image = query[q], query[q] * mirror
        best = np.inf
        for f in range(len(triangles)):
            if _sum(center[f], start, image) - 2.0 * radius[f] > best:
                continue
            point = _least_on_triangle(triangles[f], start, image)
            total = _sum(point, start, image)
            if total < best:
                best = total
                result[q] = point
    return result


@numba.njit(cache=True, nogil=True)
def _least_on_triangle(corners: Floats, start: Floats, image: Floats) -> Floats:
    """Point of a triangle with the least sum of distances to two points."""
    ab, ac = corners[1] - corners[0], corners[2] - corners[0]
    normal = np.cross(ab, ac)
    area2 = normal @ normal
    if area2 > 0.0:
        inside = _where_crossed(corners[0], normal, start, image)
        at = inside - corners[0]
        s, t = np.cross(at, ac) @ normal, np.cross(ab, at) @ normal
        if s >= 0.0 and t >= 0.0 and s + t <= area2:
            return inside
    best = _least_on_edge(corners[0], corners[1], start, image)
    for i in range(1, 3):
        other = _least_on_edge(corners[i], corners[(i + 1) % 3], start, image)
        if _sum(other, start, image) < _sum(best, start, image):
            best = other
    return best


@numba.njit(cache=True, nogil=True)
def _where_crossed(corner: Floats, normal: Floats, start: Floats, image: Floats) -> Floats:
    """Where the shortest path between two points that touches a plane meets it; `normal` may have any length."""
    before, after = normal @ (start - corner), normal @ (image - corner)
    if before * after > 0.0:
        image = image - (2.0 * after / (normal @ normal)) * normal
    reach = abs(before) + abs(after)
    return start + (abs(before) / reach if reach > 0.0 else 0.0) * (image - start)


@numba.njit(cache=True, nogil=True)
def _least_on_edge(first: Floats, second: Floats, start: Floats, image: Floats) -> Floats:
    """Both points rotated about the edge into one plane: the straight line between them crosses it at the least sum."""
    edge = second - first
    length2 = edge @ edge
    if length2 == 0.0:
        return first
    along, along2 = (start - first) @ edge / length2, (image - first) @ edge / length2
    beside = _length(start - first - along * edge)
    beside2 = _length(image - first - along2 * edge)
    aside = beside + beside2
    where = along + (along2 - along) * (beside / aside) if aside > 0.0 else along
    return first + np.minimum(np.maximum(where, 0.0), 1.0) * edge


@numba.njit(cache=True, nogil=True)
def _sum(point: Floats, start: Floats, image: Floats) -> float:
    return _length(point - start) + _length(point - image)


@numba.njit(cache=True, nogil=True)
def _length(vector: Floats) -> float:
    return float(np.sqrt(vector @ vector))
