"""Outlines from above: what of an obstacle stands between the ground and the walker's height, as closed lines.

The convex pieces that ground truth collides with are painted on a grid and its borders followed: exact to some
centimetres, which is what a picture needs, whatever the mesh is like.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import contourpy
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from obstaclewatch.support.arrays import Floats
from scenes.truth.swept import Body, Slab
from simulator.scene.scene import Obstacle

CELL_M = 0.01
SLACK_M = 0.012
"""How far a corner may lie off the straight line between its neighbours and be left out."""


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
    slab = Slab.of(obstacle.mesh, 0.0, Body().height_m)
    pieces = [corners for corners in frame.of_world(slab.triangle_m) if _touches(corners, window)]
    if not pieces:
        return []
    mask, corner_m = _painted(pieces, window)
    lines = cast(list[Floats], contourpy.contour_generator(z=mask, line_type="Separate").lines(0.5))
    return [simplified(corner_m + CELL_M * line, SLACK_M) for line in lines]


def simplified(line_m: Floats, slack_m: float) -> Floats:
    """The line (K, 2) without the points that lie within the slack of what is left (Douglas and Peucker, 1973)."""
    if len(line_m) < 3:
        return line_m
    along = line_m[-1] - line_m[0]
    length = np.hypot(*along)
    offset = line_m - line_m[0]
    away = np.hypot(*offset.T) if length == 0.0 else np.abs(offset @ [-along[1], along[0]]) / length
    far = int(np.argmax(away))
    if away[far] <= slack_m:
        return line_m[[0, -1]]
    return np.concatenate([simplified(line_m[: far + 1], slack_m)[:-1], simplified(line_m[far:], slack_m)])


def _touches(corners_m: Floats, window: Window) -> bool:
    (left, bottom), (right, top) = corners_m.min(axis=0), corners_m.max(axis=0)
    return bool(left < window.right and right > window.left and bottom < window.top and top > window.bottom)


def _painted(pieces: list[Floats], window: Window) -> tuple[NDArray[np.uint8], Floats]:
    """A grid with a free border that holds 1 where a piece lies, and the place of its first cell."""
    points = np.concatenate(pieces)
    low = np.maximum(points.min(axis=0), [window.left, window.bottom])
    high = np.minimum(points.max(axis=0), [window.right, window.top])
    corner_m = low - CELL_M
    columns, rows = (np.ceil((high - low) / CELL_M).astype(int) + 3).tolist()
    image = Image.new("L", (columns, rows), 0)
    draw = ImageDraw.Draw(image)
    for piece in pieces:
        cells = np.rint((piece - corner_m) / CELL_M)
        draw.polygon([(int(x), int(y)) for x, y in cells], fill=1, outline=1)
    mask = np.array(image)
    mask[[0, -1]] = 0
    mask[:, [0, -1]] = 0
    return mask, corner_m
