"""Cells of a body: what it adds over a few centimetres of path, and the facet that stands for each cell's delay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.rows import Rows
from simulator.kirchhoff.illuminating_images import Ends
from simulator.kirchhoff.path_length_grid import STEP_M, Grid
from simulator.surfaces.facets import Facets

PATH_M, PLACE_M = 2e-3, 0.05  # misses of path and of place that weigh alike when a facet is chosen for a cell


@dataclass(frozen=True)
class Cells(Rows):
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


@dataclass(frozen=True)
class CellSums(Rows):
    """The sums of cells, before a facet stands for any: which of them matter is known by then.

    Attributes:
        pair: (M,) index of the pair; sorted.
        slot: (M,) number of the cell along the pair's path.
        centre_m: (M,) path of the cell's centre, as the chirp makes it seem.
        gain: (M, K) sum at K wavenumbers about that path.
    """

    pair: Ints
    slot: Ints
    centre_m: Floats
    gain: Complexes

    @classmethod
    def none(cls, nodes: int) -> CellSums:
        """An empty set, of gains at so many wavenumbers."""
        none = np.zeros(0, dtype=np.int64)
        return cls(none, none, np.zeros(0), np.zeros((0, nodes), dtype=np.complex128))


class _Standing(NamedTuple):
    """S facets that may stand for cells.

    Attributes:
        middle, normal, area: (S, 3), (S, 3), (S,).
        number: (S,) which facets of the body these are.
        closed: whether they show on one side alone.
    """

    middle: Floats
    normal: Floats
    area: Floats
    number: Ints
    closed: bool

    @classmethod
    def of(cls, facets: Facets, some: Ints) -> _Standing:
        """Some of the facets of a body."""
        return cls(facets.middle_m[some], facets.normal[some], facets.area_m2[some], some, facets.closed)


class _Seen(NamedTuple):
    """Where E ends are, how they drift, and what they see of F facets: see `Ends`."""

    point: Floats
    drift: Floats
    of_view: Ints
    lit: Flags


class _Asked(NamedTuple):
    """M cells, sorted by pair: number along the pair's path, the path of its centre, and the one wanted."""

    pair: Ints
    slot: Ints
    centre: Floats
    wanted: Floats


def with_stand_ins(facets: Facets, ends: Ends, first: Ints, second: Ints, grid: Grid, sums: CellSums) -> Cells:
    """Cells and the facets that stand for their delays.

    Args:
        first, second: (R,) ends of each pair.
        sums: of some cells of these pairs.
    """
    pair, gain, centre, width = sums.pair, sums.gain, sums.centre_m, grid.taps * STEP_M
    wanted = centre + _excess(gain, grid.wavenumber_rad_m, width)
    seen = _Seen(ends.point_m, ends.drift_m, ends.view, ends.lit)
    facet, length, left = np.full(len(pair), -1), np.full(len(pair), np.inf), np.arange(len(pair))
    for some in (np.flatnonzero(facets.stands), np.arange(len(facets))):
        asked = _Asked(pair[left], sums.slot[left], centre[left], wanted[left])
        chosen, length[left] = _stand_ins(_Standing.of(facets, some), seen, first, second, asked, width)  # type: ignore[call-arg]
        facet[left[chosen >= 0]] = some[chosen[chosen >= 0]]
        # where none of those that stand for others has a path within a cell of the wanted one, all facets are asked
        left = np.flatnonzero(np.abs(length - centre) > width)
        if not len(left):
            break
    found = np.flatnonzero(facet >= 0)
    pair, facet, length = pair[found], facet[found], length[found]
    shift, of_centre = (
        _coupling(ends, point, first[pair], second[pair]) for point in (facets.middle_m[facet], facets.center_m)
    )
    off, moved = length - centre[found], of_centre - shift
    turn = np.exp(1j * (np.outer(off, grid.wavenumber_rad_m) + grid.centre_rad_m * moved[:, None]))
    return Cells(pair, facet, length - shift, gain[found] * turn)


def _coupling(ends: Ends, point_m: Floats, first: Ints, second: Ints) -> Floats:
    """(M,) how much longer the chirp makes paths over points of the body seem."""
    return ends.over(point_m, first)[1] + ends.over(point_m, second)[1]


def _excess(gain: Complexes, wavenumber: Floats, most_m: float) -> Floats:
    """(M,) path in excess of the cell's centre that the turning of the phase over frequency shows."""
    if gain.shape[1] == 1:
        return np.zeros(len(gain))
    turn = gain[:, 1:] * np.conj(gain[:, :-1])
    step = np.diff(wavenumber)
    weight = np.abs(turn) * step
    excess = -np.sum(weight * np.angle(turn) / step, axis=1) / np.maximum(weight.sum(axis=1), 1e-300)
    return np.clip(excess, -most_m, most_m)


@compiled
def _stand_ins(standing, seen, first, second, asked, width):
    """(M,) facet that stands for each cell, near to its centroid and with a path near to the wanted.

    Besides (M,) its path as the chirp makes it seem.

    Cells in a row then have facets in a row, which move alike: otherwise what cancels between them would not stay so.

    Args:
        first, second: (R,) ends of the pairs.
        width: of a cell.
    """
    facet, length = np.empty(len(asked.pair), np.int64), np.zeros(len(asked.pair))
    for i in range(len(facet)):
        facet[i] = -1
    path, at = np.empty(len(standing.area)), np.empty(len(standing.area), np.int64)
    low = 0
    while low < len(facet):
        r, high = asked.pair[low], low
        while high < len(facet) and asked.pair[high] == r:
            high += 1
        count = _lit_paths(standing, seen, first[r], second[r], path, at)
        origin, row = asked.centre[low] - asked.slot[low] * width, _rows(asked.slot[low:high])
        over, which = path[:count], at[:count]
        place = _centroids(standing, over, which, origin, width, row)
        wanted = asked.wanted[low:high]
        _choose(standing.middle, over, which, origin, width, place, row, wanted, facet[low:high], length[low:high])
        low = high
    return facet, length


@inlined
def _rows(slot):
    """(C,) which of a pair's cells, from the first on, has each number along its path; -1 of those not asked for."""
    row = np.full(slot[-1] + 2, -1, np.int64)
    for i in range(len(slot)):
        row[slot[i]] = i
    return row


@inlined
def _lit_paths(standing, seen, a, b, path, at):
    """Fill in the paths over the facets that both ends see, as the chirp makes them seem, and which these are; return
    their number.

    Ends that share their light may be a little below one of them: its rim diffracts all the same.
    """
    middle, normal, ends, drift = standing.middle, standing.normal, seen.point, seen.drift
    count, here, there = 0, seen.lit[seen.of_view[a]], seen.lit[seen.of_view[b]]
    for f in range(len(middle)):
        if not (here[standing.number[f]] and there[standing.number[f]]):
            continue
        l = m = up = down = u = v = 0.0
        for k in range(3):
            x, y = ends[a, k] - middle[f, k], ends[b, k] - middle[f, k]
            l, m, up, down = l + x * x, m + y * y, up + x * normal[f, k], down + y * normal[f, k]
            u, v = u + x * drift[a, k], v + y * drift[b, k]
        if standing.closed or up * down > 0.0:
            l, m = np.sqrt(l), np.sqrt(m)
            path[count], at[count] = l + m + u / l + v / m, f
            count += 1
    return count


@inlined
def _centroids(standing, path, at, origin, width, row):
    """(C, 3) centroids of the facets that each cell asked for overlaps with; 0 where there is none."""
    cells = len(row)
    place, weight = np.zeros((cells, 3)), np.zeros(cells)
    for i in range(len(path)):
        here = (path[i] - origin) / width
        below = int(np.floor(here))
        if not (0 <= below < cells and row[below] >= 0) and not (0 <= below + 1 < cells and row[below + 1] >= 0):
            continue
        lower = np.cos(0.5 * np.pi * (here - below)) ** 2
        for c, part in ((below, lower), (below + 1, 1.0 - lower)):
            if 0 <= c < cells:
                share = standing.area[at[i]] * part
                weight[c] += share
                for k in range(3):
                    place[c, k] += share * standing.middle[at[i], k]
    for c in range(cells):
        if weight[c] > 0.0:
            for k in range(3):
                place[c, k] /= weight[c]
    return place


@inlined
def _choose(middle, path, at, origin, width, place, row, wanted, facet, length):
    """Fill in the facets of a pair's cells and their paths; where none overlaps, the one nearest by path."""
    best = np.full(len(wanted), np.inf)
    for j in range(len(path)):
        below = int(np.floor((path[j] - origin) / width))
        for c in (below, below + 1):
            if not 0 <= c < len(row) or row[c] < 0:
                continue
            i = row[c]
            miss = ((path[j] - wanted[i]) / PATH_M) ** 2
            for k in range(3):
                miss += ((middle[at[j], k] - place[c, k]) / PLACE_M) ** 2
            if miss < best[i]:
                best[i], facet[i], length[i] = miss, at[j], path[j]
    for i in range(len(wanted)):
        if facet[i] >= 0:
            continue
        near = np.inf
        for j in range(len(path)):
            if abs(path[j] - wanted[i]) < near:
                near, facet[i], length[i] = abs(path[j] - wanted[i]), at[j], path[j]
