"""Sharp edges where they stand at poses, and points about them in their cylindrical coordinates."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.diffraction.edge_view import EdgeView
from simulator.surfaces.wedges import Wedges
from simulator.world.world import Tracing

ON_FACE_RAD = 1e-9  # a source this close to a face's plane by rounding stands on it


def at_poses(tracing: Tracing, wedge: Ints, pose: Ints) -> Wedges:
    """(R,) edges where they stand at poses (R,)."""
    return tracing.wedges[row_of(tracing, wedge, pose)]


def row_of(tracing: Tracing, wedge: Ints, pose: Ints) -> Ints:
    """(R,) rows of edges at poses among `Tracing.wedges`."""
    return pose * len(tracing.world.wedges) + wedge


def seen(wedges: Wedges, source_m: Floats, receiver_m: Floats) -> EdgeView:
    """Cylindrical coordinates of sources and receivers (R, 3) about edges, as `cylindrical` counts angles."""
    every = np.arange(len(wedges.start_m))
    coordinates = [cylindrical(wedges, every, point) for point in (source_m, receiver_m)]
    return EdgeView(*coordinates[0], *coordinates[1], wedges.length_m, wedges.open_angle_rad)


def cylindrical(wedges: Wedges, row: Ints, point_m: Floats) -> tuple[Floats, Floats, Floats]:
    """(R,) distance from the line of the edge in a row, angle from face 0 over its normal, height above the start.

    What lies inside the edge counts from the nearer face: it has a negative angle, or one beyond the open angle.
    """
    offset = point_m - wedges.start_m.take(row, axis=0)
    axes = (each.take(row, axis=0) for each in (wedges.inwards, wedges.normal, wedges.along))
    x, y, height = (offset[:, 0] * axis[:, 0] + offset[:, 1] * axis[:, 1] + offset[:, 2] * axis[:, 2] for axis in axes)
    angle = np.mod(np.arctan2(y, x), 2.0 * np.pi)
    angle = np.where(2.0 * np.pi - angle < ON_FACE_RAD, 0.0, angle)
    turn = wedges.open_angle_rad.take(row)
    angle = np.where(angle < 0.5 * turn + np.pi, angle, angle - 2.0 * np.pi)
    beyond = angle - turn
    return np.hypot(x, y), np.where((beyond > 0.0) & (beyond < ON_FACE_RAD), turn, angle), height
