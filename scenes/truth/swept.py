"""Does the walker's body meet an obstacle? Distances in plan between a moving stadium and a slab of the mesh.

The body is an upright prism whose plan is a stadium: all points within `half_width_m` of a core segment that points
along the heading. The obstacle is the part of its mesh between the ground and the walker's height, seen from above.
They touch when the distance in plan between core and slab falls to the half width.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
import trimesh

from obstaclewatch.support.arrays import Floats, Ints

GROUP = 16
"""Polygons per group in the search for the nearest."""


@dataclass(frozen=True)
class Body:
    """Measures of the walker's body around the phone.

    Attributes:
        half_width_m: half the breadth across the walk; the paper's users are not measured, 0.25 m is our convention.
        front_m: how far the body (hands and phone) reaches ahead of the phone's origin.
        back_m: how far it reaches behind the phone's origin: arm's length and the depth of the torso.
        height_m: how high it reaches above the ground.
    """

    half_width_m: float = 0.25
    front_m: float = 0.10
    back_m: float = 0.60
    height_m: float = 1.8

    def __post_init__(self) -> None:
        for name in ("half_width_m", "front_m", "back_m"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must not be negative, got {getattr(self, name)}")
        if not self.height_m > 0.0:
            raise ValueError(f"height_m must be positive, got {self.height_m}")

    def core(self, phone_m: Floats, heading_rad: Floats) -> Floats:
        """(N, 2, 2) ends, front first, of the core segment in plan, for (N, 3) phone positions and (N,) headings."""
        ahead = np.stack([np.cos(heading_rad), np.sin(heading_rad)], axis=-1)
        front, back = self.front_m - self.half_width_m, self.half_width_m - self.back_m
        if front < back:  # a body broader than deep: its core is a point
            front = back = 0.5 * (front + back)
        along = np.array([front, back])[:, None]
        core: Floats = phone_m[:, None, :2] + along * ahead[:, None]
        return core


@dataclass(frozen=True)
class Slab:
    """What of a mesh lies between two heights, in plan.

    Attributes:
        corner_m: (P, 5, 2) corners of convex polygons, one per triangle that reaches into the slab.
        count: (P,) how many of them are used, 1 to 5.
        circle_m: (P, 3) centre and radius of a circle around each polygon.
        group_m: (G, 3) centre and radius of a circle around each group of 16 consecutive polygons.
    """

    corner_m: Floats
    count: Ints
    circle_m: Floats
    group_m: Floats

    @classmethod
    def of(cls, mesh: trimesh.Trimesh, low_m: float, high_m: float) -> Slab:
        """The slab between two heights; no polygons if nothing of the mesh is there."""
        vertices = np.ascontiguousarray(mesh.vertices, dtype=np.float64)
        corner, count, circle = _clip(vertices, np.ascontiguousarray(mesh.faces), low_m, high_m)
        order = np.argsort(_cells(circle), kind="stable")  # neighbours in plan follow each other
        order = order[count[order] > 0]
        circle = circle[order]
        return cls(corner[order], count[order], circle, _group(circle))

    def __len__(self) -> int:
        return len(self.count)

    def points(self) -> Floats:
        """(K, 2) all corners in use."""
        points: Floats = self.corner_m[np.arange(5) < self.count[:, None]]
        return points

    def distance(self, core_m: Floats) -> float:
        """Distance in plan to a segment (2, 2), m; 0 where they overlap, infinite if the slab is empty."""
        return float(_distance(np.ascontiguousarray(core_m), self.corner_m, self.count, self.circle_m, self.group_m))

    def first_contact(self, cores_m: Floats, half_width_m: float) -> float:
        """Where along N consecutive cores (N, 2, 2) the distance first falls to the half width.

        Returns:
            A fractional index, linear between two cores; NaN if it never does. Contact that begins and ends between
            two cores, and so is shallower than the bulge of the obstacle between them, is not seen.
        """
        cores = np.ascontiguousarray(cores_m)
        return float(_first_contact(cores, half_width_m, self.corner_m, self.count, self.circle_m, self.group_m))

    def closest_approach(self, cores_m: Floats) -> float:
        """Smallest distance over N consecutive cores (N, 2, 2), m; infinite if the slab is empty."""
        cores = np.ascontiguousarray(cores_m)
        return float(_closest_approach(cores, self.corner_m, self.count, self.circle_m, self.group_m))


@numba.njit(cache=True, nogil=True)
def _cells(circle: Floats) -> Ints:
    """(P,) cells, counted row by row, of an 8 x 8 grid over all centres."""
    low, high = circle[0, :2].copy(), circle[0, :2].copy()
    for p in range(len(circle)):
        for i in range(2):
            low[i], high[i] = min(low[i], circle[p, i]), max(high[i], circle[p, i])
    size = np.maximum((high - low) / 7.999, 1e-12)
    cell = np.empty(len(circle), dtype=np.int64)
    for p in range(len(circle)):
        cell[p] = 8 * int((circle[p, 0] - low[0]) / size[0]) + int((circle[p, 1] - low[1]) / size[1])
    return cell


@numba.njit(cache=True, nogil=True)
def _group(circle: Floats) -> Floats:
    """Circles around groups of consecutive circles."""
    groups = np.zeros(((len(circle) + GROUP - 1) // GROUP, 3))
    for g in range(len(groups)):
        last = min((g + 1) * GROUP, len(circle))
        for p in range(g * GROUP, last):
            groups[g, :2] += circle[p, :2] / (last - g * GROUP)
        for p in range(g * GROUP, last):
            reach = np.hypot(circle[p, 0] - groups[g, 0], circle[p, 1] - groups[g, 1]) + circle[p, 2]
            groups[g, 2] = max(groups[g, 2], reach)
    return groups


@numba.njit(cache=True, nogil=True)
def _clip(vertices: Floats, faces: Ints, low: float, high: float) -> tuple[Floats, Ints, Floats]:
    """Clip triangles between two heights: (F, 5, 2) corners in plan, (F,) how many, (F, 3) circles around them."""
    corner, circle = np.zeros((len(faces), 5, 2)), np.zeros((len(faces), 3))
    count = np.zeros(len(faces), dtype=np.int64)
    for f in range(len(faces)):
        triangle = vertices[faces[f]]
        z = triangle[:, 2]
        if max(z[0], z[1], z[2]) < low or min(z[0], z[1], z[2]) > high:
            continue
        n = 3
        if min(z[0], z[1], z[2]) < low or max(z[0], z[1], z[2]) > high:
            triangle, n = _clip_side(triangle, n, low, 1.0)
            triangle, n = _clip_side(triangle, n, high, -1.0)
        count[f] = n
        for i in range(n):
            corner[f, i, 0], corner[f, i, 1] = triangle[i, 0], triangle[i, 1]
            circle[f, 0] += triangle[i, 0] / n
            circle[f, 1] += triangle[i, 1] / n
        for i in range(n):
            reach = np.hypot(corner[f, i, 0] - circle[f, 0], corner[f, i, 1] - circle[f, 1])
            circle[f, 2] = max(circle[f, 2], reach)
    return corner, count, circle


@numba.njit(cache=True, nogil=True)
def _clip_side(polygon: Floats, count: int, height: float, sign: float) -> tuple[Floats, int]:
    """Keep what has sign * (z - height) >= 0 of a convex polygon (Sutherland and Hodgman)."""
    kept, n = np.zeros((5, 3)), 0
    for i in range(count):
        here, ahead = polygon[i], polygon[(i + 1) % count]
        up, up_ahead = sign * (here[2] - height), sign * (ahead[2] - height)
        if up >= 0.0:
            kept[n] = here
            n += 1
        if (up > 0.0 and up_ahead < 0.0) or (up < 0.0 and up_ahead > 0.0):
            kept[n] = here + up / (up - up_ahead) * (ahead - here)
            n += 1
    return kept, n


@numba.njit(cache=True, nogil=True)
def _distance(core: Floats, corner: Floats, count: Ints, circle: Floats, group: Floats) -> float:
    """Distance to the nearest polygon: circles first say how far that can be, then who can be that near."""
    bound = np.inf
    for g in range(len(group)):
        bound = min(bound, _point_to_segment(group[g], core[0], core[1]) + group[g, 2])
    best = np.inf
    for g in range(len(group)):
        if _point_to_segment(group[g], core[0], core[1]) - group[g, 2] > min(bound, best):
            continue
        for p in range(g * GROUP, min((g + 1) * GROUP, len(count))):
            if _point_to_segment(circle[p], core[0], core[1]) - circle[p, 2] <= min(bound, best):
                best = min(best, _to_polygon(core, corner[p], count[p]))
        if best == 0.0:
            return best
    return best


@numba.njit(cache=True, nogil=True)
def _to_polygon(core: Floats, corner: Floats, count: int) -> float:
    """Distance between a segment and a convex polygon with its inside."""
    if count >= 3 and _inside(core[0], corner, count):
        return 0.0
    best = np.inf
    for i in range(count):
        best = min(best, _segment_to_segment(core[0], core[1], corner[i], corner[(i + 1) % count]))
    return best


@numba.njit(cache=True, nogil=True)
def _inside(point: Floats, corner: Floats, count: int) -> bool:
    """Whether a point lies strictly inside a convex polygon of either sense of rotation."""
    left, right = 0, 0
    for i in range(count):
        turn = _turn(corner[i], corner[(i + 1) % count], point)
        left += turn > 0.0
        right += turn < 0.0
    return left == count or right == count


@numba.njit(cache=True, nogil=True)
def _segment_to_segment(a: Floats, b: Floats, c: Floats, d: Floats) -> float:
    if _turn(a, b, c) * _turn(a, b, d) < 0.0 and _turn(c, d, a) * _turn(c, d, b) < 0.0:
        return 0.0
    ends = min(_point_to_segment(a, c, d), _point_to_segment(b, c, d))
    return min(ends, _point_to_segment(c, a, b), _point_to_segment(d, a, b))


@numba.njit(cache=True, nogil=True)
def _point_to_segment(p: Floats, a: Floats, b: Floats) -> float:
    x, y = b[0] - a[0], b[1] - a[1]
    length2 = x * x + y * y
    s = 0.0
    if length2 > 0.0:
        s = min(max(((p[0] - a[0]) * x + (p[1] - a[1]) * y) / length2, 0.0), 1.0)
    return np.hypot(a[0] + s * x - p[0], a[1] + s * y - p[1])


@numba.njit(cache=True, nogil=True)
def _turn(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the signed area of the triangle abc."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


@numba.njit(cache=True, nogil=True)
def _longest_step(cores: Floats) -> float:
    longest = 0.0
    for k in range(len(cores) - 1):
        for end in range(2):
            step = cores[k + 1, end] - cores[k, end]
            longest = max(longest, np.hypot(step[0], step[1]))
    return longest


@numba.njit(cache=True, nogil=True)
def _first_contact(
    cores: Floats, half_width: float, corner: Floats, count: Ints, circle: Floats, group: Floats
) -> float:
    """March by as many cores as the gap safely allows (the distance changes by at most one step per core)."""
    step, k, before = _longest_step(cores), 0, 0
    while True:
        gap = _distance(cores[k], corner, count, circle, group) - half_width
        if gap <= 0.0:
            break
        if k == len(cores) - 1:
            return np.nan
        leap = len(cores) if gap >= step * len(cores) else max(1, int(gap / step))
        before, k = k, min(k + leap, len(cores) - 1)
    low, high = float(max(before, k - 1)), float(k)
    for _ in range(50):
        middle = 0.5 * (low + high)
        base = min(int(middle), len(cores) - 1)
        rest = middle - base
        core = cores[base] if rest == 0.0 else (1.0 - rest) * cores[base] + rest * cores[base + 1]
        if _distance(core, corner, count, circle, group) <= half_width:
            high = middle
        else:
            low = middle
    return high


@numba.njit(cache=True, nogil=True)
def _closest_approach(cores: Floats, corner: Floats, count: Ints, circle: Floats, group: Floats) -> float:
    """Branch and bound over the indices: an interval is split only while it could hide a smaller distance."""
    step, last = _longest_step(cores), len(cores) - 1
    first_d = _distance(cores[0], corner, count, circle, group)
    last_d = _distance(cores[last], corner, count, circle, group)
    best = min(first_d, last_d)
    low, high = np.empty(128, dtype=np.int64), np.empty(128, dtype=np.int64)
    low_d, high_d = np.empty(128), np.empty(128)
    low[0], high[0], low_d[0], high_d[0], depth = 0, last, first_d, last_d, 1
    while depth > 0:
        depth -= 1
        a, b, da, db = low[depth], high[depth], low_d[depth], high_d[depth]
        if b - a < 2 or 0.5 * (da + db - step * (b - a)) >= best:
            continue
        m = (a + b) // 2
        dm = _distance(cores[m], corner, count, circle, group)
        best = min(best, dm)
        low[depth], high[depth], low_d[depth], high_d[depth] = a, m, da, dm
        low[depth + 1], high[depth + 1], low_d[depth + 1], high_d[depth + 1] = m, b, dm, db
        depth += 2
    return best
