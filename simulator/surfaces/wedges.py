"""Sharp edges of meshes: creases between planar patches, free borders of sheets, rims of thin plates.

Round every edge of the mesh its facets fan out; where the widest gap between two of them exceeds a half turn, the
edge is a wedge that diffracts into that gap. Edges in one line between the same patches are one wedge, whatever the
triangles. Creases towards smooth surfaces are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import trimesh

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import dot, norm
from simulator.meshes.pieces import components
from simulator.meshes.planar_regions import PLANE_FIT_M
from simulator.surfaces.reflectors import MeshReading

FLAT_RAD = 1e-6
BLUNT_RAD = 2e-3  # an edge this flat diffracts nothing that matters: its facets count as one plane
STRAIGHT = 1e-8  # 1 - cosine between segments of one line: 1.4e-4 rad


@dataclass(frozen=True)
class Wedges(Rows):
    """Straight sharp edges in the rest frames of their obstacles.

    Attributes:
        start_m, end_m: (W, 3).
        inwards: (W, 3) unit vector from the edge into face 0, at right angles to the edge.
        normal: (W, 3) unit normal of face 0 on the open side; angles run from `inwards` over `normal`.
        open_angle_rad: (W,) from face 0 through the open space to the last face: pi to 2 pi, 2 pi / 3 to 2 pi where a
            face meets its own mirror image.
        patch: (W, 2) planar patches of face 0 and of the last face; the same one twice at a free border.
        obstacle: (W,) index of the obstacle.
        sheet_m: (W,) for the rim of a thin plate, its thickness; infinite for all others. A plate has one such edge
            on either face, of which the one nearer to source and receiver counts.
        radiates: (W, 2) whether the start and the end are corners; where the edge runs into another surface the
            image in that surface continues it, and the end is none.
        mirror: (W,) patch in which face 0 meets its own image, so that the other face is that image; -1 for all others.
        leans_on: (W, 2) patch into which the edge runs at its start and its end other than squarely, so that it makes a
            corner with its image; -1 where it does not.
    """

    start_m: Floats
    end_m: Floats
    inwards: Floats
    normal: Floats
    open_angle_rad: Floats
    patch: Ints
    obstacle: Ints
    sheet_m: Floats
    radiates: Flags
    mirror: Ints
    leans_on: Ints

    @property
    def length_m(self) -> Floats:
        """(W,) of each edge."""
        return norm(self.end_m - self.start_m)

    @property
    def along(self) -> Floats:
        """(W, 3) unit vectors from start to end."""
        return (self.end_m - self.start_m) / self.length_m[:, None]

    def direction_at(self, angle_rad: Floats) -> Floats:
        """(W, 3) unit vectors at right angles to the edges, at (W,) angles from face 0 through the open space."""
        angle = angle_rad[:, None]
        return np.cos(angle) * self.inwards + np.sin(angle) * self.normal

    @property
    def open_sides(self) -> Floats:
        """(W, 2, 3) unit normals of face 0 and of the last face on the open side."""
        turn = self.open_angle_rad[:, None]
        return np.stack([self.normal, np.sin(turn) * self.inwards - np.cos(turn) * self.normal], axis=1)

    @property
    def flat(self) -> Flags:
        """(W,) whether both faces lie in one plane, as at the border of a sheet."""
        return self.open_angle_rad > 2.0 * np.pi - FLAT_RAD

    @property
    def free_angle_rad(self) -> Floats:
        """(W,) the open angle without images: up to the mirror on which a face stands."""
        return np.where(self.mirror >= 0, 0.5, 1.0) * self.open_angle_rad


def no_wedges() -> Wedges:
    """An empty set."""
    none = np.zeros((0, 3))
    return Wedges(
        none, none, none, none, np.zeros(0), np.zeros((0, 2), np.int64), np.zeros(0, np.int64), np.zeros(0),
        np.zeros((0, 2), dtype=bool), np.zeros(0, np.int64), np.zeros((0, 2), np.int64),
    )  # fmt: skip


def merge_wedges(parts: list[Wedges]) -> Wedges:
    """All parts as one set, in order."""
    return Wedges.joined([no_wedges(), *parts])


def wedges_of(reading: MeshReading) -> Wedges:
    """Sharp edges of a mesh, with its own patches and as obstacle 0."""
    if not (reading.patch >= 0).any():
        return no_wedges()
    edge, face = _fans(reading)
    return _in_line(merge_wedges([_fan_wedges(reading, edge, face), _rim_wedges(reading, edge, face)]))


def _fans(reading: MeshReading) -> tuple[Ints, Ints]:
    """(F, 2) vertex pairs of edges where a patch ends, and (F, K) the facets round each, -1 padded."""
    mesh = reading.mesh
    pairs = np.sort(np.asarray(mesh.faces)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    key = pairs[:, 0].astype(np.int64) * len(mesh.vertices) + pairs[:, 1]
    order = np.argsort(key, kind="stable")
    _, first, which, count = np.unique(key[order], return_index=True, return_inverse=True, return_counts=True)
    fan = np.full((len(first), count.max()), -1)
    fan[which, np.arange(len(order)) - first[which]] = order // 3
    patch = np.where(fan >= 0, reading.patch[fan], -2)
    inner = (count == 2) & (patch[:, 0] == patch[:, min(1, patch.shape[1] - 1)])
    return pairs[order[first]][~inner], fan[~inner]


def _fan_wedges(reading: MeshReading, edge: Ints, fan: Ints) -> Wedges:
    """Wedges in the widest gap between planar facets."""
    planar = ((fan < 0) | (reading.patch[fan] >= 0)).all(axis=1)
    edge, fan = edge[planar], fan[planar]
    if len(edge) == 0:
        return no_wedges()
    along, inwards = _directions(reading.mesh, edge, fan)
    across = np.cross(along[:, None], inwards[:, :1])[:, 0]
    turn = np.arctan2(np.einsum("fkx,fx->fk", inwards, across), np.einsum("fkx,fx->fk", inwards, inwards[:, 0]))
    turn = np.where(fan >= 0, np.mod(turn, 2.0 * np.pi), np.inf)
    order = np.argsort(turn, axis=1, kind="stable")
    turn = np.take_along_axis(turn, order, axis=1)
    every, size = np.arange(len(fan)), (fan >= 0).sum(axis=1)
    following = np.concatenate([turn[:, 1:], np.full((len(fan), 1), np.inf)], axis=1)
    following[every, size - 1] = turn[:, 0] + 2.0 * np.pi
    gap = np.where(np.isfinite(turn), following - np.where(np.isfinite(turn), turn, 0.0), -1.0)
    widest = np.argmax(gap, axis=1)
    first, last = order[every, widest], order[every, (widest + 1) % size]
    inwards = inwards[every, first]
    normal = np.cross(along, inwards)
    outside = dot(reading.mesh.face_normals[fan[every, first]], normal) > 0.0
    sharp = (gap[every, widest] > np.pi + BLUNT_RAD) & (outside | (not reading.closed))
    patch = np.stack([reading.patch[fan[every, first]], reading.patch[fan[every, last]]], axis=1)
    return _wedges(
        reading.mesh, edge[sharp], inwards[sharp], normal[sharp], gap[every, widest][sharp], patch[sharp],
        np.full(int(sharp.sum()), np.inf),
    )  # fmt: skip


def _rim_wedges(reading: MeshReading, edge: Ints, fan: Ints) -> Wedges:
    """Edges of thin plates: where a plate's face meets its rim, a sheet's border in the plane of that face."""
    if not reading.rim.any():
        return no_wedges()
    plate = (fan >= 0) & (reading.patch[fan] >= 0) & (reading.sheet_m[fan] > 0.0)
    rim = (fan >= 0) & reading.rim[fan]
    rows = np.flatnonzero((plate.sum(axis=1) == 1) & (rim.sum(axis=1) == 1) & ((fan >= 0).sum(axis=1) == 2))
    face = fan[rows, np.argmax(plate[rows], axis=1)]
    _, inwards = _directions(reading.mesh, edge[rows], face[:, None])
    patch = np.stack([reading.patch[face]] * 2, axis=1)
    return _wedges(
        reading.mesh, edge[rows], inwards[:, 0], reading.mesh.face_normals[face], np.full(len(rows), 2.0 * np.pi),
        patch, reading.sheet_m[face],
    )  # fmt: skip


def _directions(mesh: trimesh.Trimesh, edge: Ints, fan: Ints) -> tuple[Floats, Floats]:
    """(F, 3) unit vectors along edges, (F, K, 3) unit vectors from them into each facet at right angles."""
    start, end = mesh.vertices[edge[:, 0]], mesh.vertices[edge[:, 1]]
    along = (end - start) / norm(end - start)[..., None]
    corners = mesh.vertices[mesh.faces[fan]] - start[:, None, None]
    off = corners - np.einsum("fkcx,fx->fkc", corners, along)[..., None] * along[:, None, None]
    opposite = np.argmax(norm(off), axis=2)
    inwards = np.take_along_axis(off, opposite[:, :, None, None], axis=2)[:, :, 0]
    return along, inwards / norm(inwards)[..., None]


def _wedges(
    mesh: trimesh.Trimesh, edge: Ints, inwards: Floats, normal: Floats, open_angle_rad: Floats, patch: Ints,
    sheet_m: Floats,
) -> Wedges:  # fmt: skip
    count = len(edge)
    return Wedges(
        mesh.vertices[edge[:, 0]], mesh.vertices[edge[:, 1]], inwards, np.asarray(normal), open_angle_rad, patch,
        np.zeros(count, dtype=np.int64), sheet_m, np.ones((count, 2), dtype=bool),
        np.full(count, -1), np.full((count, 2), -1),
    )  # fmt: skip


def _in_line(pieces: Wedges) -> Wedges:
    """Pieces of one line between the same patches as one wedge."""
    group = _chains(pieces)
    count = int(group.max(initial=-1)) + 1
    if count == len(pieces):
        return pieces
    first = np.zeros(count, dtype=np.int64)
    first[group[::-1]] = np.arange(len(pieces))[::-1]
    origin = pieces.start_m[first]
    along = pieces.end_m[first] - origin
    along /= norm(along)[..., None]
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    astray = np.zeros(count)
    for point in (pieces.start_m, pieces.end_m):
        offset = point - origin[group]
        place = dot(offset, along[group])
        np.minimum.at(low, group, place)
        np.maximum.at(high, group, place)
        np.maximum.at(astray, group, norm(offset - place[:, None] * along[group]))
    bent = astray > PLANE_FIT_M
    straight = pieces[first[~bent]]
    start, end = (origin + far[:, None] * along for far in (low, high))
    whole = replace(straight, start_m=start[~bent], end_m=end[~bent])
    return merge_wedges([whole, pieces[np.flatnonzero(bent[group])]])


def _chains(pieces: Wedges) -> Ints:
    """(W,) label of the line that each piece belongs to: pieces end to end, parallel, between the same patches."""
    count = len(pieces)
    corner = np.concatenate([pieces.start_m, pieces.end_m])
    vertex = np.unique(corner, axis=0, return_inverse=True)[1].reshape(-1)
    which = np.tile(np.arange(count), 2)
    pair = np.sort(pieces.patch, axis=1)[which]
    order = np.lexsort((pair[:, 1], pair[:, 0], vertex))
    left, right = order[:-1], order[1:]
    along = (pieces.end_m - pieces.start_m) / pieces.length_m[:, None]
    a, b = which[left], which[right]
    same = (vertex[left] == vertex[right]) & (pair[left] == pair[right]).all(axis=1)
    same &= np.abs(dot(along[a], along[b])) > 1.0 - STRAIGHT
    same &= np.abs(pieces.open_angle_rad[a] - pieces.open_angle_rad[b]) < BLUNT_RAD
    return components(np.column_stack([a[same], b[same]]), count)
