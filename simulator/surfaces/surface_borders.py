"""Where a smooth surface ends: at an angle, as at the rim of a bin, or tangentially in a panel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import norm
from simulator.surfaces.reflectors import MeshReading, SmoothSurface

STEP_M = 0.05  # between points of a border


@dataclass(frozen=True)
class Border:
    """The border of a smooth surface in points, rest frame.

    Attributes:
        point_m: (B, 3).
        normal: (B, 3) unit normals of the smooth surface there.
        across: (B, 3) unit vectors in the surface at right angles to the border.
        bend_1_m, lost_1_m: (B,) curvature along the border and across it, 1/m.
        tangent: (B,) whether the surface runs on smoothly as a plane: only its curvature ends.
    """

    point_m: Floats
    normal: Floats
    across: Floats
    bend_1_m: Floats
    lost_1_m: Floats
    tangent: Flags

    def __len__(self) -> int:
        return len(self.point_m)


def border_of(reading: MeshReading, surface: SmoothSurface) -> Border:
    """The border of the smooth surface of a mesh, panels that it runs into included."""
    facet, side = np.nonzero(surface.neighbor == -1)
    here, there = side, (side + 1) % 3
    start, end = surface.corner_m[facet, here], surface.corner_m[facet, there]
    count = np.maximum(np.ceil(norm(end - start) / STEP_M), 1.0).astype(np.int64)
    edge = np.repeat(np.arange(len(facet)), count)
    share = ((np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[edge])[:, None]
    ends = facet[edge], here[edge], there[edge]
    normal = _unit((1.0 - share) * surface.normal[ends[0], ends[1]] + share * surface.normal[ends[0], ends[2]])
    along = _unit(end[edge] - start[edge])
    bend = 0.5 * (surface.curvature[ends[0], ends[1]] + surface.curvature[ends[0], ends[2]])
    across = _unit(np.cross(normal, along))
    return Border(
        (1.0 - share) * start[edge] + share * end[edge], normal, across,
        np.einsum("bi,bij,bj->b", along, bend, along), np.einsum("bi,bij,bj->b", across, bend, across),
        _smooth(reading)[facet[edge], side[edge]],
    )  # fmt: skip


def _smooth(reading: MeshReading) -> Flags:
    """(T, 3) sides 01, 12, 20 of the curved facets across which the surface goes on, if only as a plane."""
    faces = np.flatnonzero(reading.curved)
    count = len(reading.mesh.vertices)
    joined = _rows_in(reading.mesh.face_adjacency, reading.smooth_edges, len(reading.mesh.faces))
    shared = np.sort(reading.mesh.face_adjacency_edges[joined], axis=1).astype(np.int64)
    known = shared[:, 0] * count + shared[:, 1]
    corner = reading.mesh.faces[faces]
    sides = np.sort(np.stack([corner, np.roll(corner, -1, axis=1)], axis=2), axis=2)
    return np.isin(sides[:, :, 0] * count + sides[:, :, 1], known)


def _rows_in(pairs: Ints, some: Ints, count: int) -> Flags:
    """(P,) pairs that are among some."""
    pairs, some = np.sort(pairs, axis=1).astype(np.int64), np.sort(some, axis=1).astype(np.int64)
    return np.isin(pairs[:, 0] * count + pairs[:, 1], some[:, 0] * count + some[:, 1])


def _unit(vector: Floats) -> Floats:
    return vector / np.maximum(norm(vector)[..., None], 1e-300)
