"""Likelihood ratios along all straight approaches, summed beep by beep before anything is called a peak.

A running sum of log likelihood ratios for every range and closing speed (track before detect; Page's test: what falls
below zero starts anew). From beep to beep a speed moves its ranges by an integer number of cells, so an update is one
addition of a shifted array, however many beeps the likelihood spans. Echoes too weak to be found in any one beep add
up.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats, Singles
from obstaclewatch.support.compiled import compiled, inlined

SPEEDS_M_S = (0.45, 3.2)
CHANGE = 0.4
"""What a change to the next speed costs: bearings grow, and so the closing speed falls."""
EXPECTED_POWER = 3.0
"""Power over noise of the echoes that are looked for: 8 dB as 2E/N0."""
NEARLY = 4.0
"""Likelihood by which lines of neighbouring speeds may differ: they share most of their cells."""
BIAS = 0.4
"""Of the largest among the three or four independent samples that a cell stands for."""
LOSS = float(np.log1p(EXPECTED_POWER)) + BIAS
RATIO_LIMITS = (-1.2, 4.0)


@inlined
def log_ratio(power: Floats) -> Singles:
    """(N // 2,) log likelihood ratios of cells from (N,) powers over noise: fluctuating echo against noise alone.

    A cell stands for two samples and, because gait moves a reading by 2.8 cm, takes the highest of its neighbours.
    """
    pairs = np.empty(len(power) // 2)
    for cell in range(len(pairs)):
        pairs[cell] = max(power[2 * cell], power[2 * cell + 1])
    ratio, gain = np.empty(len(pairs), dtype=np.float32), EXPECTED_POWER / (1.0 + EXPECTED_POWER)
    for cell in range(len(ratio)):
        highest = max(pairs[max(cell - 1, 0)], pairs[cell], pairs[min(cell + 1, len(pairs) - 1)])
        ratio[cell] = min(max(highest * gain - LOSS, RATIO_LIMITS[0]), RATIO_LIMITS[1])
    return ratio


class LineLikelihood:
    """Running likelihood over closing speeds and ranges.

    Args:
        cells: number of ranges.
        cell_m: their spacing.
        period_s: between beeps.
    """

    def __init__(self, cells: int, cell_m: float, period_s: float) -> None:
        self.period_s = period_s
        step = cell_m / period_s
        shifts = np.arange(round(SPEEDS_M_S[0] / step), round(SPEEDS_M_S[1] / step) + 1)
        self.speeds_m_s = shifts * step
        self._cells, self._first = cells, int(shifts[0])
        self._width = cells + int(shifts[-1])
        self._sum, self._before = np.zeros((2, len(shifts), self._width), dtype=np.float32)

    def clear(self) -> None:
        """Forget everything."""
        self._sum[:], self._before[:] = 0.0, 0.0

    def add(self, ratio: Singles) -> None:
        """Move every speed's ranges nearer by one beep and add what was received there, (cells,) log ratios."""
        self._sum, self._before = self._before, self._sum
        _gather(self._sum, self._before, ratio, self._first)

    def fade(self, first: int, last: int, share: float = 0.0) -> None:
        """Keep only a share of the likelihood of the cells from `first` on and before `last`."""
        _fade(self._sum, max(first, 0), min(max(last, 0), self._width), np.float32(share))

    def best(self) -> tuple[float, int]:
        """The most that any line has gathered, and the cell that it has reached."""
        best = int(np.argmax(self._sum))
        return float(self._sum.flat[best]), best % self._width

    def speeds_to(self, cell: int) -> Floats:
        """(n,) closing speeds, m/s, of the lines to a cell that have gathered nearly the most."""
        gathered = self._sum[:, cell]
        return self.speeds_m_s[gathered >= gathered.max() - NEARLY]


@compiled
def _gather(gathered: Singles, likelihood: Singles, ratio: Singles, first: int) -> None:
    """Fill in likelihood a beep later: of a line's own and its neighbours' the best, none below 0, and what was
    received.

    Row k's ranges come `first + k` cells nearer; those beyond the ones received have none, before (S, width) and after.
    """
    last, change = len(likelihood) - 1, np.float32(CHANGE)
    for row in range(last + 1):
        slow, fast = max(row - 1, 0), min(row + 1, last)
        own, slower = likelihood[row, first + row :], likelihood[slow, first + slow :]
        faster = likelihood[fast, first + fast :]
        for cell in range(len(ratio)):
            best = own[cell] if own[cell] > 0.0 else np.float32(0.0)
            best = slower[cell] - change if slower[cell] - change > best else best
            best = faster[cell] - change if faster[cell] - change > best else best
            gathered[row, cell] = best + ratio[cell]


@compiled
def _fade(likelihood: Singles, first: int, last: int, share: np.float32) -> None:
    """Scale (S, width) likelihood in place from a cell on and before another."""
    for row in range(len(likelihood)):
        for cell in range(first, last):
            likelihood[row, cell] *= share
