"""Sums on a grid of path length, and of its cells: a few centimetres of path each.

On the grid each contribution has its phase at the band's centre; what it has beyond that at another frequency turns
slowly over path length, so the grid may be coarse. Cells overlap smoothly and add up to one: a cell between two echoes
cancels in itself and can be left out. Where ends move, lengths are those that the chirp makes them seem
(`waves.sweep`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints

STEP_M = 4e-3  # of the grid: 2 mm move no echo by more than 0.02 dB


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

    def held(self, total: Complexes) -> Flags:
        """(R, C) which cells there is anything of in (R, Q, points) sums."""
        part = np.logical_or.reduce(self._parts(total), axis=(1, 3))
        return part[:, :-1] | part[:, 1:]

    def cell_sums(self, total: Complexes, pair: Ints, slot: Ints) -> Complexes:
        """(M, Q, K) sums of cells about their centres from (R, Q, points) sums at the band's centre."""
        offset = STEP_M * np.arange(1 - self.taps, self.taps + 1)
        window = np.cos(0.5 * np.pi * offset / (self.taps * STEP_M)) ** 2
        beyond = self.wavenumber_rad_m - self.centre_rad_m
        spread = np.sinc(0.5 * beyond * STEP_M / np.pi) ** 2  # what sharing between two points takes off
        carry = window[:, None] * np.exp(-1j * np.outer(offset, beyond)) / spread
        part = self._parts(total)
        before, after = (part[pair, :, at].reshape(-1, self.taps) for at in (slot, slot + 1))  # one product, not M
        sums = before @ carry[: self.taps] + after @ carry[self.taps :]
        sums = sums.reshape(len(pair), total.shape[1], len(beyond))
        return sums * np.exp(1j * self.centre_rad_m * (self._centres_m() - self.lead_m))[slot, None, None]

    def _parts(self, total: Complexes) -> Complexes:
        """(R, Q, C + 1, taps) points from one cell's centre to the next."""
        return total.reshape(*total.shape[:-1], self.cells + 1, self.taps)

    def _centres_m(self) -> Floats:
        """(C,) path of each cell's centre from the grid's first point on."""
        return STEP_M * (self.taps - 1.0 + self.taps * np.arange(self.cells, dtype=np.float64))

    def centre_m(self, middle_path_m: Floats, slot: Ints) -> Floats:
        """(M,) path of cells from (M,) paths over the body's centre."""
        return middle_path_m - self.lead_m + self._centres_m()[slot]


def cell_taps(nodes: int) -> int:
    """Steps of the grid from one cell to the next: polynomials through the nodes then move no echo by over 0.01 dB."""
    return max(1, round(1.5 * nodes - 4.0))
