"""Ray-tube spreading: the wavefront's curvature carried through every segment and reflection.

Deschamps, Proc. IEEE 60 (1972) 1022-1035. The curvature is a symmetric tensor Q with Q d = 0 along the ray d:
1/L on the first segment, Q / (1 + s Q) after a segment s, H Q H + 2 cos(t) P' K P after a mirror of curvature K. A
plane is K = 0, so flat and curved reflections mix freely in one sequence.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Complexes, Floats, Ints

_TINY = 1e-12
_CORNER_M = 1e-9


def spreading(points_m: Floats, normals: Floats, curvatures: Floats, count: Ints) -> Complexes:
    """(P,) amplitude of a unit point source's ray tube at the end of each path.

    Args:
        points_m: (P, N + 2, 3) source, reflection points, receiver; after the last reflection the receiver.
        normals: (P, N, 3) unit normals at the reflection points, on the incident side.
        curvatures: (P, N, 3, 3) curvature tensors there, 1/m, positive where convex, 0 for planes.
        count: (P,) number of reflections of each path; the rest of its row is not read.

    Returns:
        Real and positive but for paths through a focus, which gain a factor j (e^{+jwt}) at each.
    """
    length, ray = rays(points_m, normals)
    amplitude = 1.0 / length[:, 0].astype(np.complex128)
    front = (np.eye(3) - ray[:, 0, :, None] * ray[:, 0, None, :]) / length[:, 0, None, None]
    for k in range(normals.shape[1]):
        active = count > k
        front = np.where(active[:, None, None], _reflected(front, ray[:, k], normals[:, k], curvatures[:, k]), front)
        factor, after = _advanced(front, length[:, k + 1])
        amplitude = np.where(active, amplitude * factor, amplitude)
        front = np.where(active[:, None, None], after, front)
    return amplitude


def rays(points_m: Floats, normals: Floats) -> tuple[Floats, Floats]:
    """(P, N + 1) lengths and (P, N + 1, 3) unit directions of the segments of paths (P, N + 2, 3).

    Two reflections in the corner of two surfaces share one point; the segment between them has no length, and its
    direction is that of the segment before it, mirrored in the first of the two.
    """
    segments = np.diff(points_m, axis=1)
    length = np.linalg.norm(segments, axis=2)
    ray = segments / np.maximum(length, _TINY)[:, :, None]
    for k in range(1, segments.shape[1]):
        rows = np.flatnonzero(length[:, k] < _CORNER_M)
        normal = normals[rows, k - 1]
        along = np.sum(ray[rows, k - 1] * normal, axis=1)
        ray[rows, k] = ray[rows, k - 1] - 2.0 * along[:, None] * normal
    return length, ray


def _reflected(front: Floats, ray: Floats, normal: Floats, curvature: Floats) -> Floats:
    """Wavefront curvature just after the mirror (Deschamps 1972, Eq. 31, in tensor form)."""
    cosine = -np.sum(ray * normal, axis=1)
    mirror = np.eye(3) - 2.0 * normal[:, :, None] * normal[:, None, :]
    out = np.einsum("pij,pj->pi", mirror, ray)
    safe = np.where(np.abs(cosine) > _TINY, cosine, 1.0)
    onto = np.eye(3) - out[:, :, None] * normal[:, None, :] / safe[:, None, None]
    bend = np.einsum("pki,pkl,plj->pij", onto, curvature, onto)
    return mirror @ front @ mirror + 2.0 * cosine[:, None, None] * bend


def _advanced(front: Floats, length: Floats) -> tuple[Complexes, Floats]:
    """Amplitude factor 1 / sqrt(det(1 + s Q)) of a segment, and the curvature at its end."""
    trace = np.trace(front, axis1=1, axis2=2)
    minor = 0.5 * (trace**2 - np.einsum("pij,pji->p", front, front))
    spread = np.sqrt(np.maximum(0.25 * trace**2 - minor, 0.0))
    factor = np.ones(len(length), dtype=np.complex128)
    for root in (0.5 * trace + spread, 0.5 * trace - spread):
        stretch = 1.0 + length * root
        stretch = np.where(np.abs(stretch) < _TINY, _TINY, stretch)
        factor *= np.where(stretch > 0.0, 1.0, 1j) / np.sqrt(np.abs(stretch))
    matrix = np.eye(3) + length[:, None, None] * front
    singular = np.abs(np.linalg.det(matrix)) < _TINY
    matrix[singular] += _TINY * np.eye(3)
    return factor, front @ np.linalg.inv(matrix)
