"""From sums on a grid of path length to cells: a few centimetres of path each, with one point that stands for it.

On the grid each contribution has its phase at the band's centre; what it has beyond that at another frequency turns
slowly over path length, so the grid may be coarse. Cells overlap smoothly and add up to one: a cell between two
echoes cancels in itself and can be left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from obstaclewatch.support.compiled import compiled

STEP_M = 4e-3  # of the grid: 2 mm move no echo by more than 0.02 dB
PATH_M, PLACE_M = 2e-3, 0.05  # misses of path and of place that weigh alike when a facet is chosen for a cell
STAND_M, ONE_IN = 0.02, 7  # apart are, on average, the facets of which one may stand for a cell; fewer of large ones


@dataclass(frozen=True)
class Grid:
    """Points of path length about a body, the same for every pair of ends.

    Attributes:
        radius_m: of the body.
        taps: grid points from a cell's centre to the next.
        wavenumber_rad_m: (K,) of the band's nodes.
        centre_rad_m: wavenumber at which contributions are evaluated.
    """

    radius_m: float
    taps: int
    wavenumber_rad_m: Floats
    centre_rad_m: float

    @classmethod
    def over(cls, radius_m: float, wavenumber_rad_m: Floats) -> Grid:
        """A grid whose cells are as wide as polynomials through the nodes can carry: 2 cm for six, 3 cm for eight."""
        centre = 0.5 * float(wavenumber_rad_m[0] + wavenumber_rad_m[-1])
        return cls(radius_m, cell_taps(len(wavenumber_rad_m)), wavenumber_rad_m, centre)

    @property
    def cells(self) -> int:
        """Number of cells that cover all paths over the body."""
        return int(np.ceil(4.0 * self.radius_m / (self.taps * STEP_M))) + 2

    @property
    def points(self) -> int:
        """Number of points, with half a cell to spare at either end."""
        return (self.cells + 1) * self.taps

    @property
    def lead_m(self) -> float:
        """From the first point to the path over the body's centre."""
        return 2.0 * self.radius_m + self.taps * STEP_M

    def cell_sums(self, total: Complexes) -> Complexes:
        """(R, C, K) sums of the cells about their centres from (R, points) sums at the band's centre."""
        offset = STEP_M * np.arange(1 - self.taps, self.taps)
        window = np.cos(0.5 * np.pi * offset / (self.taps * STEP_M)) ** 2
        beyond = self.wavenumber_rad_m - self.centre_rad_m
        spread = np.sinc(0.5 * beyond * STEP_M / np.pi) ** 2  # what sharing between two points takes off
        carry = window[:, None] * np.exp(-1j * np.outer(offset, beyond)) / spread
        views = np.lib.stride_tricks.sliding_window_view(total, 2 * self.taps - 1, axis=-1)[..., :: self.taps, :]
        sums = views[..., : self.cells, :] @ carry
        return sums * np.exp(1j * self.centre_rad_m * (self._centres_m() - self.lead_m))[:, None]

    def _centres_m(self) -> Floats:
        """(C,) path of each cell's centre from the grid's first point on."""
        return STEP_M * (self.taps - 1.0 + self.taps * np.arange(self.cells, dtype=np.float64))

    def centre_m(self, middle_path_m: Floats, slot: Ints) -> Floats:
        """(M,) path of cells from (M,) paths over the body's centre."""
        return middle_path_m - self.lead_m + self._centres_m()[slot]


def cell_taps(nodes: int) -> int:
    """Steps of the grid from one cell to the next: polynomials through the nodes then move no echo by over 0.01 dB."""
    return max(1, round(1.5 * nodes - 4.0))


@compiled
def stand_ins(
    middle, normal, area, spot, closed, ends, view, lit, first, second, pair, slot, centre, wanted, width
):  # fmt: skip
    """(M,) facet that stands for each cell, near to its centroid and with a path near to the wanted, and (M,) its path.

    Cells in a row then have facets in a row, which move alike: otherwise what cancels between them would not stay so.

    Args:
        middle, normal, area, spot: (F,) of the facets that may stand in.
        ends, view, lit: (E, 3), (E,), (V, S) of the ends.
        first, second: (R,) ends of the pairs.
        pair, slot, centre, wanted: (M,) of the cells, sorted by pair: number along the path, its path, the one wanted.
        width: of a cell.
    """
    facet, length = np.empty(len(pair), np.int64), np.zeros(len(pair))
    for i in range(len(pair)):
        facet[i] = -1
    path, at = np.empty(len(area)), np.empty(len(area), np.int64)
    low = 0
    while low < len(pair):
        r, high = pair[low], low
        while high < len(pair) and pair[high] == r:
            high += 1
        count = _lit_paths(middle, normal, spot, closed, ends, view, lit, first[r], second[r], path, at)
        origin = centre[low] - slot[low] * width
        place = _centroids(middle, area, path, at, count, origin, width, slot[high - 1] + 2)
        _choose(middle, path, at, count, place, slot, wanted, low, high, origin, width, facet, length)
        low = high
    return facet, length


@compiled
def _lit_paths(middle, normal, spot, closed, ends, view, lit, a, b, path, at):
    """Fill in the paths over the facets that both ends see, and which these are; return their number."""
    count, here, there = 0, lit[view[a]], lit[view[b]]
    for f in range(len(spot)):
        if not (here[spot[f]] and there[spot[f]]):
            continue
        l = m = up = down = 0.0
        for k in range(3):
            x, y = ends[a, k] - middle[f, k], ends[b, k] - middle[f, k]
            l, m, up, down = l + x * x, m + y * y, up + x * normal[f, k], down + y * normal[f, k]
        if up * down > 0.0 and (up > 0.0 or not closed):
            path[count], at[count] = np.sqrt(l) + np.sqrt(m), f
            count += 1
    return count


@compiled
def _centroids(middle, area, path, at, count, origin, width, cells):
    """(cells, 3) centroids of the facets that each cell overlaps with; 0 where there is none."""
    place, weight = np.zeros((cells, 3)), np.zeros(cells)
    for i in range(count):
        here = (path[i] - origin) / width
        below = int(np.floor(here))
        for c in (below, below + 1):
            if 0 <= c < cells:
                share = area[at[i]] * np.cos(0.5 * np.pi * (here - c)) ** 2
                weight[c] += share
                for k in range(3):
                    place[c, k] += share * middle[at[i], k]
    for c in range(cells):
        if weight[c] > 0.0:
            for k in range(3):
                place[c, k] /= weight[c]
    return place


@compiled
def _choose(middle, path, at, count, place, slot, wanted, low, high, origin, width, facet, length):
    """Fill in the facets of the cells from `low` to `high`; where none overlaps, the one nearest by path."""
    best, row = np.empty(high - low), np.empty(slot[high - 1] + 2, np.int64)
    for c in range(len(row)):
        row[c] = -1
    for i in range(low, high):
        row[slot[i]], best[i - low] = i, np.inf
    for j in range(count):
        below = int(np.floor((path[j] - origin) / width))
        for c in (below, below + 1):
            if not 0 <= c < len(row) or row[c] < 0:
                continue
            i = row[c]
            miss = ((path[j] - wanted[i]) / PATH_M) ** 2
            for k in range(3):
                miss += ((middle[at[j], k] - place[c, k]) / PLACE_M) ** 2
            if miss < best[i - low]:
                best[i - low], facet[i], length[i] = miss, at[j], path[j]
    for i in range(low, high):
        if facet[i] >= 0:
            continue
        near = np.inf
        for j in range(count):
            if abs(path[j] - wanted[i]) < near:
                near, facet[i], length[i] = abs(path[j] - wanted[i]), at[j], path[j]


def standing(area_m2: Floats) -> Ints:
    """Facets, one in so many, that lie `STAND_M` apart on average; one in `ONE_IN` at the most."""
    every = max(ONE_IN, round(STAND_M**2 / float(area_m2.mean())))
    return np.arange(0, len(area_m2), every)
