"""Nagata's quadratic triangles: places, unit normals and curvature over facets whose corners have normals.

Nagata 2005, Comput. Aided Geom. Des. 22:327. Position is quadratic, and normals are interpolated linearly, both
continuous across smooth edges; the quadratic's own normal would not be. Curvature tensors of the corners are carried
to the place and averaged.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import dot, multiplied

PARALLEL_RAD = 3e-3
SHIFT = 0.25  # of the chord: how far a rounded edge may shift its points along it
EDGES = ((0, 1), (1, 2), (0, 2))


def bulges(corner_m: Floats, normal: Floats) -> Floats:
    """(T, 3, 3) edge vectors for edges 01, 12, 02 of facets with corners (T, 3, 3) and unit normals there."""
    return np.stack([edge_bulge(corner_m[:, a], corner_m[:, b], normal[:, a], normal[:, b]) for a, b in EDGES], axis=1)


def edge_bulge(a: Floats, b: Floats, normal_a: Floats, normal_b: Floats) -> Floats:
    """(T, 3) edge vectors c: x(s) = a + (b - a - c) s + c s^2 leaves a and b at right angles to both normals.

    Nagata 2005, Eq. 11, split along the sum m of the normals, which raises the edge off its chord, and their difference
    d, which only moves its points along it. The latter part is held to a fraction of the chord and fades out between
    almost parallel normals, where it is rounding over rounding.
    """
    chord, middle, apart = b - a, normal_a + normal_b, normal_b - normal_a
    at_a, at_b = np.sum(normal_a * chord, axis=1), np.sum(normal_b * chord, axis=1)
    most = SHIFT * np.abs(np.sum(chord * apart, axis=1))
    rise = (at_a - at_b) / np.maximum(np.sum(middle**2, axis=1), 1e-300)
    shift = -np.clip(at_a + at_b, -most, most) / (np.sum(apart**2, axis=1) + PARALLEL_RAD**2)
    return rise[:, None] * middle + shift[:, None] * apart


@compiled
def surface_at(corner, normal, bulge, eta, zeta, x, n):
    """Position on the Nagata triangle and interpolated unit normal at (eta, zeta), 0 <= zeta <= eta <= 1."""
    for k in range(3):
        c1, c2, c3 = bulge[0, k], bulge[1, k], bulge[2, k]
        a, b, c = corner[0, k], corner[1, k], corner[2, k]
        x[k] = (
            a + (b - a - c1) * eta + (c - b + c1 - c3) * zeta
            + (c3 - c1 - c2) * eta * zeta + c1 * eta * eta + c2 * zeta * zeta
        )  # fmt: skip
        n[k] = (1.0 - eta) * normal[0, k] + (eta - zeta) * normal[1, k] + zeta * normal[2, k]
    scale = 1.0 / np.sqrt(dot(n, n))
    for k in range(3):
        n[k] *= scale


@inlined
def surface_around(corner, normal, bulge, eta, zeta, x, n, dx, dn):
    """Position and unit normal as `surface_at`, and their derivatives by eta and zeta, (2, 3) each."""
    surface_at(corner, normal, bulge, eta, zeta, x, n)
    size = 0.0
    for k in range(3):
        c1, c2, c3 = bulge[0, k], bulge[1, k], bulge[2, k]
        cross = c3 - c1 - c2
        dx[0, k] = corner[1, k] - corner[0, k] - c1 + cross * zeta + 2.0 * c1 * eta
        dx[1, k] = corner[2, k] - corner[1, k] + c1 - c3 + cross * eta + 2.0 * c2 * zeta
        size += n[k] * ((1.0 - eta) * normal[0, k] + (eta - zeta) * normal[1, k] + zeta * normal[2, k])
    for side in range(2):
        along = 0.0
        for k in range(3):
            dn[side, k] = (normal[side + 1, k] - normal[side, k]) / size
            along += dn[side, k] * n[k]
        for k in range(3):
            dn[side, k] -= along * n[k]


@compiled
def rounded(corner, normal, bulge, face, uv):
    """(R, 3) points and (R, 3) unit normals of Nagata triangles (T, 3, 3) at places (R, 2) of facets (R,)."""
    point, unit = np.empty((len(face), 3)), np.empty((len(face), 3))
    for i in range(len(face)):
        t = face[i]
        surface_at(corner[t], normal[t], bulge[t], uv[i, 0], uv[i, 1], point[i], unit[i])
    return point, unit


@compiled
def with_curvature(corner, normal, bulge, corner_curvature, face, uv):
    """Position, unit normal and curvature tensor at facet coordinates."""
    count = len(face)
    point, unit, curvature = np.empty((count, 3)), np.empty((count, 3)), np.zeros((count, 3, 3))
    turn, half = np.empty((3, 3)), np.empty((3, 3))
    for i in range(count):
        t = face[i]
        eta, zeta = uv[i]
        surface_at(corner[t], normal[t], bulge[t], eta, zeta, point[i], unit[i])
        weight = (1.0 - eta, eta - zeta, zeta)
        for k in range(3):
            _turning(normal[t, k], unit[i], turn)
            multiplied(turn, corner_curvature[t, k], half)
            _add_product(weight[k], half, turn, curvature[i])
    return point, unit, curvature


@inlined
def _turning(a, b, turn):
    """Rotation that takes unit vector a to b the shortest way: a tensor carried so keeps its principal curvatures."""
    share = 1.0 / (1.0 + dot(a, b))
    for i in range(3):
        for j in range(3):
            turn[i, j] = 2.0 * b[i] * a[j] - share * (a[i] + b[i]) * (a[j] + b[j])
        turn[i, i] += 1.0


@inlined
def _add_product(weight, a, b, total):
    """Add weight a b^T."""
    for i in range(3):
        for j in range(3):
            total[i, j] += weight * dot(a[i], b[j])
