"""A threshold swept over scores: DET curves, and the share of collisions found where so many others stay quiet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.scoring.statistics import Rate, exact_rate, lower_bound, upper_quantile_bound
from obstaclewatch.support.arrays import Floats

TRUE_NEGATIVE_RATES = (0.90, 0.95, 0.97)
"""TN rates at which TP is reported."""


@dataclass(frozen=True)
class OperatingPoint:
    """What a threshold makes of the same walks; alerts are scores above it.

    The interval of the true positive rate is that at the threshold of all walks that could be drawn, which those
    without a collision tell only so well (`true_positive_bounds`): 60 of them bound none for a TN of 97 %. That of the
    true negative rate is exact for this threshold.
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

    Raises:
        ValueError: a rate that is not above 0 and at most 1.

    >>> import numpy as np
    >>> point = operating_point(np.array([0.2, 0.6, 0.9]), np.array([0.0, 0.1, 0.1, 0.5]), 0.75)
    >>> point.threshold, point.true_positive.k, point.true_negative.k
    (0.1, 3, 3)
    >>> round(point.true_positive.low, 2), point.true_positive.high
    (0.0, 1.0)
    """
    if not 0.0 < true_negative_rate <= 1.0:
        raise ValueError(f"true_negative_rate must be above 0 and at most 1, got {true_negative_rate}")
    if len(hits) == 0 or len(misses) == 0 or np.isnan(hits).any() or np.isnan(misses).any():
        return None
    quiet = int(np.ceil(true_negative_rate * len(misses) - 1e-9))
    threshold = float(np.sort(misses)[quiet - 1])
    return OperatingPoint(
        threshold,
        Rate(int((hits > threshold).sum()), len(hits), *true_positive_bounds(hits, misses, true_negative_rate, 0.975)),
        exact_rate(int((misses <= threshold).sum()), len(misses)),
    )


def true_positive_bounds(
    hits: Floats, misses: Floats, true_negative_rate: float, confidence: float
) -> tuple[float, float]:
    """Lower and upper bound, each one-sided, of TP at the threshold that leaves a share of all other walks quiet.

    That threshold is a quantile of the misses' scores, known within two order statistics; at either the rate has its
    exact bound (Clopper and Pearson 1934). Half of what may fail is left to each, so a bound holds at least so often.
    It is 0 or 1 where so few misses bound no such quantile.

    >>> import numpy as np
    >>> hits, misses = np.linspace(0.0, 1.0, 101), np.linspace(0.0, 0.5, 101)
    >>> [round(bound, 2) for bound in true_positive_bounds(hits, misses, 0.9, 0.975)]
    [0.4, 0.69]
    """
    each = 1.0 - 0.5 * (1.0 - confidence)
    strict = upper_quantile_bound(misses, true_negative_rate, each)
    loose = -upper_quantile_bound(-misses, 1.0 - true_negative_rate, each)
    low = 0.0 if np.isnan(strict) else lower_bound(int((hits > strict).sum()), len(hits), each)
    high = 1.0 if np.isnan(loose) else 1.0 - lower_bound(int((hits <= loose).sum()), len(hits), each)
    return low, high


def det_curve(hits: Floats, misses: Floats) -> tuple[Floats, Floats]:
    """(T,) shares of misses with an alert and of hits without one, at every threshold, from the strictest on."""
    thresholds = np.append(np.inf, np.unique(np.concatenate([hits, misses]))[::-1])
    false = 1.0 - np.searchsorted(np.sort(misses), thresholds, side="left") / max(len(misses), 1)
    missed = np.searchsorted(np.sort(hits), thresholds, side="left") / max(len(hits), 1)
    return false, missed
