"""How a source and a receiver see a straight edge where it stands: cylindrical coordinates, the apex, path lengths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.rows import Rows
from simulator.surfaces.wedges import Wedges
from simulator.world.visibility import COINCIDENT_M
from simulator.world.world import Tracing

APEX, START, END = 0, 1, 2  # the three contributions of an edge
ON_FACE_RAD = 1e-9  # a source this close to a face's plane by rounding stands on it


@dataclass(frozen=True)
class EdgeView(Rows):
    """R edges, each with one source and one receiver, in cylindrical coordinates about the edge.

    Attributes:
        source_radius_m, receiver_radius_m: (R,) distances from the line of the edge, positive.
        source_angle_rad, receiver_angle_rad: (R,) from face 0 through the open space, 0 to `open_angle_rad`; inside the
            edge negative or greater, by the nearer face.
        source_height_m, receiver_height_m: (R,) along the edge, from its start.
        length_m: (R,) of the edge.
        open_angle_rad: (R,) between the faces through the open space, 2 pi / 3 to 2 pi.
    """

    source_radius_m: Floats
    source_angle_rad: Floats
    source_height_m: Floats
    receiver_radius_m: Floats
    receiver_angle_rad: Floats
    receiver_height_m: Floats
    length_m: Floats
    open_angle_rad: Floats

    @property
    def apex_height_m(self) -> Floats:
        """(R,) where the shortest path meets the line of the edge."""
        total = self.source_radius_m + self.receiver_radius_m
        slope = (self.receiver_height_m - self.source_height_m) / total
        return self.source_height_m + slope * self.source_radius_m

    @property
    def apex_path_m(self) -> Floats:
        """(R,) the shortest path over the line of the edge, L0."""
        total = self.source_radius_m + self.receiver_radius_m
        return np.hypot(total, self.receiver_height_m - self.source_height_m)

    def has(self, part: int) -> Flags:
        """(R,) whether a contribution exists: the ends always do, the apex if it lies on the edge."""
        if part != APEX:
            return np.ones(len(self), dtype=bool)
        return (self._eta(np.zeros(len(self))) < 0.0) & (self._eta(self.length_m) >= 0.0)

    def excess(self, part: Ints | int) -> Floats:
        """(R,) u = +-sqrt(L - L0) of contributions, or of one, m^(1/2), negative below the apex; 0 at the apex."""
        if np.ndim(part) == 0 and part == APEX:
            return np.zeros(len(self))
        eta = np.where(part == APEX, 0.0, self._eta(np.where(part == END, self.length_m, 0.0)))
        product = self.source_radius_m * self.receiver_radius_m
        rise2 = 4.0 * product * np.sinh(0.5 * eta) ** 2  # L^2 - L0^2
        shortest = self.apex_path_m
        return np.sign(eta) * np.sqrt(rise2 / (shortest + np.sqrt(shortest**2 + rise2)))

    def path_m(self, part: Ints) -> Floats:
        """(R,) length of the path over the apex or an end."""
        return self.apex_path_m + self.excess(part) ** 2

    def _eta(self, height_m: Floats) -> Floats:
        from_source = np.arcsinh((height_m - self.source_height_m) / self.source_radius_m)
        return from_source + np.arcsinh((height_m - self.receiver_height_m) / self.receiver_radius_m)


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


def this_side(view: EdgeView, sheet_m: Floats) -> Flags:
    """(R,) whether both are off the edge's line, and on this side of a plate so thick."""
    rise = view.source_radius_m * np.sin(view.source_angle_rad)
    rise = rise + view.receiver_radius_m * np.sin(view.receiver_angle_rad)
    apart = np.minimum(view.source_radius_m, view.receiver_radius_m) > COINCIDENT_M
    return np.asarray((rise + sheet_m > 0.0) & apart)
