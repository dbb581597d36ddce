"""Normals and curvatures at the vertices of a smooth mesh, from quadrics fitted to each vertex and its neighbours.

A quadric through the vertex is linear in its coefficients,

    z = A x + B y + C x^2/2 + D xy + E y^2/2 + G xz + H yz + I z^2/2,

and holds planes, spheres, cylinders, cones, ellipsoids and paraboloids exactly, however irregular their triangles;
means of facet normals are off by the spacing times the irregularity, which refinement does not cure.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import norm

# Ridge in columns of norm 1, for what the neighbours do not settle: on a strip between two rims the bend across it is
# unknown, and the given normal decides before a bend is made up.
RIDGE_SLOPE, RIDGE_BEND = 1e-7, 1e-9
RIDGE = np.diag([RIDGE_SLOPE] * 2 + [RIDGE_BEND] * 6)
STEEPEST = 2.0  # secant of 60 degrees: a fit that turns the normal farther than that is refused
NO_QUADRIC = 0.02  # share of the heights (over distance squared) that a fit may miss and still count as a quadric
AT_A_TIME = 8192  # neighbours of vertices that are fitted together: some 3 MB, what stays near the processor
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
    out, curvature = normal.copy(), np.full((len(point_m), 3, 3), np.nan)
    true = np.zeros(len(point_m), dtype=bool)
    count = np.diff(ring.indptr)
    left = np.argsort(-count, kind="stable")[: np.count_nonzero(count)]  # so that few rows are filled up
    while len(left):
        block, left = np.split(left, [max(1, AT_A_TIME // count[left[0]])])
        gap = point_m[_padded(ring[block], block)] - point_m[block, None]
        accepted, *fit = _fit(gap, normal[block], held[block])
        for whole, part in zip((out, curvature, true), fit, strict=True):
            whole[block[accepted]] = part[accepted]
    return out, curvature, true


def _padded(around: csr_matrix, vertex: Ints) -> Ints:
    """(B, R) neighbours of B vertices, filled up with the vertex itself, from which a fit learns nothing."""
    count = np.diff(around.indptr)
    taken = np.arange(count.max()) < count[:, None]
    out = np.where(taken, 0, vertex[:, None])
    out[taken] = around.indices
    return out


def _fit(gap: Floats, normal: Floats, held: Flags) -> tuple[Flags, Floats, Floats, Flags]:
    """(B,) whether each of B fits is accepted, and of each what `fit_quadrics` returns.

    Args:
        gap: (B, R, 3) from each vertex to its neighbours.
        normal, held: (B, 3) and (B,) of the vertices.
    """
    frame = _frames(gap, normal)
    back = frame.transpose(0, 2, 1)
    basis, height = _columns(gap @ back, held)
    size = np.sqrt((basis**2).sum(axis=1)) + 1e-300
    basis /= size[:, None]
    across = basis.transpose(0, 2, 1)
    scaled = np.linalg.solve(across @ basis + RIDGE, across @ height[..., None])
    off = np.abs((basis @ scaled)[..., 0] - height)
    true = off.max(axis=1) <= NO_QUADRIC * np.abs(height).max(axis=1)
    a, b, c, d, e, g, h, i = (scaled[..., 0] / size).T
    gradient = np.stack([-a, -b, np.ones(len(a))], axis=1)
    length = norm(gradient)
    gradient /= length[:, None]
    hessian = -np.stack([c, d, g, d, e, h, g, h, i], axis=1).reshape(-1, 3, 3) / length[:, None, None]
    onto = np.eye(3) - gradient[:, :, None] * gradient[:, None, :]
    accepted = np.isfinite(scaled).all(axis=(1, 2)) & (length <= STEEPEST)
    return accepted, np.einsum("vij,vj->vi", back, gradient), back @ (onto @ hessian @ onto) @ frame, true


def _frames(gap: Floats, normal: Floats) -> Floats:
    """(B, 3, 3) in rows: the principal directions of the neighbours at right angles to the normal, and the normal."""
    flat = gap - (gap @ normal[..., None]) * normal[:, None]
    _, vector = np.linalg.eigh(flat.transpose(0, 2, 1) @ flat)
    axis = vector[:, :, 2] - np.einsum("vi,vi->v", vector[:, :, 2], normal)[:, None] * normal
    with np.errstate(invalid="ignore"):  # neighbours at the vertex itself have no direction: such a fit is refused
        axis /= norm(axis)[:, None]
    return np.stack([axis, np.cross(normal, axis), normal], axis=1)


def _columns(gap: Floats, held: Flags) -> tuple[Floats, Floats]:
    """(B, R, 8) weighted columns of the quadric (slopes 0 where the normal is held) and (B, R) weighted heights.

    Weights fall as the heights grow, so that the nearest decide where no quadric fits.
    """
    x, y, z = np.moveaxis(gap, -1, 0)
    slope = np.where(held, 0.0, 1.0)[:, None]
    columns = [slope * x, slope * y, 0.5 * x * x, x * y, 0.5 * y * y, x * z, y * z, 0.5 * z * z]
    square = x * x + y * y + z * z
    # nothing to learn from the same vertex, across a crease or where rows are filled up
    weight = np.divide(1.0, square, out=np.zeros_like(square), where=square > 0.0)
    return np.stack(columns, axis=-1) * weight[..., None], weight * z
