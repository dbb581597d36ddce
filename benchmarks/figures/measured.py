"""From tables to bars, curves and words: what every figure's builder shares."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.cells.detectors import detector_label
from benchmarks.cells.spec import counts_as
from benchmarks.figures.data import Bar, Curve, distribution_steps
from benchmarks.figures.plots import Line
from benchmarks.runs.results import RunData
from benchmarks.scoring.paper_values import SHOWN, PaperValue, RatePair
from benchmarks.scoring.scores import (
    PAPER_RECIPE,
    Table,
    absolute_errors,
    recipe_of,
    true_negative_rate,
    true_positive_rate,
)
from benchmarks.scoring.statistics import Rate, quantile, quantile_with_interval, share_of_clusters
from obstaclewatch.support.arrays import Flags, Floats, Strings

BASELINE = "DistanceOnlyDetector"
NO_DATA = "no data"
TP = "TP: collisions with an alert before contact"
TN = "TN: other walks without an alert"
INTERVALS = "Whiskers: exact 95 % intervals; counts below the bars."
TOP = 112.0
"""Upper end of an axis of percentages, with room for numbers on the bars."""


def detectors_of(run: RunData) -> list[str]:
    """Detectors in the order of the suite, as results call them: classes of a user's own without their module."""
    names = dict.fromkeys(name for cell in run.cells for name in cell["cell"]["detectors"])
    return [detector_label(name) for name in names]


def walking_detectors(run: RunData) -> list[str]:
    """Those that ran on walks, without those of standing measurements alone; all where the run has no walk."""
    names = dict.fromkeys(n for c in run.cells if counts_as(c["cell"], "approach") for n in c["cell"]["detectors"])
    return [detector_label(name) for name in names] or detectors_of(run)


def judged_detectors(run: RunData) -> list[str]:
    """The same without the baseline of section 4.8, which has a figure of its own, unless there is nothing else."""
    names = detectors_of(run)
    return [name for name in names if name != BASELINE] or names or ["PaperDetector"]


def strata(run: RunData, column: str) -> list[str]:
    """Values of a cell's field in the order of the plan, failed cells included: a stratum that failed stays visible."""
    return list(dict.fromkeys(str(c["cell"][column]) for c in run.cells if counts_as(c["cell"], "approach")))


def rules_text(run: RunData) -> str:
    """Which walks these are, and what can be held against the paper; empty without walks."""
    recipe = recipe_of(run)
    if recipe in ("", PAPER_RECIPE):
        return recipe and "Recipe paper: clear-cut walks, as in the paper's field test."
    return f"Recipe {recipe}: not the paper's field test, so its rates are not compared."


def sentences(said: Sequence[str], end: str = ".") -> str:
    """Clauses as one sentence; without any it says that there is no data."""
    return f"{'; '.join(said)}{end}" if said else "No data."


def percents(found: Rate) -> tuple[float, float, float]:
    """A rate and the ends of its interval, %."""
    return 100.0 * found.value, 100.0 * found.low, 100.0 * found.high


def binned_rates(
    detector: str,
    edges: Sequence[float],
    place: Floats,
    hit: Flags,
    aside: float = 0.0,
    walks: NDArray[Any] | None = None,
) -> Line:
    """Shares of (n,) hits by bin of their places, percent, with 95 % intervals, at the mean place of each bin.

    `aside` is added to the places, so that the whiskers of two detectors stay apart. `walks` says of beeps whose they
    are; without it every hit is a walk of its own, and intervals are exact.
    """
    own = np.arange(len(place)) if walks is None else walks
    bins = [mask for low, high in pairwise(edges) if (mask := (place >= low) & (place < high)).any()]
    value, low, high = 100.0 * np.array([share_of_clusters(hit[m], own[m]) for m in bins]).reshape(-1, 3).T
    x = np.array([place[mask].mean() for mask in bins]) + aside
    return Line(detector, detector, x, value, "points", low, high)


def rate_bar(group: str, series: str, found: Rate, paper: PaperValue | None = None) -> Bar:
    """A rate in percent with its exact interval."""
    return Bar(group, series, *percents(found), f"{found.k}/{found.n}", found.n, paper)


def rate_pair(group: str, table: Table, paper: RatePair | None) -> list[Bar]:
    """TP and TN of the walks of a table, beside the paper's where it has them."""
    return [
        rate_bar(group, TP, true_positive_rate(table), None if paper is None else paper.true_positive),
        rate_bar(group, TN, true_negative_rate(table), None if paper is None else paper.true_negative),
    ]


def finite_quantile(values: Floats, q: float) -> float:
    """`quantile` of the finite values; NaN without any."""
    finite = values[np.isfinite(values)]
    return float(quantile(finite, q)) if len(finite) else np.nan


def error_curve(
    table: Table, estimate: str, truth: str, unit: str, label: str, key: str, quantile: float, dashed: bool = False
) -> Curve:
    """Distribution of |estimate - truth| over the beeps that have an estimate.

    Args:
        unit: "m" or "rad", of the columns; the curve is in cm or degrees.
        quantile: the second quantile of the summary, beside the median.
    """
    scale, shown = SHOWN[unit]
    errors = scale * absolute_errors(table, estimate, truth)
    value, share = distribution_steps(errors)
    found = int(np.isfinite(errors).sum())
    middle = quantile_text(errors, 0.5, shown, table["label"])
    upper = quantile_text(errors, quantile, shown, table["label"])
    summary = f"median {middle}; P{100 * quantile:.0f} {upper}; {found} of {len(errors)} beeps"
    return Curve(label, key, dashed, value, share, found, len(errors), summary)


def quantile_text(errors: Floats, quantile: float, unit: str, walks: Strings) -> str:
    """ "0.41 cm (0.38-0.45)": a quantile and its interval over walks; "no data" without a value.

    The unit is one of `SHOWN`, with its space.
    """
    value, low, high, count = quantile_with_interval(errors, quantile, walks)
    if count == 0:
        return "no estimate" if len(errors) else NO_DATA
    ends = f" ({significant(low)}–{significant(high)})" if np.isfinite(low) else ""
    return f"{significant(value)}{unit}{ends}"


def significant(value: float) -> str:
    """Two digits that count, and no exponent: 0.041, 0.41, 4.1, 41, 410."""
    if value == 0.0 or not np.isfinite(value):
        return f"{value:.0f}" if value == 0.0 else "–"
    digits = max(0, 1 - int(np.floor(np.log10(abs(value)))))
    return f"{value:.{digits}f}"


def rate_text(found: Rate) -> str:
    """ "84.3 % (77.1–89.5 %, 108 of 128)"; "no data" without trials."""
    if found.n == 0:
        return NO_DATA
    value, low, high = percents(found)
    return f"{value:.1f} % ({low:.1f}–{high:.1f} %, {found.k} of {found.n})"


def against_paper(value: float, low: float, high: float, paper: PaperValue, higher_is_better: bool) -> str:
    """How a measured value with its interval stands to the paper's, in its unit: "better", "worse" or "inconclusive",
    where the interval holds the paper's value and so decides nothing; empty without a value or an interval."""
    if not np.isfinite([value, low, high]).all():
        return ""
    if low <= paper.value <= high:
        return "inconclusive"
    return "better" if (value > paper.value) == higher_is_better else "worse"


def rate_against(found: Rate, paper: PaperValue, higher_is_better: bool = True) -> str:
    """A clause for a sentence: "worse than the paper (94.6 %)"."""
    word = against_paper(found.value, found.low, found.high, paper, higher_is_better)
    joined = {"better": "better than", "worse": "worse than", "inconclusive": "inconclusive against"}
    return f"{joined.get(word, 'not comparable with')} the paper ({paper.text})"


def extreme(groups: dict[str, Rate], pick: Callable[..., str] = min) -> str:
    """Name of the group with the least (or greatest) rate; empty if none has data."""
    measured = [name for name, found in groups.items() if found.n]
    return pick(measured, key=lambda name: groups[name].value) if measured else ""
