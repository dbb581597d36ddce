"""Intervals, tests and quantiles: thin names over scipy.stats, each with the convention that the bench uses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

CONFIDENCE = 0.95
RESAMPLES = 2000


@dataclass(frozen=True)
class Rate:
    """A proportion with its 95 % Wilson interval.

    Attributes:
        k, n: successes and trials.
        low, high: ends of the interval, 0 to 1; NaN for no trials.
    """

    k: int
    n: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The proportion, 0 to 1; NaN for no trials."""
        return self.k / self.n if self.n else float("nan")

    def __str__(self) -> str:
        if self.n == 0:
            return "no data"
        share, low, high = 100 * self.value, 100 * self.low, 100 * self.high
        return f"{share:.1f} % ({self.k}/{self.n}, 95 % interval {low:.1f}-{high:.1f} %)"


def wilson(k: int, n: int) -> Rate:
    """A proportion with its Wilson score interval.

    Raises:
        ValueError: k outside 0..n.
    """
    if not 0 <= k <= n:
        raise ValueError(f"k must be 0..n, got {k} of {n}")
    if n == 0:
        return Rate(0, 0, float("nan"), float("nan"))
    interval = stats.binomtest(k, n).proportion_ci(CONFIDENCE, method="wilson")
    return Rate(k, n, float(interval.low), float(interval.high))


def lower_bound(k: int, n: int, confidence: float = CONFIDENCE) -> float:
    """One-sided exact (Clopper-Pearson) lower bound of a proportion: what a gate may claim. NaN for no trials."""
    if n == 0:
        return float("nan")
    return float(stats.binomtest(k, n, alternative="greater").proportion_ci(confidence, method="exact").low)


def mcnemar(only_first: int, only_second: int) -> float:
    """Exact two-sided p of McNemar's test, from the walks that only one of two detectors got right; 1 without any."""
    discordant = only_first + only_second
    return 1.0 if discordant == 0 else float(stats.binomtest(only_first, discordant, 0.5).pvalue)


def quantile_with_interval(
    errors: ArrayLike, quantile: float, clusters: ArrayLike | None = None, seed: int = 0
) -> tuple[float, float, float, int]:
    """A quantile with its 95 % bootstrap interval over whole clusters: the beeps of one walk are not independent.

    Args:
        errors: (n,) NaN are left out.
        quantile: 0 to 1; the smallest value whose cumulative share reaches it.
        clusters: (n,) names the walk of each value; None takes every value for itself.
        seed: of the resampling.

    Returns:
        Value, low and high end, and the number of values that are not NaN. The value is NaN without values, the ends
        with fewer than two clusters.
    """
    value = np.asarray(errors, dtype=np.float64)
    names = np.arange(len(value)) if clusters is None else np.asarray(clusters)
    kept = np.isfinite(value)
    order = np.argsort(value[kept], kind="stable")
    value = value[kept][order]
    if len(value) == 0:
        return float("nan"), float("nan"), float("nan"), 0
    walks, group = np.unique(names[kept][order], return_inverse=True)
    drawn = np.arange(len(walks))
    whole = _weighted_quantile(value, group, drawn, quantile)
    if len(walks) < 2:
        return whole, float("nan"), float("nan"), len(value)
    interval = stats.bootstrap(
        (drawn,),
        lambda chosen: _weighted_quantile(value, group, chosen, quantile),
        n_resamples=RESAMPLES,
        vectorized=False,
        confidence_level=CONFIDENCE,
        method="percentile",
        rng=np.random.default_rng(seed),
    ).confidence_interval
    return whole, float(interval.low), float(interval.high), len(value)


def _weighted_quantile(
    ordered: NDArray[np.float64], group: NDArray[np.int64], drawn: NDArray[np.int64], quantile: float
) -> float:
    """Quantile of ordered values whose clusters are drawn with repetition."""
    share = np.cumsum(np.bincount(drawn, minlength=int(group.max()) + 1)[group])
    place = int(np.searchsorted(share, quantile * share[-1], side="left"))
    return float(ordered[min(place, len(ordered) - 1)])
