"""Kirchhoff's integral over the lit skin of a body, for surfaces that are neither plane and large nor smooth.

On a rigid surface the pressure is taken as twice the incident one where both ends see it and as nothing elsewhere:

    p = 1/(4 pi) int [(jk + 1/l) cos a + (jk + 1/m) cos b] e^{-jk(l + m)} / (l m) dS

with distances l, m and angles of incidence a, b of source and receiver: the mean of the integral and of its
reciprocal, so that ends can be swapped. Over a flat facet the phase runs linearly, and the integral is closed: a
divided difference of the exponential at the phases of the corners. What a rounded one stands off shifts all three by
its mean, and the rest is kept to first order, in closed form as well (`facet_waves`). Where the surface is not rigid
each facet carries its own reflection factor, at the geometric mean of both cosines, which both ends agree on: over a
clothed person it runs from 0.56 where sound falls square-on through 0 to -1 at grazing, and facets cancel by a factor
of three.

Each facet is evaluated once, at the band's centre, and spread over a grid of path length; the band follows by a
transform, as in a type-1 non-uniform FFT (Dutt and Rokhlin 1993, SIAM J. Sci. Comput. 14:1368). Where a smooth surface
ends at a rim, `fringe_waves` adds what the integral leaves out.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from simulator.kirchhoff.cells import Cells, CellSums, with_stand_ins
from simulator.kirchhoff.facet_sums import Blocks, GroupedEnds, GroupedPairs, add_facets
from simulator.kirchhoff.fringe_waves import add_fringe_waves
from simulator.kirchhoff.illuminating_images import Ends
from simulator.kirchhoff.path_length_grid import STEP_M, Grid
from simulator.surfaces.facets import Facets

RANK_SHARE = 1e-3  # of a surface's echo: what it varies by beyond that over frequency is kept
POINTS_AT_ONCE = 2**20  # of all pairs' grids: what is kept in memory, however long the walk is


def scattered(facets: Facets, ends: Ends, first: Ints, second: Ints, grid: Grid, reflection: Complexes) -> Cells:
    """Kirchhoff's sum for R pairs of ends, each within its group: all cells, and the facets that stand for them."""
    sums = cell_sums(facets, ends, first, second, grid, reflection)
    return with_stand_ins(facets, ends, first, second, grid, sums)


def cell_sums(facets: Facets, ends: Ends, first: Ints, second: Ints, grid: Grid, reflection: Complexes) -> CellSums:
    """The sums of all cells with anything in them, for R pairs of ends, each within its group.

    Args:
        first, second: (R,) ends of each pair, rising by group.
        grid: of path length about the body, for K wavenumbers.
        reflection: (C, K) factors of the surface at C cosines of incidence from 0 to 1 in even steps.
    """
    first, second = _in_order(ends.point_m, first, second)
    to_middle_m = np.add(*ends.over(facets.center_m))
    middle_m = to_middle_m[first] + to_middle_m[second]
    parts, blocks = [CellSums.none(len(grid.wavenumber_rad_m))], Blocks.of(facets)
    for rows in _portions(ends.group[first], grid.points):
        part = _held_cells(facets, blocks, ends, first[rows], second[rows], middle_m[rows], grid, reflection)
        parts.append(replace(part, pair=part.pair + rows.start))
    return CellSums.joined(parts)


def _in_order(point_m: Floats, first: Ints, second: Ints) -> tuple[Ints, Ints]:
    """The same pairs, each from the end that comes first in space: swapped ends then round alike."""
    rank = np.empty(len(point_m), dtype=np.int64)
    rank[np.lexsort(point_m.T)] = np.arange(len(point_m))
    swapped = rank[first] > rank[second]
    return np.where(swapped, second, first), np.where(swapped, first, second)


def _portions(group: Ints, points: int) -> list[slice]:
    """Runs of whole groups whose grids fit in memory."""
    if not len(group):
        return []
    starts = np.flatnonzero(np.diff(group, prepend=group[0] - 1))
    most = max(1, POINTS_AT_ONCE // points)
    _, kept = np.unique(starts // most, return_index=True)
    bounds = [*starts[kept].tolist(), len(group)]
    return [slice(a, b) for a, b in pairwise(bounds)]


def _held_cells(
    facets: Facets, blocks: Blocks, ends: Ends, first: Ints, second: Ints, middle_m: Floats, grid: Grid,
    reflection: Complexes,
) -> CellSums:  # fmt: skip
    """Sums of all cells with anything in them; `middle_m` (R,) are the seeming paths over the body's centre."""
    part, over_band = separated(reflection)
    table = np.stack([part.real, part.imag], axis=-1).astype(np.float32, order="C")
    total = np.zeros((len(first), len(part), grid.points, 2))
    groups = np.unique(ends.group[first])
    begin, stop = np.searchsorted(ends.group, groups), np.searchsorted(ends.group, groups, side="right")
    chosen = np.concatenate([np.arange(a, b) for a, b in zip(begin, stop, strict=True)])
    row = np.zeros(len(ends.group), dtype=np.int64)
    row[chosen] = np.arange(len(chosen))
    columns = np.hstack([ends.point_m - facets.center_m, ends.lean, ends.drift_m])[chosen].astype(np.float32)
    those = GroupedEnds(columns, ends.view[chosen], ends.lit, np.append(0, np.cumsum(stop - begin)))
    pair_start = np.append(np.searchsorted(ends.group[first], groups), len(first))
    pairs = GroupedPairs(row[first], row[second], pair_start)
    lead_m, step_m = np.float32(grid.lead_m), np.float32(STEP_M)
    add_facets(blocks, those, pairs, np.float32(grid.centre_rad_m), table, facets.closed, lead_m, step_m, total)  # type: ignore[call-arg]
    parts = [(total.view(np.complex128)[..., 0], over_band * (grid.wavenumber_rad_m / grid.centre_rad_m))]
    if len(facets.creases):
        rims = np.zeros_like(total)
        add_fringe_waves(facets.creases, facets.center_m, ends, first, second, part, grid, rims)
        parts.append((rims.view(np.complex128)[..., 0], over_band))
    pair, slot = np.nonzero(np.logical_or.reduce([grid.held(sums) for sums, _ in parts]))
    gain = sum(np.einsum("mqk,qk->mk", grid.cell_sums(sums, pair, slot), weight) for sums, weight in parts)
    return CellSums(pair, slot, grid.centre_m(middle_m[pair], slot), gain)


def separated(reflection: Complexes) -> tuple[Complexes, Complexes]:
    """(Q, C) and (Q, K) factors whose products add up to (C, K) reflections: one, or few if frequency matters.

    They are fitted as the integral weighs them, by the cosine: of a car's sheet metal one is enough, though at half a
    degree from grazing, where nothing returns, it errs by 0.09.
    """
    step = 1.0 / max(len(reflection) - 1, 1)
    cosine = np.maximum(step * np.arange(len(reflection)), step)[:, None]
    left, size, right = np.linalg.svd(cosine * reflection, full_matrices=False)
    rank = max(1, int((size > RANK_SHARE * size[0]).sum()))
    return (left[:, :rank] * size[:rank] / cosine).T, right[:rank]
