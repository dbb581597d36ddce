"""How deep one mesh reaches into another, and what lies inside a mesh.

Inside is where the generalised winding number exceeds a half (Jacobson et al. 2013, ACM Trans. Graph. 32(4):33): for a
closed mesh that is the usual inside, for one with a hole nearly so, and it does not mind parts that run into each
other, nor normals that point inwards. `trimesh.Trimesh.contains` counts the crossings of a ray instead and errs where
parts overlap; crossings of edges stay here because Embree's are in single precision.
"""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled
from scenes.truth.nearest import nearest_points


def inside(mesh: trimesh.Trimesh, point_m: ArrayLike) -> Flags:
    """(Q,) whether each of (Q, 3) points lies inside a mesh."""
    points = np.ascontiguousarray(np.atleast_2d(np.asarray(point_m, dtype=np.float64)))
    found = np.zeros(len(points), dtype=bool)
    low, high = mesh.bounds
    near = np.flatnonzero(((points > low) & (points < high)).all(axis=1))
    triangles = np.ascontiguousarray(mesh.triangles, dtype=np.float64)
    found[near] = np.abs(winding_number(triangles, points[near])) > 0.5
    return found


def overlap_depth(one: trimesh.Trimesh, other: trimesh.Trimesh) -> float:
    """How far inside one mesh the other reaches, m, whichever is the other; 0 if they are apart or only touch.

    Vertices, middles of triangles, and the middles of the stretches of edges that run inside are asked how far they
    are from the surface; a point elsewhere may lie deeper. Two open sheets that cross have no inside and give 0.
    """
    if (one.bounds[0] >= other.bounds[1]).any() or (other.bounds[0] >= one.bounds[1]).any():
        return 0.0
    return max(_depth_in(one, other), _depth_in(other, one))


def _depth_in(host: trimesh.Trimesh, guest: trimesh.Trimesh) -> float:
    """How far inside the host the guest's edges and triangles reach, m."""
    edges = np.asarray(guest.vertices)[guest.edges_unique]
    low, high = host.bounds
    edges = edges[((edges.min(axis=1) < high) & (edges.max(axis=1) > low)).all(axis=1)]
    triangles = np.asarray(host.triangles)
    near = ((triangles.min(axis=1) < guest.bounds[1]) & (triangles.max(axis=1) > guest.bounds[0])).all(axis=1)
    edge, share = _crossings(np.ascontiguousarray(edges), np.ascontiguousarray(triangles[near]))
    points = np.concatenate([edges.reshape(-1, 3), _between_crossings(edges, edge, share), guest.triangles_center])
    buried = points[inside(host, points)]
    return 0.0 if len(buried) == 0 else float(nearest_points(host, buried)[1].max())


def _between_crossings(edges: Floats, edge: Ints, share: Floats) -> Floats:
    """(K, 3) middles of the stretches of every edge between its ends and its crossings."""
    numbers = np.arange(len(edges))
    every = np.concatenate([edge, numbers, numbers])
    at = np.concatenate([share, np.zeros(len(edges)), np.ones(len(edges))])
    order = np.lexsort((at, every))
    every, at = every[order], at[order]
    same = every[1:] == every[:-1]
    middle = 0.5 * (at[1:] + at[:-1])[same]
    start, end = edges[every[:-1][same], 0], edges[every[:-1][same], 1]
    points: Floats = start + middle[:, None] * (end - start)
    return points


@compiled
def winding_number(triangles: Floats, points: Floats) -> Floats:
    """(Q,) signed solid angle of all triangles (F, 3, 3) over 4 pi (Van Oosterom and Strackee 1983): 1 inside."""
    total = np.zeros(len(points))
    for q in range(len(points)):
        angle = 0.0
        for f in range(len(triangles)):
            a, b, c = triangles[f, 0] - points[q], triangles[f, 1] - points[q], triangles[f, 2] - points[q]
            x, y, z = np.sqrt((a * a).sum()), np.sqrt((b * b).sum()), np.sqrt((c * c).sum())
            ab, bc, ca = (a * b).sum(), (b * c).sum(), (c * a).sum()
            angle += 2.0 * np.arctan2(_volume(a, b, c), x * y * z + ab * z + bc * x + ca * y)
        total[q] = angle / (4.0 * np.pi)
    return total


@compiled
def _volume(a: Floats, b: Floats, c: Floats) -> float:
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )  # fmt: skip


@compiled
def _crossings(edges: Floats, triangles: Floats) -> tuple[Ints, Floats]:
    """(K,) edge and (K,) share of its length at which it passes through a triangle (Moeller and Trumbore 1997)."""
    which, share = [0 for _ in range(0)], [0.0 for _ in range(0)]
    for e in range(len(edges)):
        start, along = edges[e, 0], edges[e, 1] - edges[e, 0]
        for f in range(len(triangles)):
            side, slope = triangles[f, 1] - triangles[f, 0], triangles[f, 2] - triangles[f, 0]
            away = start - triangles[f, 0]
            det = _volume(along, slope, side)
            if det == 0.0:
                continue
            u, v = _volume(away, along, slope) / det, _volume(along, away, side) / det
            t = _volume(away, side, slope) / det
            if u >= 0.0 and v >= 0.0 and u + v <= 1.0 and 0.0 < t < 1.0:
                which.append(e)
                share.append(t)
    return np.array(which, dtype=np.int64), np.array(share, dtype=np.float64)
