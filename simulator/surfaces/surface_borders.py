"""Where a smooth surface ends, at an angle or tangentially in a panel, and where its curvature changes within it.

The rim of a bin is of the first kind, what a rounded corner runs into of the second, the ring between a post and its
dome of the third. Planes that end at a smooth surface, such as the face of a drum, end there as it does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.repeated import repeated
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import dot, norm, unit
from simulator.meshes.pieces import components
from simulator.surfaces.reflectors import MeshReading, SmoothSurface

STEP_M = 0.05  # between points of a border
CHANGE = 0.5  # of the greater of two curvatures: beyond what cutting a smooth surface into facets makes
LEAST_1_M = 0.5  # change that matters: it moves the border of a Fresnel zone of 0.1 m by a seventh of the wavelength


@dataclass(frozen=True)
class Border(Rows):
    """Borders of a smooth surface, or of the planes that end at it, in points, rest frame.

    Attributes:
        point_m: (B, 3).
        length_m: (B,) of the part of the border that a point stands for.
        normal: (B, 3) unit normals of the surface there.
        across: (B, 3) unit vectors in the surface at right angles to the border.
        bend_1_m, lost_1_m: (B,) curvature along the border, and that across it which ends there, 1/m.
        tangent: (B,) whether the surface runs on smoothly: only its curvature ends.
        piece: (B,) which points hang together: the rims at either end of a post do not.
    """

    point_m: Floats
    length_m: Floats
    normal: Floats
    across: Floats
    bend_1_m: Floats
    lost_1_m: Floats
    tangent: Flags
    piece: Ints


def borders_of(reading: MeshReading, surface: SmoothSurface) -> tuple[Border, ...]:
    """The borders of the smooth surface of a mesh, panels that it runs into included, those within, and those of planes
    that end at it, each in one piece."""
    found = _around(reading, surface), _within(surface), _of_planes(reading)
    return tuple(border[border.piece == piece] for border in found for piece in np.unique(border.piece))


def _around(reading: MeshReading, surface: SmoothSurface) -> Border:
    """Where the surface ends."""
    facet, side = np.nonzero(surface.neighbor == -1)
    bend = surface.curvature[facet, side] + surface.curvature[facet, (side + 1) % 3]
    across = _across(surface, facet, side)
    lost = 0.5 * np.einsum("bi,bij,bj->b", across, bend, across)
    return _in_points(surface, facet, side, lost, _smooth(reading)[facet, side])


def _within(surface: SmoothSurface) -> Border:
    """Where the curvature across an edge of the mesh changes by a good part of itself."""
    facet, side = np.nonzero(surface.neighbor > np.arange(len(surface.neighbor))[:, None])
    other = surface.neighbor[facet, side]
    back = np.argmax(surface.neighbor[other] == facet[:, None], axis=1)
    here, there = _bend_across(surface, facet, side), _bend_across(surface, other, back)
    change, most = np.abs(here - there), np.maximum(np.abs(here), np.abs(there))
    rows = np.flatnonzero((change > CHANGE * most) & (change > LEAST_1_M))
    return _in_points(surface, facet[rows], side[rows], change[rows], np.ones(len(rows), dtype=bool))


def _of_planes(reading: MeshReading) -> Border:
    """Where planes end at the smooth surface, at an angle."""
    mesh = reading.mesh
    facets = np.concatenate([mesh.face_adjacency, mesh.face_adjacency[:, ::-1]])
    sharp = ~_rows_in(facets, reading.smooth_edges, len(mesh.faces))
    rows = np.flatnonzero(sharp & (reading.patch[facets[:, 0]] >= 0) & reading.curved[facets[:, 1]])
    ends = np.tile(mesh.face_adjacency_edges, (2, 1))[rows]
    start, end = (np.asarray(mesh.vertices)[each] for each in ends.T)
    edge, share, length_m = _divided(start, end)
    normal = np.asarray(mesh.face_normals)[facets[rows[edge], 0]]
    flat, along = np.zeros(len(edge)), (end - start)[edge]
    return Border(
        start[edge] + share * along, length_m, normal, unit(np.cross(normal, along)), flat, flat,
        np.zeros(len(edge), dtype=bool), _pieces(start, end)[edge],
    )  # fmt: skip


def _divided(start: Floats, end: Floats) -> tuple[Ints, Floats, Floats]:
    """Edges from (E, 3) to (E, 3) in points: (B,) the edge of each, (B, 1) how far along it is, (B,) its length."""
    length = norm(end - start)
    count = np.maximum(np.ceil(length / STEP_M), 1.0).astype(np.int64)
    edge, point = repeated(count)
    share = (point + 0.5) / count[edge]
    return edge, share[:, None], (length / count)[edge]


def _bend_across(surface: SmoothSurface, facet: Ints, side: Ints) -> Floats:
    """(E,) curvature of facets (E,) at right angles to their sides (E,), from the normals at their corners, 1/m."""
    one, other, third = (side + k for k in range(3))
    start, end, apex = (surface.corner_m[facet, each % 3] for each in (one, other, third))
    normals = [surface.normal[facet, each % 3] for each in (one, other, third)]
    share = dot(apex - start, end - start) / dot(end - start, end - start)
    foot = start + share[:, None] * (end - start)
    at_foot = normals[0] + share[:, None] * (normals[1] - normals[0])
    reach = apex - foot
    bend: Floats = dot(normals[2] - at_foot, reach) / dot(reach, reach)
    return bend


def _across(surface: SmoothSurface, facet: Ints, side: Ints) -> Floats:
    """(E, 3) unit vectors in the surface at right angles to sides (E,) of facets."""
    start, end = surface.corner_m[facet, side], surface.corner_m[facet, (side + 1) % 3]
    normal = surface.normal[facet, side] + surface.normal[facet, (side + 1) % 3]
    return unit(np.cross(normal, end - start))


def _in_points(surface: SmoothSurface, facet: Ints, side: Ints, lost_1_m: Floats, tangent: Flags) -> Border:
    """Sides (E,) of facets in points."""
    here, there = side, (side + 1) % 3
    start, end = surface.corner_m[facet, here], surface.corner_m[facet, there]
    edge, share, length_m = _divided(start, end)
    ends = facet[edge], here[edge], there[edge]
    normal = unit((1.0 - share) * surface.normal[ends[0], ends[1]] + share * surface.normal[ends[0], ends[2]])
    along = unit(end[edge] - start[edge])
    bend = 0.5 * (surface.curvature[ends[0], ends[1]] + surface.curvature[ends[0], ends[2]])
    return Border(
        (1.0 - share) * start[edge] + share * end[edge], length_m, normal, unit(np.cross(normal, along)),
        np.einsum("bi,bij,bj->b", along, bend, along), lost_1_m[edge], tangent[edge], _pieces(start, end)[edge],
    )  # fmt: skip


def _pieces(start: Floats, end: Floats) -> Ints:
    """(E,) label of what edges from (E, 3) to (E, 3) hang together with."""
    corner = np.unique(np.concatenate([start, end]), axis=0, return_inverse=True)[1].reshape(2, -1).T
    return components(corner, len(corner) and int(corner.max()) + 1)[corner[:, 0]]


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
