"""Curved specular reflection: the stationary point of the path length on a smooth surface.

The surface is Nagata's quadratic triangle over each facet, its normal the linear interpolation of the corner
normals. Both are continuous across smooth edges, so the mismatch between normal and bisector is continuous over
the whole surface and a stationary point cannot fall between two facets; on flat facets it would be lost from most
positions and be many decibels too loud where found.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import dot
from obstaclewatch.support.repeated import repeated
from obstaclewatch.support.rows import Rows
from simulator.surfaces.facet_bounds import beyond, may_mirror
from simulator.surfaces.quadratic_triangles import rounded, surface_around, with_curvature
from simulator.surfaces.reflectors import SmoothSurface
from simulator.world.frames import into_rest, out_of_rest, rotated, rotated_tensor

MAX_HITS = 32  # stationary points of one surface kept for one pair of points
CONVERGED = 1e-8  # last step of Newton's method, in facet coordinates: what is left after it is its square
STEPS = 16  # of Newton: on streets what lies on a facet takes 9 at most; more are spent where nothing lies
HALVINGS = 8
LEAST = 1e-5  # smaller steps than this fail to lower the mismatch by rounding alone
STRAY = 1.5  # how far from a facet's middle Newton's method may stray before the facet is given up
RUNS_THROUGH = 1e-6  # sum of both cosines of incidence below which a straight line runs through the surface: no mirror
INSIDE = 1e-7  # how far outside its facet (in facet coordinates) a stationary point may fall by rounding


@dataclass(frozen=True)
class StationaryPoints(Rows):
    """H points where a surface mirrors one point into another, world frame.

    Attributes:
        query: (H,) index of the pair of points; sorted.
        face: (H,) facet.
        uv: (H, 2) position within the facet.
        point_m: (H, 3).
        normal: (H, 3) unit normal on the side of the two points.
        curvature: (H, 3, 3) tensor K, dn = K dx along the surface, 1/m; positive where convex.
        standoff_m: (H,) how far the true surface may stand off its mesh there.
        clear: (H,) whether the place is within the facet, not where a crease was run over, and in front of it.
    """

    query: Ints
    face: Ints
    uv: Floats
    point_m: Floats
    normal: Floats
    curvature: Floats
    standoff_m: Floats
    clear: Flags

    @property
    def known(self) -> dict[str, NDArray]:
        """What paths are told of the surface there: (H, ...) columns of `Candidates`."""
        return {name: getattr(self, name) for name in ("normal", "curvature", "standoff_m", "face", "uv")}

    def with_rows(self, index: Ints, rows: StationaryPoints) -> StationaryPoints:
        """A copy with some rows replaced but for their queries."""
        columns = {name: getattr(self, name).copy() for name in self.__dataclass_fields__ if name != "query"}
        for name, column in columns.items():
            column[index] = getattr(rows, name)
        return replace(self, **columns)


def find(
    surface: SmoothSurface, name: str, frame: Floats, source_m: Floats, receiver_m: Floats, shown: Floats | None = None
) -> StationaryPoints:
    """Every stationary point of |x - source| + |receiver - x| on the surface for each of Q pairs of points.

    Args:
        name: of the obstacle that it is the surface of, for messages.
        frame: (Q, 4) where the surface stands for each pair.
        source_m, receiver_m: (Q, 3) in the world.
        shown: (Q, K, 4) half-spaces outside of which none is wanted, at rest: normals inwards and offsets.

    Raises:
        ValueError: more of them than a smooth surface has.
    """
    pieces, ends = surface.clusters, _ends_at_rest(frame, source_m, receiver_m)
    shown = np.zeros((len(frame), 0, 4)) if shown is None else shown
    face, uv, count = _search(
        _triangles(surface), surface.closed, pieces.bounds, pieces.facet, pieces.after, ends, shown
    )  # type: ignore[call-arg]  # fmt: skip
    if (count > MAX_HITS).any():
        raise ValueError(
            f"the smooth surface of '{name}' must mirror two points in {MAX_HITS} places at most, got {count.max()}: "
            "smooth its mesh, or call it flat"
        )
    query, slot = repeated(count)
    return _complete(surface, frame, ends, query, face[query, slot], uv[query, slot])


def follow(
    surface: SmoothSurface, frame: Floats, source_m: Floats, receiver_m: Floats, face: Ints, uv: Floats
) -> StationaryPoints:
    """The stationary point of each of Q pairs that continues a known one, walking from facet to facet.

    At a crease the last facet is extended: a path that ends within a beep keeps its smooth delay to the end of it.
    """
    ends = _ends_at_rest(frame, source_m, receiver_m)
    new_face, new_uv = _march(_triangles(surface), surface.neighbor, ends, face, uv)  # type: ignore[call-arg]
    return _complete(surface, frame, ends, np.arange(len(frame)), new_face, new_uv)


def follow_point(
    surface: SmoothSurface, frame: Floats, source_m: Floats, receiver_m: Floats, face: Ints, uv: Floats
) -> tuple[Floats, Ints, Floats]:
    """The (Q, 3) points, facets and places in them of `follow` alone."""
    ends = _ends_at_rest(frame, source_m, receiver_m)
    new_face, new_uv = _march(_triangles(surface), surface.neighbor, ends, face, uv)  # type: ignore[call-arg]
    point, _ = rounded(*_triangles(surface), new_face, new_uv)  # type: ignore[call-arg]
    return out_of_rest(point, frame), new_face, new_uv


def _ends_at_rest(frame: Floats, source_m: Floats, receiver_m: Floats) -> tuple[Floats, Floats]:
    """(Q, 3) sources and receivers as the surface sees them."""
    return np.ascontiguousarray(into_rest(source_m, frame)), np.ascontiguousarray(into_rest(receiver_m, frame))


def _triangles(surface: SmoothSurface) -> tuple[Floats, Floats, Floats]:
    """Corners, normals and bulges, (T, 3, 3) each: what Nagata's triangles are made of."""
    return surface.corner_m, surface.normal, surface.bulge_m


def _complete(
    surface: SmoothSurface, frame: Floats, ends: tuple[Floats, Floats], query: Ints, face: Ints, uv: Floats
) -> StationaryPoints:
    """What is known of the surface at places that mirror ends at rest, back in the world."""
    point, normal, curvature = with_curvature(*_triangles(surface), surface.curvature, face, uv)
    rises = np.stack([np.sum(normal * (end[query] - point), axis=1) for end in ends])
    side = np.where(rises.sum(axis=0) < 0.0, -1.0, 1.0)
    eta, zeta = uv[:, 0], uv[:, 1]
    within = (zeta >= -INSIDE) & (eta <= 1.0 + INSIDE) & (zeta <= eta + INSIDE)
    clear = within & (side * rises > 0.0).all(axis=0) & ((side > 0.0) | (not surface.closed))
    yaw = frame[query, 3]
    return StationaryPoints(
        query, face, uv, out_of_rest(point, frame[query]), rotated(normal * side[:, None], yaw),
        rotated_tensor(curvature * side[:, None, None], yaw), 2.0 * surface.sag_m[face], clear,
    )  # fmt: skip


@compiled
def _mismatch(triangle, ends, eta, zeta, work, slope):
    """Tangential part of the sum of unit vectors to both ends, along two axes in the plane of the facet.

    Place, unit normal and that sum are left in the first rows of `work`, where rows 3 and 4 hold the axes. The (2, 2)
    derivatives by eta and by zeta are filled into the columns of `slope`.
    """
    (corner, normal, bulge), (source, receiver) = triangle, ends
    x, n, h, dh = work[0], work[1], work[2], work[9]
    surface_around(corner, normal, bulge, eta, zeta, x, n, work[5:7], work[7:9])
    ls = lr = 0.0
    for k in range(3):
        ls += (source[k] - x[k]) ** 2
        lr += (receiver[k] - x[k]) ** 2
    ls, lr = 1.0 / np.sqrt(ls), 1.0 / np.sqrt(lr)
    for k in range(3):
        h[k] = (source[k] - x[k]) * ls + (receiver[k] - x[k]) * lr
    along = dot(h, n)
    for side in range(2):
        dx, dn = work[5 + side], work[7 + side]
        for k in range(3):
            dh[k] = 0.0
        _add_turn(x, dx, source, ls, dh)
        _add_turn(x, dx, receiver, lr, dh)
        change = dot(dh, n) + dot(h, dn)
        for i in range(2):
            axis = work[3 + i]
            slope[i, side] = dot(dh, axis) - change * dot(n, axis) - along * dot(dn, axis)
    f = g = 0.0
    for k in range(3):
        t = h[k] - along * n[k]
        f += t * work[3, k]
        g += t * work[4, k]
    return f, g


@compiled
def _add_turn(x, dx, end, inverse, dh):
    """Add the change of the unit vector u from x to an end as x moves by dx: (u (u . dx) - dx) / distance."""
    product = 0.0
    for k in range(3):
        product += (end[k] - x[k]) * dx[k]
    for k in range(3):
        dh[k] += ((end[k] - x[k]) * product * inverse * inverse - dx[k]) * inverse


@inlined
def _facet_axes(corner, one, other):
    """Fill in two orthonormal vectors in the plane of a facet."""
    size = along = 0.0
    for k in range(3):
        one[k] = corner[1, k] - corner[0, k]
        size += one[k] ** 2
    for k in range(3):
        one[k] /= np.sqrt(size)
        other[k] = corner[2, k] - corner[0, k]
        along += one[k] * other[k]
    size = 0.0
    for k in range(3):
        other[k] -= along * one[k]
        size += other[k] ** 2
    for k in range(3):
        other[k] /= np.sqrt(size)


@compiled
def _newton(triangle, ends, eta, zeta, work, slope):
    """Damped Newton for a zero of the mismatch from (eta, zeta); returns it and whether it converged.

    A step is halved until the mismatch falls: along a facet much longer than its distance the plain step circles.
    Where no step lowers it, it is least without being 0. The mismatch is taken along orthogonal axes: along two edges
    of a sliver, which are nearly one direction, what is across them would drown in rounding.
    """
    _facet_axes(triangle[0], work[3], work[4])
    f, g = _mismatch(triangle, ends, eta, zeta, work, slope)
    for _ in range(STEPS):
        a, b, c, d = slope[0, 0], slope[0, 1], slope[1, 0], slope[1, 1]
        det = a * d - b * c
        if det == 0.0:
            return eta, zeta, False
        de, dz = (d * f - b * g) / det, (a * g - c * f) / det
        size = max(abs(de), abs(dz))
        if size < CONVERGED:
            return eta - de, zeta - dz, True
        share = min(1.0, 0.5 / size)
        merit, lower = f * f + g * g, False
        for _half in range(HALVINGS):
            there = eta - share * de, zeta - share * dz
            f, g = _mismatch(triangle, ends, there[0], there[1], work, slope)
            lower = f * f + g * g < merit
            if lower:
                break
            share *= 0.5
        if not lower and size > LEAST:
            return eta, zeta, False
        eta, zeta = eta - share * de, zeta - share * dz
        if abs(eta - 0.5) > STRAY or abs(zeta - 0.5) > STRAY:
            return eta, zeta, False
    return eta, zeta, False


@inlined
def _first_guess(corner, straight, center, source, receiver):
    """Where on a facet to begin: its middle, or on a straight one that of the stretch where both segments rise alike.

    There a line along the facet mirrors both points into each other, whatever its normal.
    """
    if straight[0] == 0.0 and straight[1] == 0.0 and straight[2] == 0.0:
        return 2.0 / 3.0, 1.0 / 3.0
    rise_s = rise_r = 0.0
    height = np.zeros(3)
    for k in range(3):
        rise_s += (source[k] - center[k]) * straight[k]
        rise_r += (receiver[k] - center[k]) * straight[k]
        for i in range(3):
            height[i] += (corner[i, k] - center[k]) * straight[k]
    to_s = to_r = 0.0
    for k in range(3):
        to_s += (source[k] - center[k] - rise_s * straight[k]) ** 2
        to_r += (receiver[k] - center[k] - rise_r * straight[k]) ** 2
    to_s, to_r = np.sqrt(to_s), np.sqrt(to_r)
    low, high = min(height[0], height[1], height[2]), max(height[0], height[1], height[2])
    place = (rise_s * to_r + rise_r * to_s) / (to_s + to_r + 1e-300)
    place = min(max(place, low + 0.01 * (high - low)), high - 0.01 * (high - low))
    weight, crossed = np.zeros(3), 0
    for i in range(3):
        j = (i + 1) % 3
        if (height[i] < place) != (height[j] < place):
            share = (place - height[i]) / (height[j] - height[i])
            weight[i], weight[j], crossed = weight[i] + 1.0 - share, weight[j] + share, crossed + 1
    return (weight[1] + weight[2]) / crossed, weight[2] / crossed


@compiled
def _search(triangles, closed, pieces, facet, after, ends, shown):
    """Facet and position of every stationary point, piece by piece of the surface, each point kept once."""
    (corner, normal, bulge), (source, receiver) = triangles, ends
    queries = len(source)
    face = np.zeros((queries, MAX_HITS), np.int64)
    uv = np.zeros((queries, MAX_HITS, 2))
    count = np.zeros(queries, np.int64)
    point, work, slope = np.zeros((MAX_HITS, 3)), np.empty((10, 3)), np.empty((2, 2))
    bounds = np.empty(shown.shape[1:])
    for q in range(queries):
        piece, bounding = 0, 0
        for k in range(len(bounds)):  # without those that bound nothing: most are padding, and all pieces ask
            if shown[q, k, 0] != 0.0 or shown[q, k, 1] != 0.0 or shown[q, k, 2] != 0.0:
                for x in range(4):
                    bounds[bounding, x] = shown[q, k, x]
                bounding += 1
        while piece < len(facet):
            if beyond(bounds[:bounding], pieces.center_m[piece], pieces.ball_m[piece]) or not may_mirror(
                pieces, piece, closed, source[q], receiver[q]
            ):
                piece = after[piece]
                continue
            t = facet[piece]
            if t >= 0:
                guess = _first_guess(corner[t], pieces.straight[piece], pieces.center_m[piece], source[q], receiver[q])
                triangle = corner[t], normal[t], bulge[t]
                found, eta, zeta = _on_facet(
                    triangle, closed, (source[q], receiver[q]), guess, point, count[q], work, slope
                )
                if found:
                    if count[q] < MAX_HITS:
                        face[q, count[q]] = t
                        uv[q, count[q], 0], uv[q, count[q], 1] = eta, zeta
                    count[q] += 1
            piece += 1
    return face, uv, count


@inlined
def _on_facet(triangle, closed, ends, guess, known, count, work, slope):
    """A stationary point on one facet that is not among the known ones, which it joins: found, eta, zeta."""
    eta, zeta, converged = _newton(triangle, ends, guess[0], guess[1], work, slope)
    if not converged or zeta < -INSIDE or eta > 1.0 + INSIDE or eta - zeta < -INSIDE:
        return False, eta, zeta
    _mismatch(triangle, ends, eta, zeta, work, slope)
    corner, x, cosines = triangle[0], work[0], dot(work[1], work[2])
    if (cosines if closed else abs(cosines)) <= RUNS_THROUGH:
        return False, eta, zeta
    size = 0.0
    for k in range(3):
        size = max(size, abs(corner[1, k] - corner[0, k]), abs(corner[2, k] - corner[0, k]))
    for i in range(min(count, MAX_HITS)):
        gap = 0.0
        for k in range(3):
            gap = max(gap, abs(known[i, k] - x[k]))
        if gap <= 4.0 * INSIDE * size:
            return False, eta, zeta
    if count < MAX_HITS:
        for k in range(3):
            known[count, k] = x[k]
    return True, eta, zeta


@compiled
def _march(triangles, neighbor, ends, face0, uv0):
    """Newton from a known solution, crossing to the neighbouring facet whenever the zero lies beyond an edge."""
    (corner, normal, bulge), (source, receiver) = triangles, ends
    face, uv = np.empty(len(face0), np.int64), np.empty((len(face0), 2))
    work, slope = np.empty((10, 3)), np.empty((2, 2))
    for q in range(len(source)):
        t, eta, zeta = face0[q], uv0[q, 0], uv0[q, 1]
        came_from, returns = -1, 0
        for _ in range(200):
            triangle = corner[t], normal[t], bulge[t]
            eta, zeta, _ok = _newton(triangle, (source[q], receiver[q]), eta, zeta, work, slope)
            edge, worst = -1, 1e-9
            if -zeta > worst:
                edge, worst = 0, -zeta
            if eta - 1.0 > worst:
                edge, worst = 1, eta - 1.0
            if zeta - eta > worst:
                edge, worst = 2, zeta - eta
            if edge == -1 or neighbor[t, edge] == -1:
                break
            returns += neighbor[t, edge] == came_from
            if returns > 1 or (neighbor[t, edge] == came_from and worst < 1e-3):
                break  # on the common edge to within rounding, or beyond it as seen from either side
            came_from, t = t, neighbor[t, edge]
            eta, zeta = 2.0 / 3.0, 1.0 / 3.0
        face[q], uv[q, 0], uv[q, 1] = t, eta, zeta
    return face, uv
