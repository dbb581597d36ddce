"""Whether the straight line between two points is free: the only file that touches Embree.

Embree works in float32, so meshes and rays are moved to the origin first (2.9e-6 m at 10 m), and it answers only which
triangle is met first, if any: points and lengths stay in float64 elsewhere. Bodies that move alike have a scene of
their own, in which the rays are displaced instead of the mesh, so one build serves a whole walk.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.vectors import dot, unit
from simulator.world.frames import rotated_back

OFFSET = 2e-6  # of the largest coordinate: several float32 roundings, micrometres in a street
GRAZING = 1e-6  # sine between a ray and a triangle in whose plane it runs, but for rounding
COINCIDENT_M = 1e-7  # two reflections in one corner: nothing fits between them


@dataclass(frozen=True)
class Blocker:
    """Meshes that move together.

    Attributes:
        scene: their Embree scene, about `origin_m`.
        owner: (F,) index of the obstacle that each triangle is of; those of a mesh are in its order.
        origin_m: (3,) of their rest frame, subtracted before rounding to float32.
        normal: (F, 3) unit normals of the triangles.
        half_m: (3,) halves of the sides of the box about the origin that holds them.
    """

    scene: EmbreeScene
    owner: Ints
    origin_m: Floats
    normal: Floats
    half_m: Floats

    @cached_property
    def obstacle(self) -> int:
        """One of the obstacles: all have the same rest frame."""
        return int(self.owner[0])

    @cached_property
    def extent_m(self) -> float:
        """Largest coordinate about the origin."""
        return float(self.half_m.max())

    def blocks(self, start_m: Floats, end_m: Floats) -> Flags:
        """(R,) whether a mesh stands between two points (R, 3) of its rest frame; both ends are freed by `OFFSET`."""
        return self.blocks_from(start_m, end_m, *_at_rest(len(start_m)))

    def first_met(self, start_m: Floats, end_m: Floats) -> Ints:
        """(R,) the triangle that is met first from one point (R, 3) of the rest frame to another one, -1 for none."""
        row, *rays = self._rays(start_m, end_m, *_at_rest(len(start_m)))
        met = np.full(len(start_m), -1)
        if len(row):
            met[row] = self._hit(*rays)
        return met

    def blocks_from(self, start_m: Floats, end_m: Floats, frame: Floats, pose: Ints, asked: Flags) -> Flags:
        """The same for world points, with the rest frames (N, 4) of N poses and which of them each row (R,) is of.

        Args:
            asked: (R,) which rows are asked for; the others are False.
        """
        row, start, direction, length = self._rays(start_m, end_m, frame, pose, asked)
        blocked = np.zeros(len(pose), dtype=bool)
        if len(row):
            hit = self._hit(start, direction, length)
            blocked[row] = hit >= 0
            grazed = np.flatnonzero(hit >= 0)
            grazed = grazed[np.abs(dot(direction[grazed], self.normal[hit[grazed]])) < GRAZING]
            if len(grazed):
                blocked[row[grazed]] = self._beside(start[grazed], direction[grazed], length[grazed], hit[grazed])
        return blocked

    def _rays(
        self, start_m: Floats, end_m: Floats, frame: Floats, pose: Ints, asked: Flags
    ) -> tuple[Ints, Floats, Floats, Floats]:
        """Rows, starts, directions and lengths, as `_aimed` has them."""
        start_m, end_m, frame = (np.ascontiguousarray(each) for each in (start_m, end_m, frame))
        return _aimed(start_m, end_m, frame, pose, asked, self.origin_m, self.half_m)  # type: ignore[call-arg,no-any-return]

    def _hit(self, start_m: Floats, direction: Floats, length_m: Floats) -> Ints:
        """(O,) triangle that float32 rays meet within their lengths, -1 for none; as fast as whether there is one."""
        return np.asarray(self.scene.run(start_m, direction, dists=length_m, query="INTERSECT"))

    def _beside(self, start_m: Floats, direction: Floats, length_m: Floats, triangle: Ints) -> Flags:
        """(O,) whether rays in the planes of triangles are blocked on either side of these.

        Embree may find a triangle in the way wherever on its plane the ray runs, far away from it as well.
        """
        largest = np.maximum(np.abs(start_m), np.abs(start_m + length_m[:, None] * direction)).max(axis=1)
        aside = (OFFSET * np.maximum(largest, self.extent_m))[:, None] * self.normal[triangle]
        sides = ((start_m + side * aside).astype(np.float32) for side in (-1.0, 1.0))
        return np.logical_and(*(self._hit(side, direction, length_m) >= 0 for side in sides))


def _at_rest(count: int) -> tuple[Floats, Ints, Flags]:
    """Frames, poses and rows asked for, where `count` rows are in the rest frame."""
    return np.zeros((1, 4)), np.zeros(count, dtype=np.int64), np.ones(count, dtype=bool)


@compiled
def _aimed(start, end, frame, pose, asked, origin, half):
    """Rays between world points about a blocker's origin, as Embree takes them.

    Returns (O,) rows that are asked, whose ends are apart and that meet the blocker's box, and in float32 their (O, 3)
    starts, (O, 3) directions and (O,) lengths, cleared at both ends by `OFFSET` of the largest coordinate about the
    origin: what float32 rounding scales with.
    """
    rows, count, extent = len(pose), 0, max(half[0], half[1], half[2])
    row, length = np.empty(rows, np.int64), np.empty(rows, np.float32)
    first, direction = np.empty((rows, 3), np.float32), np.empty((rows, 3), np.float32)
    here, step = np.empty(3), np.empty(3)
    last, c, s = -1, 1.0, 0.0
    for r in range(rows):
        if not asked[r]:
            continue
        x, y, z, yaw = frame[pose[r]]
        if pose[r] != last:
            last, c, s = pose[r], np.cos(yaw), np.sin(yaw)
        here[0], here[1] = rotated_back(start[r, 0] - x, start[r, 1] - y, c, s)
        step[0], step[1] = rotated_back(end[r, 0] - start[r, 0], end[r, 1] - start[r, 1], c, s)
        here[2], step[2] = start[r, 2] - z, end[r, 2] - start[r, 2]
        largest, square = extent, 0.0
        for k in range(3):
            here[k] -= origin[k]
            largest = max(largest, abs(here[k]), abs(here[k] + step[k]))
            square += step[k] ** 2
        size = np.sqrt(square)
        if not size > COINCIDENT_M or _misses(here, step, half, OFFSET * largest):
            continue
        gap = min(OFFSET * largest, 0.25 * size)
        for k in range(3):
            direction[count, k] = step[k] / size
            first[count, k] = here[k] + gap * step[k] / size
        row[count], length[count] = r, size - 2.0 * gap
        count += 1
    return row[:count], first[:count], direction[:count], length[:count]


@inlined
def _misses(here, step, half, margin):
    """Whether the line from a point by a step stays outside a box about the origin, widened by a margin.

    Two convex bodies are apart if an axis separates them: one of the box's, or one across it and the line.
    """
    a, b, c = abs(0.5 * step[0]), abs(0.5 * step[1]), abs(0.5 * step[2])
    x, y, z = here[0] + 0.5 * step[0], here[1] + 0.5 * step[1], here[2] + 0.5 * step[2]
    i, j, k = half[0] + margin, half[1] + margin, half[2] + margin
    if abs(x) > i + a or abs(y) > j + b or abs(z) > k + c:
        return True
    return (
        abs(y * step[2] - z * step[1]) > 2.0 * (j * c + k * b)
        or abs(z * step[0] - x * step[2]) > 2.0 * (k * a + i * c)
        or abs(x * step[1] - y * step[0]) > 2.0 * (i * b + j * a)
    )


def blocker(meshes: Sequence[tuple[Floats, Ints]], owner: Ints) -> Blocker:
    """One blocker out of (vertices, faces) that share a rest frame, and the obstacles (F,) that the faces are of."""
    vertices = np.concatenate([mesh[0] for mesh in meshes])
    starts = np.cumsum([0] + [len(mesh[0]) for mesh in meshes[:-1]])
    faces = np.concatenate([mesh[1] + start for mesh, start in zip(meshes, starts, strict=True)])
    used = vertices[np.unique(faces)]  # a stray vertex far away would clear whole obstacles off the rays' ends
    origin = 0.5 * (used.min(axis=0) + used.max(axis=0))
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, (vertices - origin).astype(np.float32), faces.astype(np.int32))
    corner = vertices[faces]
    normal = unit(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    return Blocker(scene, owner, origin, normal, 0.5 * np.ptp(used, axis=0))
