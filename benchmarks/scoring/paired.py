"""Two measurements of the same walks: what was lost, and whether a summary has moved."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from benchmarks.scoring.statistics import BOOTSTRAP, expanded_confidence, mcnemar

Summary = Callable[..., Any]
"""`np.median` or `np.mean`."""
FEW_PAIRS = 5
"""Below so many walks the span of all differences holds their median less than 9 times in 10: no interval says much."""
BATCH_VALUES = 1_000_000
"""Resampled values held at a time."""


@dataclass(frozen=True)
class Change:
    """Right and wrong on the same walks.

    Attributes:
        lost: right before and wrong now; gained: the other way round.
        n: walks.
        p: exact two-sided McNemar.
    """

    lost: int
    gained: int
    n: int
    p: float

    @property
    def loss_points(self) -> float:
        """Loss of the rate in percentage points; negative is a gain, NaN of no walks."""
        return 100.0 * (self.lost - self.gained) / self.n if self.n else float("nan")


def change_of(before: Mapping[str, bool], now: Mapping[str, bool]) -> Change:
    """Compare the walks that both know."""
    shared = before.keys() & now.keys()
    lost = sum(before[label] and not now[label] for label in shared)
    gained = sum(now[label] and not before[label] for label in shared)
    return Change(lost, gained, len(shared), mcnemar(lost, gained))


@dataclass(frozen=True)
class Shift:
    """How a summary of paired differences (now - before) lies.

    Attributes:
        value: the summary; NaN without a pair.
        low, high: its bootstrap interval, each bound one-sided at the confidence asked for.
        n: pairs with both values; before, now: how many values each side had.
    """

    value: float
    low: float
    high: float
    n: int
    before: int
    now: int


def shift_of(
    before: Mapping[str, float], now: Mapping[str, float], summary: Summary, confidence: float = 0.95
) -> Shift:
    """Bootstrap the summary of the paired differences over walks, by expanded percentiles."""
    labels = sorted(before.keys() & now.keys())
    pairs = np.array([(before[label], now[label]) for label in labels], dtype=np.float64).reshape(-1, 2)
    had, has = (int(np.isfinite(pairs[:, k]).sum()) for k in (0, 1))
    difference = pairs[:, 1] - pairs[:, 0]
    difference = difference[np.isfinite(difference)]
    if len(difference) == 0:
        return Shift(np.nan, np.nan, np.nan, 0, had, has)
    value = float(summary(difference))
    if len(difference) == 1:
        return Shift(value, value, value, 1, had, has)
    low, high = scipy.stats.bootstrap(
        (difference,), summary, n_resamples=BOOTSTRAP, batch=max(1, BATCH_VALUES // len(difference)), vectorized=True,
        confidence_level=expanded_confidence(2.0 * confidence - 1.0, len(difference)), method="percentile", rng=0,
    ).confidence_interval  # fmt: skip
    return Shift(value, float(low), float(high), len(difference), had, has)
