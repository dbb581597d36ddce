"""Exact nearest points of triangle meshes, in float64, without an index and without large temporaries.

trimesh.proximity.closest_point can take gigabytes far from a fine surface; a walk asks some hundred questions of
meshes of some thousand triangles, for which the plain double loop is both exact and fast.
"""

from __future__ import annotations

import numba
import numpy as np
import trimesh
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Flags, Floats

TOUCHING_M = 1e-6
"""Faces that come so near to a point meet there."""


def nearest_points(mesh: trimesh.Trimesh, query_m: ArrayLike) -> tuple[Floats, Floats]:
    """Nearest point of a mesh to each of Q points.

    Args:
        mesh: any triangle mesh; degenerate triangles count as their edges.
        query_m: (Q, 3) points, m.

    Returns:
        (Q, 3) nearest points and (Q,) distances, m.
    """
    query = np.atleast_2d(np.asarray(query_m, dtype=np.float64))
    triangles = np.ascontiguousarray(mesh.triangles, dtype=np.float64)
    offset = _nearest_offsets(triangles, np.ascontiguousarray(query))
    return query + offset, np.linalg.norm(offset, axis=1)


def facing(mesh: trimesh.Trimesh, query_m: ArrayLike, within_rad: float) -> Flags:
    """(Q,) whether all faces that meet at a mesh's nearest point to each of (Q, 3) points face that point.

    Args:
        mesh: its faces' normals point outwards.
        query_m: (Q, 3) points, m.
        within_rad: greatest angle between a face's normal and the direction from the nearest point to the query.
    """
    query = np.atleast_2d(np.asarray(query_m, dtype=np.float64))
    nearest, distance = nearest_points(mesh, query)
    toward = (query - nearest) / np.maximum(distance, np.finfo(float).tiny)[:, None]
    triangles = np.ascontiguousarray(mesh.triangles, dtype=np.float64)
    return _facing(triangles, np.asarray(mesh.face_normals, dtype=np.float64), nearest, toward, np.cos(within_rad))


@numba.njit(cache=True, nogil=True)
def _facing(triangles: Floats, normals: Floats, nearest: Floats, toward: Floats, cosine: float) -> Flags:
    center, radius = spheres(triangles)
    result = np.ones(len(nearest), dtype=np.bool_)
    for q in range(len(nearest)):
        x, y, z = nearest[q]
        for f in range(len(triangles)):
            if _length(center[f, 0] - x, center[f, 1] - y, center[f, 2] - z) > radius[f] + TOUCHING_M:
                continue
            a, b, c = triangles[f, 0] - nearest[q], triangles[f, 1] - nearest[q], triangles[f, 2] - nearest[q]
            offset = _nearest_to_origin(a, b, c)
            if _dot(offset, offset) <= TOUCHING_M**2 and _dot(normals[f], toward[q]) < cosine:
                result[q] = False
                break
    return result


@numba.njit(cache=True, nogil=True)
def _nearest_offsets(triangles: Floats, query: Floats) -> Floats:
    """(Q, 3) vectors from each query point to the nearest point of the triangles (F, 3, 3).

    Spheres around the triangles first say how far the nearest can be, then which triangles can be that near.
    """
    center, radius = spheres(triangles)
    result = np.empty_like(query)
    for q in range(len(query)):
        x, y, z = query[q]
        bound, best = np.inf, np.inf
        for f in range(len(triangles)):
            bound = min(bound, _length(center[f, 0] - x, center[f, 1] - y, center[f, 2] - z) + radius[f])
        bound *= 1.0 + 1e-12
        for f in range(len(triangles)):
            if _length(center[f, 0] - x, center[f, 1] - y, center[f, 2] - z) - radius[f] > min(bound, best):
                continue
            # Relative to the query point, so that far from the origin no digits are lost in the dot products.
            a, b, c = triangles[f, 0] - query[q], triangles[f, 1] - query[q], triangles[f, 2] - query[q]
            offset = _nearest_to_origin(a, b, c)
            distance = np.sqrt(_dot(offset, offset))
            if distance < best:
                best = distance
                result[q] = offset
    return result


@numba.njit(cache=True, nogil=True)
def spheres(triangles: Floats) -> tuple[Floats, Floats]:
    """(F, 3) centroids and (F,) radii of spheres around the triangles."""
    center, radius = np.empty((len(triangles), 3)), np.empty(len(triangles))
    for f in range(len(triangles)):
        center[f] = (triangles[f, 0] + triangles[f, 1] + triangles[f, 2]) / 3.0
        radius[f] = 0.0
        for i in range(3):
            offset = triangles[f, i] - center[f]
            radius[f] = max(radius[f], np.sqrt(_dot(offset, offset)))
    return center, radius


@numba.njit(cache=True, nogil=True)
def _length(x: float, y: float, z: float) -> float:
    return np.sqrt(x * x + y * y + z * z)


@numba.njit(cache=True, nogil=True)
def _nearest_to_origin(a: Floats, b: Floats, c: Floats) -> Floats:
    """Point of the triangle abc nearest to the origin: its inside if the origin projects there, else its edges."""
    ab, ac = b - a, c - a
    uu, uv, vv = _dot(ab, ab), _dot(ab, ac), _dot(ac, ac)
    area2 = uu * vv - uv * uv
    pu, pv = -_dot(a, ab), -_dot(a, ac)
    s, t = vv * pu - uv * pv, uu * pv - uv * pu
    if area2 > 0.0 and s >= 0.0 and t >= 0.0 and s + t <= area2:
        return a + (s / area2) * ab + (t / area2) * ac
    best = _nearest_on_edge(a, b)
    for candidate in (_nearest_on_edge(b, c), _nearest_on_edge(c, a)):
        if _dot(candidate, candidate) < _dot(best, best):
            best = candidate
    return best


@numba.njit(cache=True, nogil=True)
def _nearest_on_edge(a: Floats, b: Floats) -> Floats:
    edge = b - a
    length2 = _dot(edge, edge)
    if length2 == 0.0:
        return a
    return a + min(max(-_dot(a, edge) / length2, 0.0), 1.0) * edge


@numba.njit(cache=True, nogil=True)
def _dot(a: Floats, b: Floats) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
