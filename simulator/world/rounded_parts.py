"""The parts of obstacles that no sharp edge bounds: nothing else diffracts into the shadows that they cast."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import norm
from simulator.surfaces.reflectors import MeshReading
from simulator.surfaces.wedges import Wedges


@dataclass(frozen=True)
class RoundedParts:
    """The rounded facets of P obstacles in their rest frames.

    Attributes:
        obstacle: (P,) indices.
        plates: (P,) whether thin plates stand among the parts, as a sign's does before or behind its post.
        corner_m: (F, 3, 3) corners of all their facets, part by part.
        ball_m: (F, 4) middle and radius of a ball that holds each facet.
        first: (P + 1,) where the facets of each part begin.
        box_m: (P, 2, 3) middle of the box that holds each, and halves of its sides.
    """

    obstacle: Ints
    plates: Flags
    corner_m: Floats
    ball_m: Floats
    first: Ints
    box_m: Floats

    def __len__(self) -> int:
        return len(self.obstacle)


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
        first += int(reading.patch.max(initial=-1)) + 1
    return found


def rounded_parts(readings: list[MeshReading], rounded: list[Flags]) -> RoundedParts:
    """What is rounded of all obstacles."""
    obstacle = np.array([index for index, own in enumerate(rounded) if own.any()], dtype=np.int64)
    corners = [facets_of(readings[index], rounded[index]) for index in obstacle]
    bounds = [(corner.min(axis=(0, 1)), corner.max(axis=(0, 1))) for corner in corners]
    boxes = [(0.5 * (low + high), 0.5 * (high - low)) for low, high in bounds]
    corner = np.concatenate([np.zeros((0, 3, 3)), *corners])
    middle = corner.mean(axis=1)
    radius = norm(corner - middle[:, None]).max(axis=1, initial=0.0)
    plates = np.array([readings[index].plated for index in obstacle], dtype=bool)
    return RoundedParts(
        obstacle, plates, corner, np.column_stack([middle, radius]),
        np.cumsum([0, *map(len, corners)]).astype(np.int64), np.array(boxes).reshape(-1, 2, 3),
    )  # fmt: skip


def facets_of(reading: MeshReading, chosen: Flags) -> Floats:
    """(F, 3, 3) corners of some facets of an obstacle."""
    found: Floats = np.asarray(reading.mesh.vertices)[np.asarray(reading.mesh.faces)[chosen]]
    return found
