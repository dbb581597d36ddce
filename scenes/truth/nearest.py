"""Exact nearest points of triangle meshes, in float64, without an index and without large temporaries.

trimesh.proximity.closest_point can take gigabytes far from a fine surface; a walk asks some hundred questions of
meshes of some thousand triangles. Spheres around the triangles leave a few for each question, and those are solved
exactly, all at once.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Flags, Floats

MEETING_M = 1e-6
"""Faces that come so near to a point meet there."""
MOST_PAIRS = 2**17
"""Of questions and triangles at a time: 9 MB for their corners."""


def nearest_points(mesh: trimesh.Trimesh, query_m: ArrayLike) -> tuple[Floats, Floats]:
    """Nearest point of a mesh to each of Q points.

    Args:
        mesh: any triangle mesh; degenerate triangles count as their edges.
        query_m: (Q, 3) points, m.

    Returns:
        (Q, 3) nearest points and (Q,) distances, m.
    """
    query = np.atleast_2d(np.asarray(query_m, dtype=np.float64))
    point = points_of_least_length(np.asarray(mesh.triangles), query, _distance, 1.0, _nearest_on_triangle)
    return point, _distance(point, query)


def facing(mesh: trimesh.Trimesh, query_m: ArrayLike, within_rad: float) -> Flags:
    """(Q,) whether all faces that meet at a mesh's nearest point to each of (Q, 3) points face that point.

    Args:
        mesh: its faces' normals point outwards.
        query_m: (Q, 3) points, m.
        within_rad: greatest angle between a face's normal and the direction from the nearest point to the query.
    """
    query, triangles = np.atleast_2d(np.asarray(query_m, dtype=np.float64)), np.asarray(mesh.triangles)
    nearest, distance = nearest_points(mesh, query)
    toward = (query - nearest) / np.maximum(distance, np.finfo(float).tiny)[:, None]
    averted = np.asarray(mesh.face_normals) @ toward.T < np.cos(within_rad)
    center, radius = spheres(triangles)
    face, place = np.nonzero(averted & (_distance(center[:, None], nearest) <= radius[:, None] + MEETING_M))
    meets = _distance(_nearest_on_triangle(triangles[face], nearest[place]), nearest[place]) <= MEETING_M
    result = np.ones(len(query), dtype=bool)
    result[place[meets]] = False
    return result


def points_of_least_length(
    triangles: Floats,
    query: Floats,
    length_m: Callable[[Floats, Floats], Floats],
    slope: float,
    on_triangle: Callable[[Floats, Floats], Floats],
) -> Floats:
    """(Q, 3) points of triangles (F, 3, 3) where a length to each of (Q, 3) points is least.

    Args:
        triangles: corners of the triangles, m.
        query: the points asked about, m.
        length_m: of (..., 3) points of triangles and points asked about.
        slope: by how much at most the length changes over a metre.
        on_triangle: (P, 3) best points of each of (P, 3, 3) triangles for each of (P, 3) points.
    """
    (center, radius), result = spheres(triangles), np.empty_like(query)
    step = max(1, MOST_PAIRS // len(triangles))
    for asked in (slice(first, first + step) for first in range(0, len(query), step)):
        # A centre is a point of its triangle, so that the least is no longer than the length to any of them.
        at_center = length_m(center, query[asked, None])
        most = at_center.min(axis=1, keepdims=True) + MEETING_M
        place, face = np.nonzero(at_center - slope * radius <= most)
        point = on_triangle(triangles[face], query[asked][place])
        order = np.lexsort((length_m(point, query[asked][place]), place))
        result[asked] = point[order[np.unique(place, return_index=True)[1]]]
    return result


def spheres(triangles: Floats) -> tuple[Floats, Floats]:
    """(F, 3) centroids and (F,) radii of spheres around the triangles."""
    center = triangles.mean(axis=1)
    return center, np.linalg.norm(triangles - center[:, None], axis=2).max(axis=1)


def dot(a: Floats, b: Floats) -> Floats:
    """Inner products along the last axis."""
    product: Floats = np.einsum("...i,...i->...", a, b)
    return product


def _distance(a: Floats, b: Floats) -> Floats:
    apart = a - b
    return np.sqrt(dot(apart, apart))


def _nearest_on_triangle(corners: Floats, query: Floats) -> Floats:
    """(P, 3) points of triangles nearest to (P, 3) points: inside where those project there, else on an edge."""
    # Relative to the point, so that far from the origin no digits are lost in the inner products.
    a, b, c = np.moveaxis(corners - query[:, None], 1, 0)
    ab, ac = b - a, c - a
    uu, uv, vv = dot(ab, ab), dot(ab, ac), dot(ac, ac)
    pu, pv, area2 = -dot(a, ab), -dot(a, ac), uu * vv - uv * uv
    s, t = vv * pu - uv * pv, uu * pv - uv * pu
    inside = (area2 > 0.0) & (s >= 0.0) & (t >= 0.0) & (s + t <= area2)
    scale = np.where(inside, area2, 1.0)
    onto = a + (s / scale)[:, None] * ab + (t / scale)[:, None] * ac
    edges = np.stack([_nearest_on_edge(*ends) for ends in ((a, b), (b, c), (c, a))])
    edge = edges[dot(edges, edges).argmin(axis=0), np.arange(len(edges[0]))]
    return query + np.where(inside[:, None], onto, edge)


def _nearest_on_edge(a: Floats, b: Floats) -> Floats:
    """(P, 3) points of edges nearest to the origin."""
    edge = b - a
    length2 = dot(edge, edge)
    share = np.clip(-dot(a, edge) / np.where(length2 > 0.0, length2, 1.0), 0.0, 1.0)
    return a + share[:, None] * edge
