"""Convex creases of a body's smooth surface, such as the rim of a bin: where two of its faces meet at an angle.

They are curved in general, and cut into straight elements on the rounded surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.repeated import repeated
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import unit
from simulator.surfaces import quadratic_triangles as nagata
from simulator.surfaces.reflectors import MeshReading, SmoothSurface

INTO_M = 1e-3  # into a face from its edge, where its facet is looked for
TURN_M = 0.1  # normals that differ by one weigh as much as points this far apart in that


@dataclass(frozen=True)
class Creases(Rows):
    """Straight elements of E creases in the rest frame of their obstacle.

    Attributes:
        middle_m: (E, 3).
        along_m: (E, 3) from start to end.
        inwards: (E, 3) unit vector from the edge into face 0, at right angles to it.
        normal: (E, 3) unit normal of face 0; angles run from `inwards` over `normal`.
        open_angle_rad: (E,) from face 0 through the open space to face 1: more than pi.
        beside: (E, 2) the facet of the body's skin next to the element on face 0 and on face 1.
        share: (E,) of its wave that each pair of ends brings: all, or less where face 1 is a mirror image of face 0.
    """

    middle_m: Floats
    along_m: Floats
    inwards: Floats
    normal: Floats
    open_angle_rad: Floats
    beside: Ints
    share: Floats


def no_creases() -> Creases:
    """An empty set."""
    none = np.zeros((0, 3))
    return Creases(none, none, none, none, np.zeros(0), np.zeros((0, 2), np.int64), np.zeros(0))


def creases_of(
    reading: MeshReading, surface: SmoothSurface | None, middle_m: Floats, normal: Floats, size_m: float
) -> Creases:
    """Convex creases at which a smooth surface ends; creases between planes are edges of another mechanism.

    Args:
        reading, surface: of the obstacle.
        middle_m, normal: (F, 3) of the facets of its skin.
        size_m: greatest length of an element.
    """
    facet, local, other = _crease_edges(reading, surface)
    if surface is None or len(facet) == 0:
        return no_creases()
    owner, begin, end = _cut(surface, facet, local, size_m)
    (start_m, _), (end_m, _) = (_at(surface, facet[owner], place) for place in (begin, end))
    on_edge, first = _at(surface, facet[owner], 0.5 * (begin + end))
    along = end_m - start_m
    tangent = along / np.linalg.norm(along, axis=1, keepdims=True)
    first = unit(first - np.sum(first * tangent, axis=1)[:, None] * tangent)
    second = _other_normal(reading, surface, other[owner], on_edge)
    second = unit(second - np.sum(second * tangent, axis=1)[:, None] * tangent)
    inwards = _into(tangent, first, second)
    bend = np.arccos(np.clip(np.sum(first * second, axis=1), -1.0, 1.0))
    into_second = _into(tangent, second, first)
    tree = cKDTree(np.concatenate([middle_m, TURN_M * normal], axis=1))
    beside = [
        tree.query(np.concatenate([on_edge + INTO_M * into, TURN_M * face], axis=1))[1]
        for into, face in ((inwards, first), (into_second, second))
    ]
    share = np.ones(len(along))
    return Creases(0.5 * (start_m + end_m), along, inwards, first, np.pi + bend, np.stack(beside, axis=1), share)


def convex_creases(reading: MeshReading) -> Ints:
    """Rows of the mesh's pairs of faces that meet in a convex crease at which its smooth surface ends."""
    pair = np.asarray(reading.mesh.face_adjacency)
    creased = reading.curved[pair].any(axis=1) & ~reading.rim[pair].any(axis=1) & reading.mesh.face_adjacency_convex
    key = np.sort(pair, axis=1) @ [len(reading.mesh.faces), 1]
    smooth = np.sort(reading.smooth_edges, axis=1) @ [len(reading.mesh.faces), 1]
    return np.flatnonzero(creased & ~np.isin(key, smooth) & reading.closed)


def _crease_edges(reading: MeshReading, surface: SmoothSurface | None) -> tuple[Ints, Ints, Ints]:
    """(C,) facet of the smooth surface at each crease, (C, 2) its corners there, (C,) facet of the mesh beyond."""
    mesh = reading.mesh
    pair = np.asarray(mesh.face_adjacency)
    rows = convex_creases(reading) if surface is not None else np.zeros(0, dtype=np.int64)
    mine = np.where(reading.curved[pair[rows, 0]], 0, 1)
    facet, other = pair[rows, mine], pair[rows, 1 - mine]
    corners = np.asarray(mesh.faces)[facet]
    local = np.stack([np.argmax(corners == vertex[:, None], axis=1) for vertex in mesh.face_adjacency_edges[rows].T], 1)
    smooth_index = np.cumsum(reading.curved) - 1
    return smooth_index[facet], local, other


def _cut(surface: SmoothSurface, facet: Ints, local: Ints, size_m: float) -> tuple[Ints, Floats, Floats]:
    """(E,) crease of each element, and (E, 2) places of its start and end in the crease's facet."""
    ends = _CORNERS[local]
    length = np.linalg.norm(surface.corner_m[facet, local[:, 0]] - surface.corner_m[facet, local[:, 1]], axis=1)
    count = np.maximum(1, np.ceil(length / size_m)).astype(np.int64)
    owner, step = repeated(count)
    share = [((step + k) / count[owner])[:, None] for k in (0, 1)]
    begin, end = ((1.0 - s) * ends[owner, 0] + s * ends[owner, 1] for s in share)
    return owner, begin, end


_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])  # (eta, zeta) of a Nagata triangle's corners


def _at(surface: SmoothSurface, facet: Ints, place: Floats) -> tuple[Floats, Floats]:
    """(E, 3) points and unit normals of the rounded surface."""
    return nagata.rounded(surface.corner_m, surface.normal, surface.bulge_m, facet, np.ascontiguousarray(place))


def _other_normal(reading: MeshReading, surface: SmoothSurface, facet: Ints, point_m: Floats) -> Floats:
    """(E, 3) normals of the facets beyond the creases: of the rounded surface where they are curved as well."""
    normal = np.array(reading.mesh.face_normals)[facet]
    rows = np.flatnonzero(reading.curved[facet])
    smooth = (np.cumsum(reading.curved) - 1)[facet[rows]]
    nearest = np.linalg.norm(surface.corner_m[smooth] - point_m[rows, None], axis=2)
    weight = 1.0 / np.maximum(nearest, 1e-9)
    weight[np.arange(len(rows)), np.argmax(nearest, axis=1)] = 0.0  # the corner off the crease
    normal[rows] = np.sum(weight[:, :, None] * surface.normal[smooth], axis=1)
    return normal


def _into(tangent: Floats, normal: Floats, beyond: Floats) -> Floats:
    """(E, 3) unit vectors across the edge in the plane of a normal, away from where the surface beyond looks."""
    across = np.cross(tangent, normal)
    return -np.sign(np.sum(across * beyond, axis=1))[:, None] * across
