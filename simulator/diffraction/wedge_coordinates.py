"""Sharp edges where they stand at poses, and points about them in their cylindrical coordinates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.diffraction.edge_view import EdgeView
from simulator.surfaces.wedges import Wedges
from simulator.world.frames import out_of_rest, rotated
from simulator.world.world import Tracing

ON_FACE_RAD = 1e-9  # a source this close to a face's plane by rounding stands on it


def at_poses(tracing: Tracing, wedge: Ints, pose: Ints) -> Wedges:
    """(R,) edges where they stand at poses (R,)."""
    return placed(tracing, wedge, tracing.placed[pose, tracing.world.wedges.obstacle[wedge]])


def placed(tracing: Tracing, wedge: Ints, frame: Floats) -> Wedges:
    """(R,) edges in frames (R, 4) of their obstacles, world coordinates."""
    rest = tracing.world.wedges[wedge]
    return replace(
        rest, start_m=out_of_rest(rest.start_m, frame), end_m=out_of_rest(rest.end_m, frame),
        inwards=rotated(rest.inwards, frame[:, 3]), normal=rotated(rest.normal, frame[:, 3]),
    )  # fmt: skip


def seen(wedges: Wedges, source_m: Floats, receiver_m: Floats) -> EdgeView:
    """Cylindrical coordinates of sources and receivers (R, 3) about edges; angles beyond the open side lie inside."""
    coordinates = [cylindrical(wedges, point) for point in (source_m, receiver_m)]
    return EdgeView(*coordinates[0], *coordinates[1], wedges.length_m, wedges.open_angle_rad)


def cylindrical(wedges: Wedges, point_m: Floats) -> tuple[Floats, Floats, Floats]:
    """(R,) distance from the edge's line, angle from face 0 over its normal, height above the start."""
    along = (wedges.end_m - wedges.start_m) / wedges.length_m[:, None]
    offset = point_m - wedges.start_m
    x, y = np.sum(offset * wedges.inwards, axis=1), np.sum(offset * wedges.normal, axis=1)
    angle = np.mod(np.arctan2(y, x), 2.0 * np.pi)
    angle = np.where(2.0 * np.pi - angle < ON_FACE_RAD, 0.0, angle)
    beyond = angle - wedges.open_angle_rad
    angle = np.where((beyond > 0.0) & (beyond < ON_FACE_RAD), wedges.open_angle_rad, angle)
    return np.hypot(x, y), angle, np.sum(offset * along, axis=1)
