"""A threshold swept over scores: DET curves, and the share of collisions found where so many others stay quiet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.scoring.statistics import Rate, exact_rate
from obstaclewatch.support.arrays import Floats

TRUE_NEGATIVE_RATES = (0.90, 0.95, 0.97)
"""TN rates at which TP is reported."""


@dataclass(frozen=True)
class OperatingPoint:
    """What a threshold makes of the same walks; alerts are scores above it.

    The intervals are exact for this threshold. It was chosen on these walks without a collision: the true positive rate
    at another sample's threshold varies more, by what the interval of the true negative rate says.
    """

    threshold: float
    true_positive: Rate
    true_negative: Rate


def operating_point(hits: Floats, misses: Floats, true_negative_rate: float) -> OperatingPoint | None:
    """The least threshold that leaves at least such a share of the misses quiet.

    Args:
        hits: (H,) scores of walks with a collision.
        misses: (M,) of the others.
        true_negative_rate: above 0, at most 1.

    Returns:
        None without walks of both kinds, or if a score is NaN: the detector states none.

    >>> import numpy as np
    >>> point = operating_point(np.array([0.2, 0.6, 0.9]), np.array([0.0, 0.1, 0.1, 0.5]), 0.75)
    >>> point.threshold, point.true_positive.k, point.true_negative.k
    (0.1, 3, 3)
    """
    if len(hits) == 0 or len(misses) == 0 or np.isnan(hits).any() or np.isnan(misses).any():
        return None
    quiet = int(np.ceil(true_negative_rate * len(misses) - 1e-9))
    threshold = float(np.sort(misses)[quiet - 1])
    return OperatingPoint(
        threshold,
        exact_rate(int((hits > threshold).sum()), len(hits)),
        exact_rate(int((misses <= threshold).sum()), len(misses)),
    )


def det_curve(hits: Floats, misses: Floats) -> tuple[Floats, Floats]:
    """(T,) shares of misses with an alert and of hits without one, at every threshold, from the strictest on."""
    thresholds = np.append(np.inf, np.unique(np.concatenate([hits, misses]))[::-1])
    false = 1.0 - np.searchsorted(np.sort(misses), thresholds, side="left") / max(len(misses), 1)
    missed = np.searchsorted(np.sort(hits), thresholds, side="left") / max(len(hits), 1)
    return false, missed
