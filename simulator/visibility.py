"""Whether the straight line between two points is free: the only file that touches Embree.

Embree works in float32, so meshes and rays are moved to the origin first (2.9e-6 m at 10 m), and it answers only
"blocked or not": points and lengths stay in float64 elsewhere. Bodies that move have a scene of their own, in
which the rays are displaced instead of the mesh, so one build serves a whole walk.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

Floats = NDArray[np.float64]

OFFSET = 2e-6  # of the largest coordinate: several float32 roundings, micrometres in a street
COINCIDENT_M = 1e-7  # two reflections in one corner: nothing fits between them


@dataclass(frozen=True)
class Blocker:
    """Meshes that move together.

    Attributes:
        scene: their Embree scene, about `origin_m`.
        obstacle: index of the obstacle whose frame they rest in.
        origin_m: (3,) of that frame, subtracted before rounding to float32.
        extent_m: largest coordinate about the origin.
    """

    scene: EmbreeScene
    obstacle: int
    origin_m: Floats
    extent_m: float

    def blocks(self, start_m: Floats, end_m: Floats) -> NDArray[np.bool_]:
        """(R,) whether a mesh stands between two points (R, 3) of its rest frame; both ends are freed by `OFFSET`."""
        start, end = start_m - self.origin_m, end_m - self.origin_m
        leg = end - start
        length = np.linalg.norm(leg, axis=1)
        open_leg = np.flatnonzero(length > COINCIDENT_M)
        blocked = np.zeros(len(length), dtype=bool)
        if len(open_leg) == 0:
            return blocked
        gap = np.minimum(OFFSET * self.reach(start_m, end_m), 0.25 * length[open_leg])
        direction = leg[open_leg] / length[open_leg, None]
        hit = self.scene.run(
            (start[open_leg] + gap[:, None] * direction).astype(np.float32),
            direction.astype(np.float32),
            dists=(length[open_leg] - 2.0 * gap).astype(np.float32),
            query="OCCLUDED",
        )
        blocked[open_leg] = np.asarray(hit) != -1
        return blocked

    def reach(self, start_m: Floats, end_m: Floats) -> float:
        """Largest coordinate about the origin among mesh and rays, m: what float32 rounding scales with."""
        ends = max(float(np.abs(start_m - self.origin_m).max()), float(np.abs(end_m - self.origin_m).max()))
        return max(self.extent_m, ends)


def blocker(meshes: Sequence[tuple[Floats, NDArray[np.int64]]], obstacle: int) -> Blocker:
    """One blocker out of (vertices, faces) that share the rest frame of an obstacle."""
    vertices = np.concatenate([mesh[0] for mesh in meshes])
    starts = np.cumsum([0] + [len(mesh[0]) for mesh in meshes[:-1]])
    faces = np.concatenate([mesh[1] + start for mesh, start in zip(meshes, starts, strict=True)])
    origin = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, (vertices - origin).astype(np.float32), faces.astype(np.int32))
    return Blocker(scene, obstacle, origin, float(np.abs(vertices - origin).max()))
