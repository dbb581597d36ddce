"""The probability of a collision by what was learned from simulated walks: a sum of curves, one for each number.

The log odds are a constant and, of every number of `Evidence`, a curve of straight pieces between knots; what is beyond
the outer knots counts as these do, so that nothing unusual can decide alone. A number that is missing has a constant
instead. `python -m benchmarks.training` learns the file `collision_model.json`; docs/tracking.md has its card.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.tracking.evidence import Evidence

FILE = Path(__file__).with_name("collision_model.json")


@dataclass(frozen=True)
class CollisionModel:
    """A model of F numbers with K knots each.

    Attributes:
        knots: (F, K) ascending, finite.
        values: (F, K) log odds at them.
        missing: (F,) log odds where a number is NaN.
        constant: log odds that are always added.
        left_m, thresholds: (2,) distances left, ascending, and the probabilities above which a walker is alerted
            there; linear between, constant beyond.

    >>> import numpy as np
    >>> from obstaclewatch.tracking.collision_model import collision_model
    >>> model = collision_model()
    >>> model.knots.shape == model.values.shape and bool(np.all(np.diff(model.knots) > 0.0))
    True
    """

    knots: Floats
    values: Floats
    missing: Floats
    constant: float
    left_m: Floats
    thresholds: Floats

    def probability(self, evidence: Evidence) -> float:
        """Of a collision."""
        return float(self.probabilities(np.array([evidence]))[0])

    def probabilities(self, evidence: Floats) -> Floats:
        """(n,) of a collision, by (n, F) numbers."""
        log_odds = np.full(len(evidence), self.constant)
        for number, knots, values, missing in zip(evidence.T, self.knots, self.values, self.missing, strict=True):
            log_odds += np.where(np.isnan(number), missing, np.interp(number, knots, values))
        found: Floats = 1.0 / (1.0 + np.exp(-log_odds))
        return found

    def suffices(self, probability: ArrayLike, left_m: ArrayLike) -> Flags:
        """Whether probabilities are enough for an alert with so much left to walk."""
        enough: Flags = np.asarray(probability) > np.interp(
            np.asarray(left_m, dtype=np.float64), self.left_m, self.thresholds
        )
        return enough

    @classmethod
    def from_file(cls, path: Path) -> CollisionModel:
        """The model of a file.

        Raises:
            ValueError: its numbers are not those of `Evidence`.
        """
        stored = json.loads(path.read_text(encoding="utf-8"))
        if list(stored["curves"]) != list(Evidence._fields):
            raise ValueError(f"{path.name} must have curves of {Evidence._fields}, got {tuple(stored['curves'])}")
        curves = stored["curves"].values()
        knots, values, missing = (
            np.array([curve[name] for curve in curves]) for name in ("knots", "values", "missing")
        )
        left_m, thresholds = np.array(stored["left_m"]), np.array(stored["thresholds"])
        return cls(knots, values, missing, float(stored["constant"]), left_m, thresholds)


@lru_cache(maxsize=1)
def collision_model() -> CollisionModel:
    """The model that comes with the detector."""
    return CollisionModel.from_file(FILE)
