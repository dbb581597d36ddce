"""A body's skin in spots: patches of some centimetres, one facet of which speaks for all where light is asked for."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Floats, Ints
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


def spots_of(facets: Facets, spot_m: float) -> Spots:
    """Facets by voxel and direction of their normal; each facet by itself where the voxels are no larger."""
    if spot_m**2 <= float(facets.area_m2.mean()):
        every = np.arange(len(facets))
        return Spots(every, every, np.zeros((0, 2), dtype=np.int64))
    rows, start = _grouped(facets.middle_m, facets.normal, spot_m)
    spot = np.repeat(np.arange(len(start)), np.diff(np.append(start, len(rows))))
    middle = np.add.reduceat(facets.middle_m[rows], start) / np.diff(np.append(start, len(rows)))[:, None]
    miss = np.linalg.norm(facets.middle_m[rows] - middle[spot], axis=1)
    first = np.lexsort((miss, spot))
    of_facet = np.empty(len(facets), dtype=np.int64)
    of_facet[rows] = spot
    facet = rows[first[start]]
    near = cKDTree(facets.middle_m[facet]).query_pairs(BESIDE * spot_m, output_type="ndarray")
    alike = np.einsum("bx,bx->b", *(facets.normal[facet[side]] for side in near.T)) > 0.0
    return Spots(of_facet, facet, near[alike])


def _grouped(point_m: Floats, normal: Floats, voxel_m: float) -> tuple[Ints, Ints]:
    """(F,) rows by voxel and direction of the normal, and (S,) where each group begins among them."""
    voxel = np.floor((point_m - point_m.min(axis=0)) / voxel_m).astype(np.int64)
    direction = np.rint(NORMAL_STEPS * normal).astype(np.int64) + NORMAL_STEPS
    sizes = (*(voxel.max(axis=0) + 1), *[2 * NORMAL_STEPS + 1] * 3)
    number = np.ravel_multi_index((*voxel.T, *direction.T), sizes)
    rows = np.argsort(number, kind="stable")
    return rows, np.flatnonzero(np.diff(number[rows], prepend=-1))
