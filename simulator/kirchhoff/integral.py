"""Kirchhoff's integral over the lit skin of a body, for surfaces that are neither plane and large nor smooth.

On a rigid surface the pressure is taken as twice the incident one where both ends see it and as nothing elsewhere:

    p = 1/(4 pi) int [(jk + 1/l) cos a + (jk + 1/m) cos b] e^{-jk(l + m)} / (l m) dS

with distances l, m and angles of incidence a, b of source and receiver: the mean of the integral and of its
reciprocal, so that ends can be swapped. Over a facet the phase runs linearly, and the integral is closed: a divided
difference of the exponential at the phases of the corners; the curvature of the surface shifts all three. Where the
surface is not rigid each facet carries its own reflection factor, at the geometric mean of both cosines, which both
ends agree on: over a clothed person it runs from 0.56 where sound falls square-on through 0 to -1 at grazing, and
facets cancel by a factor of three.

Each facet is evaluated once, at the band's centre, and spread over a grid of path length; the band follows by a
transform, as in a type-1 non-uniform FFT (Dutt and Rokhlin 1993, SIAM J. Sci. Comput. 14:1368). Where a smooth surface
ends at a rim, `fringe_waves` adds what the integral leaves out.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from simulator.kirchhoff.facet_sums import WIDE, add_facets
from simulator.kirchhoff.fringe_waves import add_fringe_waves
from simulator.kirchhoff.illuminating_images import Ends
from simulator.kirchhoff.path_length_grid import STEP_M, Grid, stand_ins, standing
from simulator.surfaces.facets import Facets

RANK_SHARE = 1e-3  # of a surface's reflection: what it varies by beyond that over frequency is kept
POINTS_AT_ONCE = 2**20  # of all pairs' grids: what is kept in memory, however long the walk is


@dataclass(frozen=True)
class Cells:
    """What R pairs of points receive of a body, by path length.

    Attributes:
        pair: (M,) index of the pair; sorted.
        facet: (M,) the facet whose path stands for the cell's delay.
        length_m: (M,) its path.
        gain: (M, K) sum at K wavenumbers without the phase of that path, the surface's reflection included.
    """

    pair: Ints
    facet: Ints
    length_m: Floats
    gain: Complexes

    def __len__(self) -> int:
        return len(self.pair)

    def __getitem__(self, index: NDArray) -> Cells:
        return Cells(self.pair[index], self.facet[index], self.length_m[index], self.gain[index])


def scattered(
    facets: Facets, spot: Ints, ends: Ends, first: Ints, second: Ints, wavenumber_rad_m: Floats, reflection: Complexes
) -> Cells:
    """Kirchhoff's sum for R pairs of ends, each within its group.

    Args:
        spot: (F,) spot of each facet.
        first, second: (R,) ends of each pair, rising by group.
        wavenumber_rad_m: (K,) rising.
        reflection: (C, K) factors of the surface at C cosines of incidence from 0 to 1 in even steps.
    """
    grid = Grid.over(facets.radius_m, wavenumber_rad_m)
    first, second = _in_order(ends.point_m, first, second)
    parts = []
    for rows in _portions(ends.group[first], grid.points):
        gain = _cell_gains(facets, spot, ends, first[rows], second[rows], grid, reflection)
        cells = _with_stand_ins(facets, spot, ends, first[rows], second[rows], grid, gain)
        parts.append(Cells(cells.pair + rows.start, cells.facet, cells.length_m, cells.gain))
    return joined_cells(parts, len(wavenumber_rad_m))


def joined_cells(parts: list[Cells], nodes: int) -> Cells:
    """All parts, one after the other."""
    none = np.zeros(0, dtype=np.int64)
    parts = [Cells(none, none, np.zeros(0), np.zeros((0, nodes), dtype=np.complex128)), *parts]
    return Cells(*(np.concatenate([getattr(p, name) for p in parts]) for name in Cells.__dataclass_fields__))


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


def _cell_gains(
    facets: Facets, spot: Ints, ends: Ends, first: Ints, second: Ints, grid: Grid, reflection: Complexes
) -> Complexes:
    """(R, C, K) sums of the cells about their centres."""
    part, over_band = separated(reflection)
    table = np.stack([part.real, part.imag], axis=-1).astype(np.float32)
    total = np.zeros((len(first), len(part), grid.points, 2))
    groups = np.unique(ends.group[first])
    begin, stop = np.searchsorted(ends.group, groups), np.searchsorted(ends.group, groups, side="right")
    chosen = np.concatenate([np.arange(a, b) for a, b in zip(begin, stop, strict=True)])
    row = np.zeros(len(ends.group), dtype=np.int64)
    row[chosen] = np.arange(len(chosen))
    end_start = np.append(0, np.cumsum(stop - begin))
    pair_start = np.append(np.searchsorted(ends.group[first], groups), len(first))
    point = (ends.point_m[chosen] - facets.center_m).astype(np.float32)
    add_facets(
        *_blocks(facets, spot), point, ends.view[chosen], ends.lit, end_start, row[first], row[second], pair_start,
        np.float32(grid.centre_rad_m), table, facets.closed, np.float32(grid.lead_m), np.float32(STEP_M),
        total,
    )  # type: ignore[call-arg]  # fmt: skip
    sums = grid.cell_sums(total.view(np.complex128)[..., 0])
    gain = np.einsum("rqck,qk->rck", sums, over_band * (grid.wavenumber_rad_m / grid.centre_rad_m))
    if len(facets.creases):
        total[:] = 0.0
        add_fringe_waves(facets.creases, spot, ends, first, second, part, facets.center_m, grid, total)
        gain += np.einsum("rqck,qk->rck", grid.cell_sums(total.view(np.complex128)[..., 0]), over_band)
    return gain


def separated(reflection: Complexes) -> tuple[Complexes, Complexes]:
    """(Q, C) and (Q, K) factors whose products add up to (C, K) reflections: one, or few if frequency matters."""
    left, size, right = np.linalg.svd(reflection, full_matrices=False)
    rank = max(1, int((size > RANK_SHARE * size[0]).sum()))
    return (left[:, :rank] * size[:rank]).T, right[:rank]


def _blocks(facets: Facets, spot: Ints) -> tuple[NDArray[np.float32], Ints, Ints]:
    """What `add_facets` takes: (B, 13 * WIDE) columns and (B, WIDE) spots block by block, and (B,) their numbers."""
    size = np.diff(facets.start)
    block = np.repeat(np.arange(len(size)), size)
    column = np.arange(len(facets)) - facets.start[block]
    corners = facets.corner_m[:, :2] - facets.corner_m.mean(axis=1, keepdims=True)
    values = [facets.middle_m - facets.center_m, facets.normal, facets.area_m2[:, None], corners.reshape(-1, 6)]
    rows = np.zeros((len(size), 13, WIDE), dtype=np.float32)
    rows[block, :, column] = np.concatenate(values, axis=1)
    spots = np.zeros((len(size), WIDE), dtype=np.int64)
    spots[block, column] = spot
    return rows.reshape(len(size), -1), spots, size


def _with_stand_ins(
    facets: Facets, spot: Ints, ends: Ends, first: Ints, second: Ints, grid: Grid, gain: Complexes
) -> Cells:
    """Cells with anything in them, and the facets that stand for their delays."""
    pair, slot = np.nonzero(np.abs(gain).max(axis=2, initial=0.0) > 0.0)
    middle = sum(np.linalg.norm(ends.point_m[each] - facets.center_m, axis=1) for each in (first, second))
    gain = gain[pair, slot]
    centre = grid.centre_m(np.asarray(middle)[pair], slot)
    wanted = centre + _excess(gain, grid.wavenumber_rad_m, grid.taps * STEP_M)
    some = standing(facets.area_m2)
    facet, length = stand_ins(
        facets.middle_m[some], facets.normal[some], facets.area_m2[some], spot[some], facets.closed,
        ends.point_m, ends.view, ends.lit, first, second, pair, slot, centre, wanted, grid.taps * STEP_M,
    )  # type: ignore[call-arg]  # fmt: skip
    found = np.flatnonzero(facet >= 0)
    turn = np.exp(1j * (length - centre)[found, None] * grid.wavenumber_rad_m)
    return Cells(pair[found], some[facet[found]], length[found], gain[found] * turn)


def _excess(gain: Complexes, wavenumber: Floats, most_m: float) -> Floats:
    """(M,) path in excess of the cell's centre that the turning of the phase over frequency shows."""
    if gain.shape[1] == 1:
        return np.zeros(len(gain))
    turn = gain[:, 1:] * np.conj(gain[:, :-1])
    step = np.diff(wavenumber)
    weight = np.abs(turn) * step
    excess = -np.sum(weight * np.angle(turn) / step, axis=1) / np.maximum(weight.sum(axis=1), 1e-300)
    return np.clip(excess, -most_m, most_m)
