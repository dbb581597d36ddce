"""Outlines from above: what of an obstacle stands between the ground and the walker's height, as closed lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from obstaclewatch.support.arrays import Floats
from scenes.preview.silhouette import silhouette
from scenes.truth.swept import Body, Slab
from simulator.scene.scene import Obstacle


@dataclass(frozen=True)
class Window:
    """A rectangle of the plan, m."""

    left: float
    right: float
    bottom: float
    top: float

    def __post_init__(self) -> None:
        if not (self.left < self.right and self.bottom < self.top):
            raise ValueError(f"a window must have left < right and bottom < top, got {self}")


@dataclass(frozen=True)
class PlanFrame:
    """A frame in plan: its origin in the world, and the direction of its first axis.

    Attributes:
        origin_m: (2,).
        heading_rad: counter-clockwise from the world's x.
    """

    origin_m: Floats
    heading_rad: float

    def of_world(self, points_m: Floats) -> Floats:
        """(..., 2) places in this frame of (..., 2) or (..., 3) places in the world."""
        return self.turned(np.asarray(points_m, dtype=np.float64)[..., :2] - self.origin_m)

    def turned(self, vectors_m: Floats) -> Floats:
        """(..., 2) components in this frame of (..., 2) vectors."""
        cos, sin = np.cos(self.heading_rad), np.sin(self.heading_rad)
        turned: Floats = vectors_m @ np.array([[cos, -sin], [sin, cos]])
        return turned


def outline(obstacle: Obstacle, frame: PlanFrame, window: Window) -> list[Floats]:
    """Closed lines (K, 2), in the frame, around what of the obstacle lies in the window at time 0; none if nothing."""
    triangle_m = frame.of_world(Slab.of(obstacle.mesh, 0.0, Body().height_m).triangle_m)
    if len(triangle_m) == 0:
        return []
    seen = silhouette(triangle_m).intersection(shapely.box(window.left, window.bottom, window.right, window.top))
    borders = [ring for part in shapely.get_parts(seen) for ring in shapely.get_rings(part)]
    return [shapely.get_coordinates(ring) for ring in borders]
