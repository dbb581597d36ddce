"""Normals and curvatures at the vertices of a smooth mesh, from quadrics fitted to each vertex and its neighbours.

A quadric through the vertex is linear in its coefficients,

    z = A x + B y + C x^2/2 + D xy + E y^2/2 + G xz + H yz + I z^2/2,

and holds planes, spheres, cylinders, cones, ellipsoids and paraboloids exactly, however irregular their triangles;
means of facet normals are off by the spacing times the irregularity, which refinement does not cure.
"""

from __future__ import annotations

import numba
import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags

from obstaclewatch.support.arrays import Flags, Floats, Ints

# Ridge in columns of norm 1, for what the neighbours do not settle: on a strip between two rims the bend across it is
# unknown, and the given normal decides before a bend is made up.
RIDGE_SLOPE, RIDGE_BEND = 1e-7, 1e-9
STEEPEST = 2.0  # secant of 60 degrees: a fit that turns the normal farther than that is refused
NO_QUADRIC = 0.02  # share of the heights (over distance squared) that a fit may miss and still count as a quadric
HUB = 16  # neighbours are not shared through a vertex of more edges than this (the pole of a fan)


def rings(pairs: Ints, count: int) -> csr_matrix:
    """(count, count) neighbours one or two edges away, each row without itself.

    Args:
        pairs: (E, 2) vertices joined by an edge, each once or more.
        count: number of vertices.
    """
    both = np.concatenate([pairs, pairs[:, ::-1]])
    near = csr_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(count, count))
    near.data[:] = 1.0
    passing = diags((np.diff(near.indptr) <= HUB).astype(float))
    whole = coo_matrix(near + near @ passing @ near)
    other = whole.row != whole.col
    return csr_matrix((whole.data[other], (whole.row[other], whole.col[other])), shape=(count, count))


def fit_quadrics(point_m: Floats, normal: Floats, held: Flags, ring: csr_matrix) -> tuple[Floats, Floats, Flags]:
    """Quadrics through each vertex.

    Args:
        point_m: (V, 3) vertices.
        normal: (V, 3) unit normals to start from, on the side to stay on.
        held: (V,) whether the given normal is the true one.
        ring: neighbours of every vertex, as `rings` gives them.

    Returns:
        (V, 3) unit normals, (V, 3, 3) curvature tensors, dn = K dx, 1/m, and (V,) whether the neighbours lie on the
        quadric. A vertex whose fit is refused keeps its normal; its curvature is NaN.
    """
    return _fit(point_m, normal, held, ring.indptr.astype(np.int64), ring.indices.astype(np.int64))


@numba.njit(cache=True)
def _fit(point, normal, held, start, neighbor):
    count = len(point)
    out, curvature = normal.copy(), np.full((count, 3, 3), np.nan)
    true = np.zeros(count, dtype=np.bool_)
    frame = np.empty((3, 3))
    for v in range(count):
        rows = start[v + 1] - start[v]
        if rows == 0:
            continue
        gap = np.empty((rows, 3))
        for i in range(rows):
            gap[i] = point[neighbor[start[v] + i]] - point[v]
        _frame(gap, normal[v], frame)
        basis, height = _rows(gap @ frame.T, held[v])
        size = np.sqrt(np.sum(basis**2, axis=0)) + 1e-300
        basis /= size
        first = 0 if held[v] else 2
        gram = basis.T @ basis
        for i in range(len(gram)):
            gram[i, i] += RIDGE_SLOPE if i < first else RIDGE_BEND
        shape = np.linalg.solve(gram, basis.T @ height) / size
        if not np.isfinite(shape).all():
            continue
        gradient = np.zeros(3)
        gradient[2] = 1.0
        if first == 2:
            gradient[0], gradient[1] = -shape[0], -shape[1]
        hessian = np.empty((3, 3))
        hessian[0, 0], hessian[1, 1], hessian[2, 2] = -shape[first], -shape[first + 2], -shape[first + 5]
        hessian[0, 1] = hessian[1, 0] = -shape[first + 1]
        hessian[0, 2] = hessian[2, 0] = -shape[first + 3]
        hessian[1, 2] = hessian[2, 1] = -shape[first + 4]
        length = np.sqrt(np.sum(gradient**2))
        if length > STEEPEST:
            continue
        gradient /= length
        onto = np.eye(3) - np.outer(gradient, gradient)
        out[v] = gradient @ frame
        true[v] = np.abs(basis @ (shape * size) - height).max() <= NO_QUADRIC * np.abs(height).max()
        curvature[v] = frame.T @ (onto @ (hessian / length) @ onto) @ frame
    return out, curvature, true


@numba.njit(cache=True)
def _frame(gap, normal, frame):
    """Rows: the principal directions of the neighbours at right angles to the normal, and the normal."""
    flat = gap - np.outer(gap @ normal, normal)
    _, vector = np.linalg.eigh(flat.T @ flat + 0.0)
    axis = vector[:, 2] - normal * np.sum(vector[:, 2] * normal)
    axis /= np.sqrt(np.sum(axis**2))
    frame[0] = axis
    frame[1] = np.cross(normal, axis)
    frame[2] = normal


@numba.njit(cache=True)
def _rows(gap, held):
    """Weighted columns of the quadric (without the slopes if the normal is held) and weighted heights.

    Weights fall as the heights grow, so that the nearest decide where no quadric fits.
    """
    first = 0 if held else 2
    count = len(gap)
    basis, height = np.empty((count, first + 6)), np.empty(count)
    for i in range(count):
        x, y, z = gap[i, 0], gap[i, 1], gap[i, 2]
        square = x * x + y * y + z * z
        weight = 1.0 / square if square > 0.0 else 0.0  # nothing to learn from the same vertex across a crease
        if first == 2:
            basis[i, 0], basis[i, 1] = x, y
        basis[i, first] = 0.5 * x * x
        basis[i, first + 1] = x * y
        basis[i, first + 2] = 0.5 * y * y
        basis[i, first + 3] = x * z
        basis[i, first + 4] = y * z
        basis[i, first + 5] = 0.5 * z * z
        basis[i] *= weight
        height[i] = weight * z
    return basis, height
