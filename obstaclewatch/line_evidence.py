"""Evidence along all straight approaches at once, gathered beep by beep before anything is called a peak.

A running sum of log likelihood ratios for every range and closing speed (track before detect; Page's test: what falls
below zero starts anew). From beep to beep a speed moves its ranges by whole cells, so an update is one addition of a
shifted array, however many beeps the evidence spans. Echoes too weak to be found in any one beep add up.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

SPEEDS_M_S = (0.45, 3.2)
CHANGE = 0.4
"""What a change to the next speed costs: bearings grow, and so the closing speed falls."""
EXPECTED_POWER = 3.0
"""Power over noise of the echoes that are looked for: 8 dB as 2E/N0."""
NEARLY = 4.0
"""Evidence by which lines of neighbouring speeds may differ: they share most of their cells."""
BIAS = 0.4
"""Of the largest among the three or four independent samples that a cell stands for."""
RATIO_LIMITS = (-1.2, 4.0)


def log_ratio(power: NDArray[np.float64]) -> NDArray[np.float32]:
    """(N // 2,) log likelihood ratios of cells from (N,) powers over noise: fluctuating echo against noise alone.

    A cell stands for two samples and, because gait moves a reading by 2.8 cm, takes the highest of its neighbours.
    """
    pairs = power[: len(power) // 2 * 2].reshape(-1, 2).max(axis=1)
    near = pairs.copy()
    np.maximum(near[1:], pairs[:-1], out=near[1:])
    np.maximum(near[:-1], pairs[1:], out=near[:-1])
    ratio = near * (EXPECTED_POWER / (1.0 + EXPECTED_POWER)) - np.log1p(EXPECTED_POWER) - BIAS
    return np.minimum(np.maximum(ratio, RATIO_LIMITS[0]), RATIO_LIMITS[1]).astype(np.float32)


class LineEvidence:
    """Running evidence over closing speeds and ranges.

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
        self._sum = np.zeros((len(shifts), self._width), dtype=np.float32)

    def clear(self) -> None:
        """Forget everything."""
        self._sum[:] = 0.0

    def add(self, ratio: NDArray[np.float32]) -> None:
        """Move every speed's ranges nearer by one beep and add what was heard there, (cells,) log ratios."""
        moved = self._moved()
        best = np.maximum(moved, np.float32(0.0))
        np.maximum(best[1:], moved[:-1] - np.float32(CHANGE), out=best[1:])
        np.maximum(best[:-1], moved[1:] - np.float32(CHANGE), out=best[:-1])
        np.add(best, ratio, out=self._sum[:, : self._cells])

    def fade(self, first: int, last: int, share: float = 0.0) -> None:
        """Keep only a share of the evidence of the cells from `first` on and before `last`."""
        self._sum[:, max(first, 0) : max(last, 0)] *= np.float32(share)

    def best(self) -> tuple[float, int]:
        """The most that any line has gathered, and the cell that it has reached."""
        best = int(np.argmax(self._sum))
        return float(self._sum.flat[best]), best % self._width

    def speeds_to(self, cell: int) -> NDArray[np.float64]:
        """(n,) closing speeds, m/s, of the lines to a cell that have gathered nearly the most."""
        gathered = self._sum[:, cell]
        return self.speeds_m_s[gathered >= gathered.max() - NEARLY]

    def _moved(self) -> NDArray[np.float32]:
        """(S, cells) view of the sums a beep farther away: row k begins `first + k` cells on."""
        row, cell = self._sum.strides
        start = self._sum[0, self._first :]
        return as_strided(start, (len(self._sum), self._cells), (row + cell, cell), writeable=False)
