"""A body's skin in spots: patches of some centimetres, one facet of which speaks for all where light is asked for."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Flags, Ints
from simulator.surfaces.facets import Facets

BESIDE = 1.6  # spots whose facets are asked that far apart, re their size, are neighbours
NORMAL_STEPS = 2  # for a normal's component from 0 to 1: each range is some 30 degrees wide


class Spots(NamedTuple):
    """Spots of a body's skin; compiled functions take them one by one.

    Attributes:
        of_facet: (F,) spot of each facet.
        facet: (S,) the facet that speaks for each.
        beside: (B, 2) pairs of neighbours.
    """

    of_facet: Ints
    facet: Ints
    beside: Ints

    def around(self, some: Flags) -> Flags:
        """(S,) some spots and their neighbours."""
        around = some.copy()
        around[self.beside[some[self.beside].any(axis=1)]] = True
        return around

    def of(self, wanted: Flags) -> Spots:
        """Some of the spots (S,), of their facets alone."""
        number, kept = np.cumsum(wanted) - 1, wanted[self.of_facet]
        beside = self.beside[wanted[self.beside].all(axis=1)]
        return Spots(number[self.of_facet[kept]], (np.cumsum(kept) - 1)[self.facet[wanted]], number[beside])


def spots_of(facets: Facets, spot_m: float) -> Spots:
    """Facets by piece of the mesh, voxel and direction of their normal; each by itself where voxels are no larger."""
    if spot_m**2 <= float(facets.area_m2.mean()):
        every = np.arange(len(facets))
        return Spots(every, every, np.zeros((0, 2), dtype=np.int64))
    rows, start = _grouped(facets, spot_m)
    count = np.diff(np.append(start, len(rows)))
    spot, place = np.repeat(np.arange(len(start)), count), facets.middle_m.take(rows, axis=0)
    middle = np.add.reduceat(place, start) / count[:, None]
    x, y, z = (place - middle.take(spot, axis=0)).T
    miss = np.sqrt(x * x + y * y + z * z)
    nearest = np.flatnonzero(miss == np.minimum.reduceat(miss, start)[spot])
    facet = rows[nearest[np.searchsorted(nearest, start)]]
    of_facet = np.empty(len(facets), dtype=np.int64)
    of_facet[rows] = spot
    near = cKDTree(facets.middle_m[facet]).query_pairs(BESIDE * spot_m, output_type="ndarray")
    one, other = (facets.normal.take(facet[side], axis=0) for side in near.T)
    return Spots(of_facet, facet, near[np.einsum("bx,bx->b", one, other) > 0.0])


def _grouped(facets: Facets, voxel_m: float) -> tuple[Ints, Ints]:
    """(F,) rows by piece, voxel and direction of the normal, and (S,) where each group begins among them.

    Of two pieces that lie over one another one hides the other: none speaks for both.
    """
    place = np.ascontiguousarray(facets.middle_m.T)
    voxel = ((place - place.min(axis=1, keepdims=True)) / voxel_m).astype(np.int64)
    direction = np.rint(NORMAL_STEPS * facets.normal.T).astype(np.int64) + NORMAL_STEPS
    sizes = (*(voxel.max(axis=1) + 1), *[2 * NORMAL_STEPS + 1] * 3)
    number = np.ravel_multi_index((*voxel, *direction), sizes)
    rows = np.lexsort((number, facets.piece))
    begins = np.diff(number[rows], prepend=-1) != 0
    begins |= np.diff(facets.piece[rows], prepend=-1) != 0
    return rows, np.flatnonzero(begins)
