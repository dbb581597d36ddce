"""A body's surface cut into facets small against the wavelength, for sums over all of it.

Curved facets are cut on their rounded surface (Nagata's triangles), planes where they lie. Facets are kept in pieces
of a few tens: where some of a piece's facets are seen or hidden alike, the others need not be asked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.surfaces import quadratic_triangles as nagata
from simulator.surfaces.creases import Creases, creases_of
from simulator.surfaces.facet_groups import leaves
from simulator.surfaces.reflectors import MeshReading, SmoothSurface

PIECE = 32  # facets a piece at most: some 2 cm across
TURN_M = 0.1  # normals that differ by one weigh as much as points this far apart when facets are put into pieces
MOST_FACETS = 400_000
FACETS_A_SQUARE = 6.0  # facets for each square of their greatest edge: halving makes many smaller than they must be
BEND_M = 0.25  # radius down to which facets of full size stand for the curve; 12 mm then stand off by 0.07 mm

_WHOLE = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]])  # (eta, zeta) of a triangle's own corners


@dataclass(frozen=True)
class Facets:
    """The skin of one obstacle in small triangles, rest frame.

    Attributes:
        obstacle: index of the obstacle.
        corner_m: (F, 3, 3) on the rounded surface.
        middle_m: (F, 3) point of the rounded surface over the triangle's middle.
        normal: (F, 3) unit normals there.
        area_m2: (F,).
        lift_m: (F,) how far the rounded surface may stand off the mesh there.
        start: (G + 1,) where each piece begins.
        closed: only the outside scatters.
        creases: convex ones at which a smooth surface ends.
        center_m, radius_m: bounding sphere.
    """

    obstacle: int
    corner_m: Floats
    middle_m: Floats
    normal: Floats
    area_m2: Floats
    lift_m: Floats
    start: Ints
    closed: bool
    creases: Creases
    center_m: Floats
    radius_m: float

    def __len__(self) -> int:
        return len(self.area_m2)


def can_cut(reading: MeshReading, size_m: float) -> bool:
    """Whether a mesh in facets of this size stays within `MOST_FACETS`."""
    return FACETS_A_SQUARE * float(reading.mesh.area) / size_m**2 <= MOST_FACETS


def facets_of(reading: MeshReading, surface: SmoothSurface | None, obstacle: int, size_m: float) -> Facets:
    """Cut a mesh into facets with no edge longer than `size_m`, shorter ones where it bends more than at 25 cm.

    Raises:
        ValueError: more than `MOST_FACETS` facets would be needed.
    """
    if not can_cut(reading, size_m):
        raise ValueError(
            f"facets of {size_m} m over {reading.mesh.area:.3g} m2 would be more than {MOST_FACETS}: "
            "choose larger ones or leave this obstacle to the other mechanisms"
        )
    skin = _Skin.of(reading, surface)
    owner, place = _bisected(skin, size_m)
    corner_m = np.stack([skin.at(owner, place[:, i])[0] for i in range(3)], axis=1)
    middle_m, normal = skin.at(owner, place.mean(axis=1))
    facet, start = leaves(np.concatenate([middle_m, TURN_M * normal], axis=1), PIECE)
    sides = corner_m[:, 1:] - corner_m[:, :1]
    creases = creases_of(reading, surface, middle_m[facet], normal[facet], 0.5 * size_m)
    center = 0.5 * (corner_m.min(axis=(0, 1)) + corner_m.max(axis=(0, 1)))
    return Facets(
        obstacle=obstacle, corner_m=corner_m[facet], middle_m=middle_m[facet], normal=normal[facet],
        area_m2=0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)[facet],
        lift_m=2.0 * skin.sag_m[owner[facet]], start=start,
        closed=reading.closed, creases=creases,
        center_m=center, radius_m=float(np.linalg.norm(corner_m - center, axis=2).max()),
    )  # fmt: skip


@dataclass(frozen=True)
class _Skin:
    """All facets of a mesh as Nagata triangles; those of planes are flat, and end where a rounded neighbour does."""

    corner_m: Floats
    normal: Floats
    bulge_m: Floats
    sag_m: Floats

    @classmethod
    def of(cls, reading: MeshReading, surface: SmoothSurface | None) -> _Skin:
        mesh, flat = reading.mesh, np.flatnonzero(~reading.curved)
        corner = np.asarray(mesh.vertices)[mesh.faces[flat]]
        normal = np.repeat(np.asarray(mesh.face_normals)[flat][:, None], 3, axis=1)
        bulge, sag = np.zeros_like(corner), np.zeros(len(flat))
        if surface is None:
            return cls(corner, normal, bulge, sag)
        _share_outline(reading, surface, flat, bulge)
        return cls(
            np.concatenate([corner, surface.corner_m]), np.concatenate([normal, surface.normal]),
            np.concatenate([bulge, surface.bulge_m]), np.concatenate([sag, surface.sag_m]),
        )  # fmt: skip

    def at(self, facet: Ints, uv: Floats) -> tuple[Floats, Floats]:
        """(R, 3) points and unit normals at places (R, 2) of facets (R,)."""
        return nagata.rounded(self.corner_m, self.normal, self.bulge_m, facet, np.ascontiguousarray(uv))


def _share_outline(reading: MeshReading, surface: SmoothSurface, flat: Ints, bulge_m: Floats) -> None:
    """Let the edges (T, 3, 3) of flat facets run, within their planes, along those of the curved facets they meet.

    A cap with 32 straight sides has an outline up to 1.2 mm within the rim of the rounded bin below it, which takes
    0.7 dB off the echo of the rim.
    """
    mesh = reading.mesh
    pair, vertices = np.asarray(mesh.face_adjacency), np.asarray(mesh.face_adjacency_edges)
    curved = reading.curved[pair]
    rows = np.flatnonzero(curved[:, 0] != curved[:, 1])
    facet = np.where(curved[rows, 0], pair[rows, 0], pair[rows, 1])
    plane = pair[rows].sum(axis=1) - facet
    position = np.cumsum(reading.curved) - 1
    edge = [_edge_between(np.asarray(mesh.faces)[each], vertices[rows]) for each in (facet, plane)]
    shape = surface.bulge_m[position[facet], edge[0]]
    across = np.asarray(mesh.face_normals)[plane]
    row = np.searchsorted(flat, plane)
    bulge_m[row, edge[1]] = shape - np.sum(shape * across, axis=1)[:, None] * across


def _edge_between(corners: Ints, vertices: Ints) -> Ints:
    """(E,) which of a facet's edges 01, 12, 02 lies between two vertices."""
    missing = np.argmin((corners[:, :, None] == vertices[:, None, :]).any(axis=2), axis=1)
    return (missing + 1) % 3


def _bisected(skin: _Skin, size_m: float) -> tuple[Ints, Floats]:
    """Owners (R,) and places (R, 3, 2) of triangles, halved across their worst edge until no edge is too long.

    An edge may be `size_m` long, and less where it stands off its chord more than at a radius of `BEND_M`. It is
    judged alike by the two triangles that share it, so both cut it at the same point and no crack opens.
    """
    owner = np.arange(len(skin.corner_m))
    place = np.repeat(_WHOLE, len(owner), axis=0)
    done: list[tuple[Ints, Floats]] = []
    while len(owner):
        corners = [skin.at(owner, place[:, i]) for i in range(3)]
        point, normal = (np.stack(part, axis=1) for part in zip(*corners, strict=True))
        length = np.linalg.norm(point - np.roll(point, -1, axis=1), axis=2)
        turn = np.linalg.norm(normal - np.roll(normal, -1, axis=1), axis=2)
        excess = np.maximum(length, np.sqrt(BEND_M * length * turn)) / size_m
        worst = excess.argmax(axis=1)
        fits = excess.max(axis=1) <= 1.0
        done.append((owner[fits], place[fits]))
        rows, first = np.flatnonzero(~fits), worst[~fits]
        a, b, c = (place[rows, (first + i) % 3] for i in range(3))
        middle = 0.5 * (a + b)
        place = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        owner = np.tile(owner[rows], 2)
    return np.concatenate([o for o, _ in done]), np.concatenate([p for _, p in done])
