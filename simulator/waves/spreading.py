"""Ray-tube spreading: the wavefront's curvature carried through every segment and reflection.

Deschamps, Proc. IEEE 60 (1972) 1022-1035. The curvature is a symmetric tensor Q with Q d = 0 along the ray d:
1/L on the first segment, Q / (1 + s Q) after a segment s, H Q H + 2 cos(t) P' K P after a mirror of curvature K. A
plane is K = 0, so flat and curved reflections mix freely in one sequence.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import distance, multiplied

_TINY = 1e-12
_CORNER_M = 1e-9
_QUARTER_TURNS = np.array([1.0, 1.0j, -1.0, -1.0j])


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
    columns = (np.ascontiguousarray(column) for column in (points_m, normals, curvatures, count))
    amplitude, foci = _amplitudes(*columns)  # type: ignore[call-arg]
    return amplitude * _QUARTER_TURNS[foci % 4]


def rays(points_m: Floats, normals: Floats) -> tuple[Floats, Floats]:
    """(P, N + 1) lengths and (P, N + 1, 3) unit directions of the segments of paths (P, N + 2, 3).

    Two reflections in the corner of two surfaces share one point; the segment between them has no length, and its
    direction is that of the segment before it, mirrored in the first of the two. A speaker may lie on the first mirror:
    the first segment has then the direction of the second, mirrored in it.
    """
    return _rays(np.ascontiguousarray(points_m), np.ascontiguousarray(normals))  # type: ignore[call-arg]


@compiled
def _rays(points, normals):
    length = np.empty((len(points), points.shape[1] - 1))
    ray = np.zeros((len(points), points.shape[1] - 1, 3))
    for p in range(len(points)):
        for k in range(ray.shape[1]):
            length[p, k] = _segment(points[p], normals[p], k, ray[p, k - 1], ray[p, k])
    return length, ray


@compiled
def _segment(points, normals, k, before, ray):
    """Length of segment k of a path, and its direction filled in; `before` is that of the segment before it."""
    square = along = 0.0
    for x in range(3):
        ray[x] = points[k + 1, x] - points[k, x]
        square += ray[x] * ray[x]
    length = np.sqrt(square)
    size = length
    if length < _CORNER_M:  # the direction of a neighbour, mirrored in the surface between them
        mirror, square = max(k - 1, 0), 0.0
        for x in range(3):
            ray[x] = before[x] if k > 0 else points[2, x] - points[1, x]
            along += ray[x] * normals[mirror, x]
            square += ray[x] * ray[x]
        for x in range(3):
            ray[x] -= 2.0 * along * normals[mirror, x]
        size = np.sqrt(square)
    for x in range(3):
        ray[x] /= max(size, _TINY)
    return length


@compiled
def _amplitudes(points, normals, curvatures, count):
    real, foci = np.empty(len(points)), np.zeros(len(points), np.int64)
    front, work, ray = np.empty((3, 3)), np.empty((2, 3, 3)), np.zeros((2, 3))
    for p in range(len(points)):
        if not _bends(curvatures[p], count[p]):
            real[p] = 1.0 / max(_length(points[p]), _TINY)
            continue
        length = max(_segment(points[p], normals[p], 0, ray[1], ray[0]), _TINY)
        squares = length * length
        for i in range(3):
            for j in range(3):
                front[i, j] = ((i == j) - ray[0, i] * ray[0, j]) / length
        for k in range(count[p]):
            here = ray[k % 2]
            _reflect(front, here, normals[p, k], curvatures[p, k], work)
            length = _segment(points[p], normals[p], k + 1, here, ray[(k + 1) % 2])
            stretch, negative = _advance(front, length, work)
            squares *= stretch
            foci[p] += negative
        real[p] = 1.0 / np.sqrt(squares)
    return real, foci


@inlined
def _bends(curvatures, count):
    """Whether any of the surfaces that a path meets is curved: off planes alone its amplitude is 1 / length."""
    bends = False
    for k in range(count):
        bends |= _is_curved(curvatures[k])
    return bends


@inlined
def _is_curved(curvature):
    """Whether any entry of a tensor (3, 3) is not 0."""
    for i in range(3):
        for j in range(3):
            if curvature[i, j] != 0.0:
                return True
    return False


@inlined
def _length(points):
    """Length of a path."""
    total = 0.0
    for k in range(len(points) - 1):
        total += distance(points[k], points[k + 1])
    return total


@inlined
def _reflect(front, ray, normal, curvature, work):
    """Make a wavefront's curvature that just after the mirror (Deschamps 1972, Eq. 31, in tensor form)."""
    mirror, half = work[0], work[1]
    cosine = -(ray[0] * normal[0] + ray[1] * normal[1] + ray[2] * normal[2])
    for i in range(3):
        for j in range(3):
            mirror[i, j] = (i == j) - 2.0 * normal[i] * normal[j]
    multiplied(mirror, front, half)
    multiplied(half, mirror, front)
    if not _is_curved(curvature):
        return
    safe = cosine if abs(cosine) > _TINY else 1.0
    for i in range(3):  # onto the tangent plane along the reflected ray
        out = ray[i] + 2.0 * cosine * normal[i]
        for j in range(3):
            mirror[i, j] = (i == j) - out * normal[j] / safe
    multiplied(curvature, mirror, half)
    for i in range(3):
        for j in range(3):
            for k in range(3):
                front[i, j] += 2.0 * cosine * mirror[k, i] * half[k, j]


@inlined
def _advance(front, length, work):
    """|det(1 + s Q)| of a segment and the foci in it; the curvature becomes that at its end, Q / (1 + s Q)."""
    square = 0.0
    for i in range(3):
        for j in range(3):
            square += front[i, j] * front[j, i]
    half = 0.5 * (front[0, 0] + front[1, 1] + front[2, 2])
    spread = np.sqrt(max(0.5 * square - half * half, 0.0))
    one, other = 1.0 + length * (half + spread), 1.0 + length * (half - spread)
    _onwards(front, length, work[0], work[1])
    return max(abs(one), _TINY) * max(abs(other), _TINY), (one <= -_TINY) + (other <= -_TINY)


@inlined
def _onwards(front, length, adjoint, matrix):
    """Replace Q by Q / (1 + s Q), through the adjoint of 1 + s Q."""
    for i in range(3):
        for j in range(3):
            matrix[i, j] = (i == j) + length * front[i, j]
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            c, d = (j + 1) % 3, (j + 2) % 3
            adjoint[j, i] = matrix[a, c] * matrix[b, d] - matrix[a, d] * matrix[b, c]
    size = matrix[0, 0] * adjoint[0, 0] + matrix[0, 1] * adjoint[1, 0] + matrix[0, 2] * adjoint[2, 0]
    if abs(size) < _TINY:
        size = _TINY
    multiplied(front, adjoint, matrix)
    for i in range(3):
        for j in range(3):
            front[i, j] = matrix[i, j] / size
