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
    """A proportion with its 95 % Wilson interval; all NaN for no trials.

    Attributes:
        count, total: successes and trials.
        value, low, high: proportion and ends of its interval, 0 to 1.
    """

    count: int
    total: int
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Estimate:
    """A statistic of n values with its 95 % bootstrap interval; NaN where there are too few.

    Attributes:
        value, low, high: the statistic and the ends of its interval.
        count: values; `clusters`: walks they come from.
    """

    value: float
    low: float
    high: float
    count: int
    clusters: int


def rate(count: int, total: int) -> Rate:
    """Proportion with its Wilson score interval.

    Raises:
        ValueError: count outside 0..total.
    """
    if not 0 <= count <= total:
        raise ValueError(f"count must be 0..total, got {count} of {total}")
    if total == 0:
        return Rate(0, 0, np.nan, np.nan, np.nan)
    interval = stats.binomtest(count, total).proportion_ci(CONFIDENCE, method="wilson")
    return Rate(count, total, count / total, float(interval.low), float(interval.high))


def lower_bound(count: int, total: int, confidence: float = CONFIDENCE) -> float:
    """One-sided exact (Clopper-Pearson) lower bound of a proportion: what a gate may claim. NaN for no trials."""
    if total == 0:
        return np.nan
    return float(stats.binomtest(count, total, alternative="greater").proportion_ci(confidence, method="exact").low)


def mcnemar(only_first: int, only_second: int) -> float:
    """Exact two-sided p of McNemar's test: walks that only one of two detectors got right. 1 without any."""
    discordant = only_first + only_second
    return 1.0 if discordant == 0 else float(stats.binomtest(only_first, discordant, 0.5).pvalue)


def clustered_quantile(values: ArrayLike, cluster: ArrayLike, quantile: float = 0.5, seed: int = 0) -> Estimate:
    """A quantile with a bootstrap interval over whole clusters: the beeps of one walk are not independent.

    Args:
        values: (n,) NaN are left out.
        cluster: (n,) whole numbers that name the walk of each value.
        quantile: 0 to 1; the smallest value whose cumulative share reaches it.
        seed: of the resampling.
    """
    value, group = np.asarray(values, dtype=np.float64), np.asarray(cluster)
    kept = np.isfinite(value)
    value, group = value[kept], group[kept]
    order = np.argsort(value, kind="stable")
    value = value[order]
    names, group = np.unique(group[order], return_inverse=True)
    if len(value) == 0:
        return Estimate(np.nan, np.nan, np.nan, 0, 0)
    whole = _weighted_quantile(value, group, np.arange(len(names)), quantile)
    if len(names) < 2:
        return Estimate(whole, np.nan, np.nan, len(value), len(names))
    interval = stats.bootstrap(
        (np.arange(len(names)),),
        lambda drawn: _weighted_quantile(value, group, drawn, quantile),
        n_resamples=RESAMPLES,
        vectorized=False,
        confidence_level=CONFIDENCE,
        method="percentile",
        rng=np.random.default_rng(seed),
    ).confidence_interval
    return Estimate(whole, float(interval.low), float(interval.high), len(value), len(names))


def _weighted_quantile(
    ordered: NDArray[np.float64], group: NDArray[np.int64], drawn: NDArray[np.int64], quantile: float
) -> float:
    """Quantile of ordered values whose clusters are drawn with repetition."""
    share = np.cumsum(np.bincount(drawn, minlength=int(group.max()) + 1)[group])
    place = int(np.searchsorted(share, quantile * share[-1], side="left"))
    return float(ordered[min(place, len(ordered) - 1)])
