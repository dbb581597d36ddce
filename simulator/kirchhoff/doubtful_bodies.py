"""Bodies whose rays are doubted before any is traced: they may be left to Kirchhoff's integral."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Floats
from simulator.surfaces.facets import can_cut
from simulator.surfaces.reflectors import SmoothSurface
from simulator.world.search_context import Search
from simulator.world.world import World

UNEVEN = 0.13  # scanned people have 0.18-0.21, cars 0.15-0.16; bins, posts and signs 0-0.1


@dataclass(frozen=True)
class Doubt:
    """A body that the integral may have to take.

    Attributes:
        obstacle: its index.
        center_m, radius_m: (3,) and bounding sphere, rest frame.
        surface: smooth surface whose rays are doubted; None where the fidelity has no rays for a part of the body.
        uneven: whether that surface's rays say nothing, such as those of scanned people: none is looked for on it.
    """

    obstacle: int
    center_m: Floats
    radius_m: float
    surface: int | None
    uneven: bool


def doubted(search: Search) -> list[Doubt]:
    """Bodies without rays, then uneven ones and those with a surface that ends.

    A surface too large to be cut into facets, or of the walker's own body, is left to rays. Rays off people differ from
    the integral by 4 dB in the median and 10 dB at the 95th percentile, over 1.5-5 m.
    """
    world, fidelity = search.tracing.world, search.fidelity
    if "kirchhoff" not in fidelity.mechanisms:
        return []
    without = [
        obstacle for obstacle, (reading, _) in enumerate(world.skins)
        if ("specular" not in fidelity.mechanisms and (reading.patch >= 0).any())
        or ("curved" not in fidelity.mechanisms and reading.curved.any())
    ]  # fmt: skip
    doubts = [_doubt(world, obstacle) for obstacle in without]
    for index, surface in enumerate(world.surfaces):
        reading, _ = world.skins[surface.obstacle]
        if surface.obstacle in without or world.carried[surface.obstacle] or not can_cut(reading, fidelity.facet_m):
            continue
        uneven = unevenness(surface) > UNEVEN
        if uneven or (np.isfinite(fidelity.tolerance_db) and len(world.borders[index])):
            doubts.append(_doubt(world, surface.obstacle, index, uneven))
    return doubts


def _doubt(world: World, obstacle: int, surface: int | None = None, uneven: bool = False) -> Doubt:
    vertices = np.asarray(world.skins[obstacle][0].mesh.vertices)
    center = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return Doubt(obstacle, center, float(np.linalg.norm(vertices - center, axis=1).max()), surface, uneven)


def unevenness(surface: SmoothSurface) -> float:
    """How much the principal curvatures change within a facet, re their size, as a median.

    0 on spheres and cylinders of any number of facets: their axes turn within a facet, their curvatures do not change.
    """
    principal = np.linalg.eigvalsh(surface.curvature)
    size = np.linalg.norm(principal, axis=2).mean(axis=1)
    change = np.linalg.norm(principal - principal.mean(axis=1, keepdims=True), axis=2).mean(axis=1)
    return float(np.median(change / np.maximum(size, 1e-9)))
