"""Putting obstacles in their places: moving, rotating, keeping apart, and setting a target in a walker's path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from obstaclewatch.support.arrays import Floats
from scenes.truth.swept import Body, Slab
from simulator.scene.scene import Obstacle


def placed(
    obstacle: Obstacle, at_m: ArrayLike, yaw_rad: float = 0.0, velocity_m_s: ArrayLike | None = None
) -> Obstacle:
    """A copy rotated counter-clockwise about the z axis, then moved in plan by (2,) m; None keeps its velocity."""
    cos, sin = np.cos(yaw_rad), np.sin(yaw_rad)
    rotation = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    vertices = np.asarray(obstacle.mesh.vertices) @ rotation.T + np.append(np.asarray(at_m, dtype=np.float64), 0.0)
    mesh = trimesh.Trimesh(vertices, obstacle.mesh.faces, process=False)
    velocity = obstacle.velocity_m_s if velocity_m_s is None else np.asarray(velocity_m_s, dtype=np.float64)
    return replace(obstacle, mesh=mesh, velocity_m_s=velocity)


def moved_back(obstacle: Obstacle, time_s: float) -> Obstacle:
    """Where the obstacle was some time ago: the same scene with its clock set back."""
    return placed(obstacle, -time_s * obstacle.velocity_m_s[:2]) if obstacle.moves else obstacle


@dataclass(frozen=True)
class Occupied:
    """A place that is taken.

    Attributes:
        slab: what of the obstacle lies below 3 m, in plan.
        velocity_m_s: (2,) of the obstacle.
    """

    slab: Slab
    velocity_m_s: Floats

    @classmethod
    def by(cls, obstacle: Obstacle) -> Occupied:
        """The place an obstacle takes."""
        return cls(Slab.of(obstacle.mesh, 0.0, 3.0), obstacle.velocity_m_s[:2])


def apart(obstacle: Obstacle, others: Sequence[Occupied], duration_s: float, gap_m: float) -> bool:
    """Whether the obstacle's bounding circle keeps a gap in plan from all the others while time runs to a duration."""
    low, high = obstacle.mesh.bounds[:, :2]
    center, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
    velocity, keep_m = obstacle.velocity_m_s[:2], radius + gap_m

    def clears(other: Occupied) -> bool:
        track = np.stack([center, center + duration_s * (velocity - other.velocity_m_s)])[None]
        return other.slab.far_from(track, keep_m) or bool(other.slab.distance(track)[0] >= keep_m)

    return all(clears(other) for other in others)


def extents(obstacle: Obstacle, direction: Floats, height_m: float) -> tuple[float, float]:
    """Least and greatest coordinate along a horizontal (2,) direction of the obstacle below a height, m."""
    along = Slab.of(obstacle.mesh, 0.0, height_m).triangle_m.reshape(-1, 2) @ direction
    return float(along.min()), float(along.max())


def lateral_shift(edge_m: float, side: float, extent_m: tuple[float, float]) -> float:
    """How far to shift an obstacle so that its near edge lies `edge_m` beyond the walker's line, on side +1 or -1."""
    low, high = extent_m
    return edge_m - low if side > 0 else -edge_m - high


def half_width_across(body: Body, heading_rad: float, travel_rad: float) -> tuple[float, float]:
    """Half the width of the walker's body across its travel, and how far its middle lies to the left of the phone, m.

    The direction of travel is relative to the target; for a moving target it is not the heading.
    """
    drift = heading_rad - travel_rad
    core = body.core(np.zeros((1, 3)), np.array([drift]))[0]
    across = core[:, 1]
    return body.half_width_m + 0.5 * float(np.ptp(across)), float(across.mean())


def distance_along(obstacle: Obstacle, start_m: Floats, lateral_m: Floats, ahead: Floats, distance_m: float) -> float:
    """How far ahead to put an obstacle, already shifted sideways, for a given distance in plan from the start, m.

    Raises:
        ValueError: it is further away than that wherever it is put.
    """
    slab = Slab.of(obstacle.mesh, 0.0, 3.0)

    def excess(along_m: ArrayLike) -> Floats:
        point = start_m - lateral_m - np.reshape(along_m, (-1, 1)) * ahead
        return slab.distance(np.stack([point, point], axis=1)) - distance_m

    reach = distance_m + float(np.linalg.norm(obstacle.mesh.bounds[:, :2], axis=1).max())
    grid = np.arange(-reach, reach + 0.5, 0.5)  # it may lie askew, its near end far ahead of its middle
    near = np.flatnonzero(excess(grid) <= 0.0)
    if len(near) == 0:
        raise ValueError(f"distance_m must be above the offset of '{obstacle.name}' from the line, got {distance_m}")
    return float(brentq(lambda along: excess(along)[0], grid[near[-1]], grid[near[-1] + 1], xtol=1e-9))
