"""Kirchhoff's integral over the lit skin of a body, for surfaces that are neither plane and large nor smooth.

On a rigid surface the pressure is taken as twice the incident one where both ends see it and as nothing elsewhere:

    p = 1/(4 pi) int [(jk + 1/l) cos a + (jk + 1/m) cos b] e^{-jk(l + m)} / (l m) dS

with distances l, m and angles of incidence a, b of source and receiver: the mean of the integral and of its
reciprocal, so that ends can be swapped. Over a plane triangle with the phase linear between its corners the integral
is closed, 2 A exp[x1, x2, x3], the divided difference of the exponential at x = -jkL; the curvature of the phase and
of the surface over it shifts all three by 3/4 of what the middle's path is longer than the corners' mean (the
degree-two rule of quadrature on triangles). Where the surface is not rigid each triangle carries its own reflection
factor, at the geometric mean of both cosines, which both ends agree on: over a clothed person it runs from 0.56 where
sound falls square-on through 0 to -1 at grazing, and cells cancel by a factor of three.

Where a smooth surface ends at a rim, `fringe_waves` adds what the integral leaves out.

Contributions are gathered in cells of path length that overlap smoothly and add up to one: a cell between two echoes
cancels in itself and can be left out, the others have one delay each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from simulator.kirchhoff.fringe_waves import add_fringe_waves
from simulator.surfaces.facets import Facets

CELL_M = 0.02  # of path, about a wavelength: six frequencies then carry a cell's gain across the band to 0.02 dB
PATH_M, PLACE_M = 2e-3, 0.05  # misses of path and of place that weigh alike when a facet is chosen for a cell
_SMALL = 1e-2


@dataclass(frozen=True)
class Cells:
    """What R pairs of points hear of a body, by path length.

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
    facets: Facets, source_m: Floats, receiver_m: Floats, seen: Flags, wavenumber_rad_m: Floats,
    reflection: Complexes,
) -> Cells:  # fmt: skip
    """Kirchhoff's sum for R pairs of points in the body's rest frame.

    Args:
        source_m, receiver_m: (R, 3), images included.
        seen: (R, F) facets that nothing hides from either end.
        wavenumber_rad_m: (K,) rising.
        reflection: (C, K) factors of the surface at C cosines of incidence from 0 to 1 in even steps.
    """
    count = int(np.ceil(4.0 * facets.radius_m / CELL_M)) + 3
    shortest, total, weight, moment = _sums(
        *_arrays(facets), source_m, receiver_m, seen, wavenumber_rad_m, reflection, count
    )  # type: ignore[call-arg]  # fmt: skip
    add_fringe_waves(
        facets.creases, source_m, receiver_m, seen, wavenumber_rad_m, reflection, shortest, CELL_M, weight, total
    )
    pair, slot = np.nonzero(np.abs(total).max(axis=2) > 0.0)
    gain = total[pair, slot]
    centre = shortest[pair] + CELL_M * slot
    wanted = centre + _excess(gain, wavenumber_rad_m)
    place = moment[pair, slot] / weight[pair, slot, None]
    facet, length = _nearest(*_arrays(facets), source_m, receiver_m, seen, pair, slot, shortest, wanted, place)  # type: ignore[call-arg]
    gain = gain * np.exp(1j * (length - centre)[:, None] * wavenumber_rad_m)
    return Cells(pair, facet, length, gain)


def _arrays(facets: Facets) -> tuple:
    return facets.corner_m, facets.middle_m, facets.normal, facets.area_m2, facets.closed


def _excess(gain: Complexes, wavenumber: Floats) -> Floats:
    """(M,) path in excess of the cell's centre that the turning of the phase over frequency shows."""
    if gain.shape[1] == 1:
        return np.zeros(len(gain))
    turn = gain[:, 1:] * np.conj(gain[:, :-1])
    step = np.diff(wavenumber)
    slope = np.angle(turn) / step
    weight = np.abs(turn) * step
    excess = -np.sum(weight * slope, axis=1) / np.maximum(weight.sum(axis=1), 1e-300)
    return np.clip(excess, -CELL_M, CELL_M)


@numba.njit(cache=True)
def _view(x, normal, closed, source, receiver):
    """Distances and cosines (l, m, cos a, cos b) of a point of the skin; cosines 0 where an end is behind it."""
    l = m = a = b = 0.0
    for k in range(3):
        ds, dr = source[k] - x[k], receiver[k] - x[k]
        l += ds * ds
        m += dr * dr
        a += ds * normal[k]
        b += dr * normal[k]
    l, m = np.sqrt(l), np.sqrt(m)
    a, b = a / l, b / m
    if not closed and a < 0.0:
        a, b = -a, -b
    if a <= 0.0 or b <= 0.0:
        return l, m, 0.0, 0.0
    return l, m, a, b


@numba.njit(cache=True)
def _corner_paths(corner, source, receiver):
    """Path lengths over the three corners in rising order, and their mean."""
    path = np.empty(3)
    for i in range(3):
        l = m = 0.0
        for k in range(3):
            l += (source[k] - corner[i, k]) ** 2
            m += (receiver[k] - corner[i, k]) ** 2
        path[i] = np.sqrt(l) + np.sqrt(m)
    mean = (path[0] + path[1] + path[2]) / 3.0
    path.sort()
    return path[0], path[1], path[2], mean


@numba.njit(cache=True)
def _difference(a, b):
    """e^{j p2} exp[-j p1, -j p2, -j p3] for phases p1 <= p2 <= p3, a = p2 - p1 and b = p3 - p2."""
    s = a + b
    if s < _SMALL:
        return 0.5 - (a * a - a * b + b * b) / 24.0 + 1j * (a - b) * (1.0 / 6.0 - (a * a + b * b) / 120.0)
    left, right = 1.0 + 0.0j, 1.0 + 0.0j
    if a > 1e-12:
        left = (np.sin(a) + 2j * np.sin(0.5 * a) ** 2) / a
    if b > 1e-12:
        right = (np.sin(b) - 2j * np.sin(0.5 * b) ** 2) / b
    return (left - right) / (1j * s)


@numba.njit(cache=True)
def _sums(corner, middle, normal, area, closed, source, receiver, seen, wavenumber, reflection, count):
    """(R,) shortest path, (R, count, K) sums of the cells about their centres, weights and moments of their facets."""
    pairs, nodes = len(source), len(wavenumber)
    total = np.zeros((pairs, count, nodes), np.complex128)
    weight, moment = np.zeros((pairs, count)), np.zeros((pairs, count, 3))
    shortest = np.full(pairs, np.inf)
    for r in range(pairs):
        for f in range(len(area)):
            if seen[r, f]:
                l, m, a, _ = _view(middle[f], normal[f], closed, source[r], receiver[r])
                if a > 0.0:
                    shortest[r] = min(shortest[r], l + m)
        for f in range(len(area)):
            if not seen[r, f]:
                continue
            l, m, a, b = _view(middle[f], normal[f], closed, source[r], receiver[r])
            if a == 0.0:
                continue
            first, second, third, mean = _corner_paths(corner[f], source[r], receiver[r])
            shift = 0.75 * (l + m - mean)
            place = (l + m - shortest[r]) / CELL_M
            slot = int(place)
            share = np.sin(0.5 * np.pi * (place - slot)) ** 2
            scale = 2.0 * area[f] / (4.0 * np.pi * l * m)
            for s in range(2):
                part = scale * (1.0 - share if s == 0 else share)
                weight[r, slot + s] += part
                for k in range(3):
                    moment[r, slot + s, k] += part * middle[f, k]
            centre = shortest[r] + CELL_M * slot
            step = min(np.sqrt(a * b), 1.0) * (len(reflection) - 1)
            below = min(int(step), len(reflection) - 2)
            step -= below
            for n in range(nodes):
                k = wavenumber[n]
                phase = k * (second + shift - centre)
                value = _difference(k * (second - first), k * (third - second)) * (np.cos(phase) - 1j * np.sin(phase))
                value *= scale * (1j * k * (a + b) + a / l + b / m)
                value *= (1.0 - step) * reflection[below, n] + step * reflection[below + 1, n]
                turn = k * CELL_M
                total[r, slot, n] += (1.0 - share) * value
                total[r, slot + 1, n] += share * value * (np.cos(turn) + 1j * np.sin(turn))
    return shortest, total, weight, moment


@numba.njit(cache=True)
def _nearest(corner, middle, normal, area, closed, source, receiver, seen, pair, slot, shortest, wanted, place):
    """Facet of each cell near to a place, with a path near to the one wanted, and that path.

    Cells in a row then have facets in a row, which move alike: otherwise what cancels between them would not stay so.
    """
    facet, length = np.zeros(len(pair), np.int64), np.zeros(len(pair))
    best = np.full(len(pair), np.inf)
    first = 0
    while first < len(pair):
        r, last = pair[first], first
        while last < len(pair) and pair[last] == r:
            last += 1
        cell = np.full(slot[first:last].max() + 2, -1)
        for i in range(first, last):
            cell[slot[i]] = i
        for f in range(len(area)):
            if not seen[r, f]:
                continue
            l, m, a, _ = _view(middle[f], normal[f], closed, source[r], receiver[r])
            if a == 0.0:
                continue
            here = int((l + m - shortest[r]) / CELL_M)
            for s in (here, here + 1):
                if s >= len(cell) or cell[s] < 0:
                    continue
                i = cell[s]
                miss = ((l + m - wanted[i]) / PATH_M) ** 2
                for k in range(3):
                    miss += ((middle[f, k] - place[i, k]) / PLACE_M) ** 2
                if miss < best[i]:
                    best[i], facet[i], length[i] = miss, f, l + m
        first = last
    return facet, length
