"""The parts of obstacles that no sharp edge bounds: nothing else diffracts into the shadows that they cast.

A part is what is rounded of one connected piece of a mesh: the two wheels of a bin are two. What a piece's own planes
and edges return it may hide or not, but it stands in the way of all others, of the same obstacle as well. Pieces that
have no planes are one part together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import norm
from simulator.surfaces.reflectors import MeshReading
from simulator.surfaces.wedges import Wedges
from simulator.world.visibility import Blocker, blocker


class Screens(NamedTuple):
    """Opaque screens made of facets, at rest; a tuple of arrays, as compiled functions take it.

    Attributes:
        corner_m: (F, 3, 3) corners of all their facets, screen by screen.
        ball_m: (F, 4) middle and radius of a ball that holds each facet.
        first: (S + 1,) where the facets of each screen begin.
    """

    corner_m: Floats
    ball_m: Floats
    first: Ints

    @classmethod
    def of(cls, corners_m: Sequence[Floats]) -> Screens:
        """A screen of each of the (F, 3, 3) given."""
        corner = np.concatenate([np.zeros((0, 3, 3)), *corners_m])
        return cls(corner, _balls_round(corner), np.cumsum([0, *map(len, corners_m)]).astype(np.int64))


@dataclass(frozen=True)
class RoundedParts:
    """The rounded facets of P parts in the rest frames of their obstacles.

    Attributes:
        obstacle: (P,) indices.
        own_patch: (P, Q) whether a planar patch, of all Q, is of the same piece.
        screens: their facets, a screen each.
        box_m: (P, 2, 3) middle of the box that holds each, and halves of its sides.
    """

    obstacle: Ints
    own_patch: Flags
    screens: Screens
    box_m: Floats

    def __len__(self) -> int:
        return len(self.obstacle)

    @cached_property
    def blockers(self) -> tuple[Blocker, ...]:
        """Each part by itself."""
        corner, _, first = self.screens
        meshes = [loose(corner[begin:end]) for begin, end in pairwise(first.tolist())]
        return tuple(blocker([m], np.full(len(m[1]), index)) for m, index in zip(meshes, self.obstacle, strict=True))


def rounded_facets(readings: list[MeshReading], wedges: Wedges) -> list[Flags]:
    """Which facets of each obstacle are rounded.

    Of obstacles with a smooth surface all but the rims of thin plates and the planes that sharp edges bound.

    Args:
        readings: of all obstacles.
        wedges: of all obstacles; their planes are numbered from obstacle to obstacle.
    """
    found, first = [], 0
    for reading in readings:
        plane = np.where(reading.patch >= 0, first + reading.patch, -1)
        blunt = (plane >= 0) & ~np.isin(plane, wedges.patch)
        found.append((reading.curved | blunt) & reading.curved.any())
        first += reading.planes
    return found


def rounded_parts(readings: list[MeshReading], rounded: list[Flags]) -> RoundedParts:
    """What is rounded (`rounded_facets`) of all obstacles."""
    owners = [(i, rows) for i, own in enumerate(rounded) for rows in _in_parts(readings[i], own)]
    corners = [corners_of(readings[i], rows) for i, rows in owners]
    bounds = [(corner.min(axis=(0, 1)), corner.max(axis=(0, 1))) for corner in corners]
    boxes = [(0.5 * (low + high), 0.5 * (high - low)) for low, high in bounds]
    return RoundedParts(
        np.array([i for i, _ in owners], dtype=np.int64), _own_patches(readings, owners), Screens.of(corners),
        np.array(boxes).reshape(-1, 2, 3),
    )  # fmt: skip


def _in_parts(reading: MeshReading, rounded: Flags) -> list[Ints]:
    """Which facets each part has."""
    if not rounded.any():
        return []
    flat = np.isin(reading.piece, reading.piece[reading.patch >= 0])
    part, rows = np.where(flat, reading.piece, -1), np.flatnonzero(rounded)
    rows = rows[np.argsort(part[rows], kind="stable")]
    return np.split(rows, np.flatnonzero(np.diff(part[rows])) + 1)


def _own_patches(readings: list[MeshReading], owners: list[tuple[int, Ints]]) -> Flags:
    """(P, Q) which of all planar patches are of the same pieces as parts, given by obstacle and facets."""
    first = np.cumsum([0, *(reading.planes for reading in readings)])
    own = np.zeros((len(owners), int(first[-1])), dtype=bool)
    for part, (index, rows) in enumerate(owners):
        reading = readings[index]
        patch = reading.patch[np.isin(reading.piece, reading.piece[rows])]
        own[part, first[index] + patch[patch >= 0]] = True
    return own


def corners_of(reading: MeshReading, chosen: Flags | Ints) -> Floats:
    """(F, 3, 3) corners of some facets of an obstacle."""
    found: Floats = np.asarray(reading.mesh.vertices)[np.asarray(reading.mesh.faces)[chosen]]
    return found


def _balls_round(corner_m: Floats) -> Floats:
    """(F, 4) middle and radius of a ball that holds each facet (F, 3, 3)."""
    middle = corner_m.mean(axis=1)
    return np.column_stack([middle, norm(corner_m - middle[:, None]).max(axis=1, initial=0.0)])


def loose(corner_m: Floats) -> tuple[Floats, Ints]:
    """Facets (F, 3, 3) as vertices and faces that share none."""
    return corner_m.reshape(-1, 3), np.arange(3 * len(corner_m)).reshape(-1, 3)
