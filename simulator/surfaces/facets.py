"""A body's surface cut into facets small against the wavelength, for sums over all of it.

Curved facets are cut on their rounded surface (quadratic triangles), planes where they lie.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import dot, norm
from simulator.surfaces import quadratic_triangles as nagata
from simulator.surfaces.creases import Creases, creases_of
from simulator.surfaces.facet_bounds import leaves
from simulator.surfaces.reflectors import MeshReading, SmoothSurface
from simulator.surfaces.subdivision import cut_up

BLOCK = 256  # facets a block at most: neighbours that are lit or dark together, and fit a processor's cache
NORMAL_M = 0.3  # normals that differ by one weigh as much as points this far apart when facets are put into blocks
MOST_FACETS = 4_000_000  # finer ones grow; 0.7 GB
COARSEST_M, MOST_COARSE = 0.025, 800_000  # a body of more facets of that size, or larger ones, is not cut: 70 m2
FACETS_A_SQUARE = 7.0  # for each square of their longest edge, as measured on cars, bins and people
DIAGONAL = 1.6  # longest edge of a piece, somewhat skewed and bulged, re the side of the square that it halves
CHORD = 0.15 / 8.0  # of a facet's size, from which an edge may stand off: of full size, it turns by 0.15 rad
KEPT = 6  # bodies cut: a car of 47 m2 takes 370 MB at 12 mm, 40 MB at 4 cm, 12 MB at 8 cm
STAND_M, ONE_IN = 0.02, 3  # apart are, on average, the facets that may stand for others; one in so many at the most
ELEMENT = 0.5  # length of a crease's elements, re the facets' size
OFF_BORDER = 0.1  # of the way to a facet's middle: no light is asked for in the corner of a sign and the ground
STRIDES = 1.324717957244746 ** np.array([-1.0, -2.0])
"""Powers of the plastic number: their multiples, less whole numbers, fill a square evenly (a Kronecker sequence)."""

_WHOLE = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]])  # (eta, zeta) of a triangle's own corners


@dataclass(frozen=True)
class Facets:
    """The skin of one obstacle in facets, rest frame.

    Attributes:
        obstacle: index of the obstacle.
        corner_m: (F, 3, 3) on the rounded surface.
        middle_m: (F, 3) centroid of the rounded surface over the triangle.
        normal: (F, 3) unit normals over the triangle's middle.
        area_m2: (F,).
        bulge_m: (F, 3) how far the rounded surface stands off the middles of the edges 12, 20 and 01, along the normal.
        standoff_m: (F,) how far the rounded surface may stand off the mesh there, or off the centroid.
        asked_m: (F, 3) where light on a facet is asked for: on plates, where facets lie in rows, elsewhere in each. The
            border of a post's shadow would pass the middles of a whole row of facets at once (-27 dB re a wall).
        stands: (F,) which may stand for the delay of what others add as well.
        piece: (F,) which of the mesh's connected pieces each is of.
        part_of: (F,) the facet that each is a quarter of, -1 where it is none. Where all of that one is in the light,
            it adds what its quarters would.
        start: (B + 1,) where each block begins.
        closed: only the outside scatters.
        creases: convex ones at which a smooth surface ends.
        center_m, radius_m: bounding sphere.
    """

    obstacle: int
    corner_m: Floats
    middle_m: Floats
    normal: Floats
    area_m2: Floats
    bulge_m: Floats
    standoff_m: Floats
    asked_m: Floats
    stands: Flags
    piece: Ints
    part_of: Ints
    start: Ints
    closed: bool
    creases: Creases
    center_m: Floats
    radius_m: float

    def __len__(self) -> int:
        return len(self.area_m2)

    def __getitem__(self, kept: Flags) -> Facets:
        """Some of the facets (F,), among them those beside creases and those that others are quarters of.

        What is said of the whole body stays.
        """
        size = np.add.reduceat(kept.astype(np.int64), self.start[:-1])
        number, rows = np.append(np.cumsum(kept) - 1, -1), np.flatnonzero(kept)
        names = ("corner_m", "middle_m", "normal", "area_m2", "bulge_m", "standoff_m", "asked_m", "stands", "piece")
        some = {name: getattr(self, name).take(rows, axis=0) for name in names}
        some["part_of"] = number[self.part_of[rows]]
        start = np.append(0, np.cumsum(size[size > 0]))
        return replace(self, **some, start=start, creases=replace(self.creases, beside=number[self.creases.beside]))


def can_cut(reading: MeshReading, size_m: float) -> bool:
    """Whether a mesh has at most `MOST_COARSE` facets of this size, or of `COARSEST_M` where that is larger."""
    return _least_m(reading, MOST_COARSE) <= max(size_m, COARSEST_M)


def check_cut(name: str, reading: MeshReading, size_m: float) -> None:
    """Refuse the mesh of a named obstacle that cannot be cut.

    Raises:
        ValueError: the mesh is too large, see `can_cut`.
    """
    if not can_cut(reading, size_m):
        raise ValueError(
            f"facets of {max(size_m, COARSEST_M)} m over the {reading.mesh.area:.3g} m2 of '{name}' must not be more "
            f"than {MOST_COARSE}: choose larger ones or leave this obstacle to the other mechanisms"
        )


def _least_m(reading: MeshReading, most: int) -> float:
    """The least size of the facets at which a mesh has so many of them at most."""
    return float(np.sqrt(FACETS_A_SQUARE * reading.mesh.area / most))


def facets_of(
    reading: MeshReading, surface: SmoothSurface | None, obstacle: int, size_m: float, chord_m: float = np.inf
) -> Facets:
    """Cut a mesh into facets with edges up to `size_m`, shorter ones where it bends.

    There edges stand off their chords by `chord_m` at most, and by `CHORD` of their size where that is less. Skewed
    pieces are longer, 2 % of a car's skin; and all are where that would be more than `MOST_FACETS`. `check_cut` says
    whether a mesh is too large.
    """
    return replace(_cut_skin(reading, surface, size_m, chord_m), obstacle=obstacle)


@lru_cache(KEPT)
def _cut_skin(reading: MeshReading, surface: SmoothSurface | None, size_m: float, chord_m: float) -> Facets:
    """The same of an obstacle of any number."""
    skin = _Skin.of(reading, surface)
    size_m = max(size_m, _least_m(reading, MOST_FACETS))
    owner, place = _cut(skin, size_m, min(chord_m, CHORD * size_m))
    over, normal = skin.at(owner, _means(place))
    facet, start = leaves(np.concatenate([over, NORMAL_M * normal], axis=1), BLOCK)
    owner, place, over, normal = owner[facet], *(column.take(facet, axis=0) for column in (place, over, normal))
    corner_m = np.stack([skin.at(owner, place[:, i])[0] for i in range(3)], axis=1)
    flat, sides = _means(corner_m), corner_m[:, 1:] - corner_m[:, :1]
    rise = 0.75 * (over - flat)  # mean over a quadratic triangle
    middle = flat + rise
    area, every = 0.5 * norm(np.cross(sides[:, 0], sides[:, 1])), corner_m.reshape(-1, 3)
    center = 0.5 * np.array([axis.min() + axis.max() for axis in every.T])
    return Facets(
        obstacle=-1, corner_m=corner_m, middle_m=middle, normal=normal,
        area_m2=area, bulge_m=_bulge(skin, owner, place, corner_m, normal),
        standoff_m=2.0 * skin.sag_m[owner] + norm(rise),
        asked_m=_off_rows(skin, reading, owner, place, facet, middle) if reading.plated else middle,
        stands=np.arange(len(area)) % max(ONE_IN, round(STAND_M**2 / float(area.mean()))) == 0,
        piece=reading.piece[skin.face[owner]], part_of=np.full(len(area), -1), start=start, closed=bool(reading.closed),
        creases=creases_of(reading, surface, over, normal, ELEMENT * size_m),
        center_m=center, radius_m=float(norm(every - center).max()),
    )  # fmt: skip


def _bulge(skin: _Skin, owner: Ints, place: Floats, corner_m: Floats, normal: Floats) -> Floats:
    """(R, 3) how far the surface stands off the middles of the edges 12, 20 and 01 of pieces, along their normals."""
    rises = []
    for i, j in ((1, 2), (2, 0), (0, 1)):
        point, _ = skin.at(owner, 0.5 * (place[:, i] + place[:, j]))
        rises.append(dot(point - 0.5 * (corner_m[:, i] + corner_m[:, j]), normal))
    return np.stack(rises, axis=1)


def _off_rows(skin: _Skin, reading: MeshReading, owner: Ints, place: Floats, number: Ints, middle_m: Floats) -> Floats:
    """(R, 3) the middles of pieces, but for those of planes another place in each, by its number."""
    planes = np.flatnonzero(owner < np.count_nonzero(~reading.curved))
    x, y = ((number[planes] + 1) * STRIDES[:, None]) % 1.0
    beyond = x + y > 1.0
    x, y = np.where(beyond, 1.0 - x, x), np.where(beyond, 1.0 - y, y)
    share = (1.0 - OFF_BORDER) * np.stack([x, y, 1.0 - x - y], axis=1) + OFF_BORDER / 3.0
    asked_m = middle_m.copy()
    asked_m[planes], _ = skin.at(owner[planes], np.einsum("ri,rix->rx", share, place[planes]))
    return asked_m


def _means(corner: Floats) -> Floats:
    """(T, D) means of corners (T, 3, D); by columns, as numpy's over three take several times as long."""
    return (corner[:, 0] + corner[:, 1] + corner[:, 2]) / 3.0


@dataclass(frozen=True)
class _Skin:
    """All facets of a mesh as Nagata triangles; those of planes, the first ones, are flat, and end where a rounded
    neighbour does."""

    corner_m: Floats
    normal: Floats
    bulge_m: Floats
    sag_m: Floats
    face: Ints

    @classmethod
    def of(cls, reading: MeshReading, surface: SmoothSurface | None) -> _Skin:
        mesh, flat = reading.mesh, np.flatnonzero(~reading.curved)
        corner = np.asarray(mesh.vertices)[mesh.faces[flat]]
        normal = np.repeat(np.asarray(mesh.face_normals)[flat][:, None], 3, axis=1)
        bulge, sag = np.zeros_like(corner), np.zeros(len(flat))
        if surface is None:
            return cls(corner, normal, bulge, sag, flat)
        _share_outline(reading, surface, flat, bulge)
        return cls(
            np.concatenate([corner, surface.corner_m]), np.concatenate([normal, surface.normal]),
            np.concatenate([bulge, surface.bulge_m]), np.concatenate([sag, surface.sag_m]),
            np.concatenate([flat, np.flatnonzero(reading.curved)]),
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
    bulge_m[row, edge[1]] = shape - dot(shape, across)[:, None] * across


def _edge_between(corners: Ints, vertices: Ints) -> Ints:
    """(E,) which of a facet's edges 01, 12, 02 lies between two vertices."""
    missing = np.argmin((corners[:, :, None] == vertices[:, None, :]).any(axis=2), axis=1)
    return (missing + 1) % 3


def _cut(skin: _Skin, size_m: float, chord_m: float) -> tuple[Ints, Floats]:
    """Owners (R,) and places (R, 3, 2) of pieces whose edges are no longer than `size_m`.

    Less where it bends: an edge stands off its chord by an eighth of length times turn, `chord_m` at most.
    """
    every = np.arange(len(skin.corner_m))
    ends = [skin.at(every, np.repeat(_WHOLE[:, i], len(every), axis=0)) for i in range(3)]
    point, normal = (np.stack(part, axis=1) for part in zip(*ends, strict=True))
    length = norm(point - np.roll(point, -1, axis=1))
    turn = norm(normal - np.roll(normal, -1, axis=1))
    return cut_up(DIAGONAL * np.maximum(length / size_m, np.sqrt(0.125 * length * turn / chord_m)))
