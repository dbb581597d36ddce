"""The bearing of what a track follows, by what was learned from simulated walks: a small dense network.

It takes what the track says (`bearing_evidence`), as `deviations`, and states how probable each bin of bearings is. The
bearing is the median, its claimed deviation half of what holds the middle 68 %. `python -m benchmarks.training bearing`
learns the weights and writes their card; docs/learned.md says what they were learned from.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from obstaclewatch.support.arrays import Floats, Singles
from obstaclewatch.support.whole_file import whole_file
from obstaclewatch.tracking.bearing_evidence import NUMBERS
from obstaclewatch.tracking.deviations import deviations

WEIGHTS = Path(__file__).with_name("bearing_model.npz")
EDGES_RAD = np.deg2rad([*np.arange(0.0, 40.0, 2.5), *np.arange(40.0, 95.0, 5.0)])
"""Of the bins."""
MIDDLE, ONE_DEVIATION = 0.5, (0.16, 0.84)
"""Shares of the probability below the median, and below a deviation less and more."""


@dataclass(frozen=True)
class BearingModel:
    """What was learned.

    Attributes:
        usual, spread: (NUMBERS,) mean and deviation of the numbers among what was learned from.
        weights, offsets: of each layer, (outputs, inputs) and (outputs,), single precision; all but the last keep what
            is positive.

    >>> import numpy as np
    >>> from obstaclewatch.tracking.bearing_evidence import NUMBERS
    >>> from obstaclewatch.tracking.bearing_model import bearing_model
    >>> bearing_rad, std_rad = bearing_model().bearings(np.zeros((2, NUMBERS)))
    >>> bearing_rad.shape, bool(np.all(std_rad > 0.0))
    ((2,), True)
    """

    usual: Floats
    spread: Floats
    weights: tuple[Singles, ...]
    offsets: tuple[Singles, ...]

    def bearings(self, evidence: Floats) -> tuple[Floats, Floats]:
        """(n,) unsigned bearings and their claimed deviations, rad, by (n, NUMBERS) of `bearing_evidence`."""
        below = np.cumsum(self.shares(evidence), axis=1)
        low, middle, high = (_reached(below, share) for share in (ONE_DEVIATION[0], MIDDLE, ONE_DEVIATION[1]))
        return middle, 0.5 * (high - low)

    def shares(self, evidence: Floats) -> Floats:
        """(n, bins) probabilities, which sum to 1."""
        values = scaled(evidence, self.usual, self.spread)
        for layer, (weight, offset) in enumerate(zip(self.weights, self.offsets, strict=True)):
            values = values @ weight.T + offset
            if layer < len(self.weights) - 1:
                values = np.maximum(values, 0.0)
        likely = np.exp(values.astype(np.float64) - values.max(axis=1, keepdims=True))
        found: Floats = likely / likely.sum(axis=1, keepdims=True)
        return found

    def write(self, weights: Path) -> None:
        """As plain arrays, which `from_file` reads."""
        layers = zip(self.weights, self.offsets, strict=True)
        arrays: dict[str, Any] = {"usual": self.usual, "spread": self.spread}
        for k, (weight, offset) in enumerate(layers):
            arrays |= {f"weight_{k}": weight, f"offset_{k}": offset}
        with whole_file(weights) as partial, partial.open("wb") as file:
            np.savez_compressed(file, **arrays)

    @classmethod
    def from_file(cls, weights: Path) -> BearingModel:
        """The model of a file.

        Raises:
            ValueError: it takes or gives other numbers than there are.
        """
        with np.load(weights, allow_pickle=False) as stored:
            layers = range(sum(name.startswith("weight_") for name in stored))
            found = cls(
                stored["usual"],
                stored["spread"],
                tuple(stored[f"weight_{k}"] for k in layers),
                tuple(stored[f"offset_{k}"] for k in layers),
            )
        size, asked = (found.weights[0].shape[1], found.weights[-1].shape[0]), (NUMBERS, len(EDGES_RAD) - 1)
        if size != asked:
            raise ValueError(f"{weights.name} must take {asked[0]} numbers and give {asked[1]}, got {size}")
        return found


@lru_cache(maxsize=1)
def bearing_model() -> BearingModel:
    """The model that comes with the detector."""
    return BearingModel.from_file(WEIGHTS)


def scaled(evidence: Floats, usual: Floats, spread: Floats) -> Singles:
    """(n, NUMBERS) what the network takes of `bearing_evidence`."""
    return deviations(evidence, usual, spread).astype(np.float32)


def _reached(below: Floats, share: float) -> Floats:
    """(n,) bearings below which so much of the probability lies, linear within the bins; `below` is (n, bins)."""
    before = np.minimum(np.sum(below < share, axis=1), below.shape[1] - 1)
    row = np.arange(len(below))
    lower = np.where(before > 0, below[row, before - 1], 0.0)
    part = np.clip((share - lower) / (below[row, before] - lower), 0.0, 1.0)
    found: Floats = EDGES_RAD[before] + part * (EDGES_RAD[before + 1] - EDGES_RAD[before])
    return found
