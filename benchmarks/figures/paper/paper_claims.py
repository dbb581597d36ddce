"""Every claim of the paper that the bench can test, beside what was measured, with exact intervals and a verdict.

Rates are those of walks of the recipe `paper` alone, which is the paper's protocol, with the exact interval of Clopper
and Pearson (1934); medians and percentiles have a bootstrap over walks. A claim is "reached" where all of the 95 %
interval is at least as good as the paper says, "not reached" where all of it is worse, and "inconclusive" in between;
the paper's "about" and "around" are taken as the number they precede. Claims of an order ("larger is better") are
decided at 5 %: of the same walks by McNemar's exact test, of different ones by Fisher's, of many beeps a walk by a sign
test over walks, of objects by rank correlation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from benchmarks.figures.paper.claims_measured import (
    NO_MEASUREMENT,
    Measure,
    Measurement,
    accuracy,
    accuracy_in,
    band_gain,
    by_scene,
    charge,
    crest_nearer,
    crest_wider,
    error_of,
    false_alerts,
    in_band,
    other_band,
    phone_gain,
    radius_correlation,
    side_known,
    size_gain,
    tn,
    tp,
)
from benchmarks.runs.results import RunData
from benchmarks.scoring import paper_values
from benchmarks.scoring.paper_values import EnergyRow, PaperValue, RatePair

BASELINE = "DistanceOnlyDetector"


@dataclass(frozen=True)
class Claim:
    """One claim of the paper.

    Attributes:
        text, source: what it says and where.
        paper: the printed number in words; empty for an order.
        measure: how it is measured in a run, for a detector.
        value: the printed number, SI; None for an order.
        more: whether more is better.
        suite: which suite measures it.
        baseline: whether it is about section 4.8's baseline instead of the detector asked about.
    """

    text: str
    source: str
    paper: str
    measure: Measure
    value: float | None
    more: bool
    suite: str
    baseline: bool = False


@dataclass(frozen=True)
class ClaimRow:
    """A claim with its measurement and verdict, as text."""

    claim: str
    source: str
    paper: str
    ours: str
    interval: str
    count: str
    verdict: str
    suite: str


def claims() -> list[Claim]:
    """All of them, in the paper's order of sections."""
    return [
        _of("accuracy of collision prediction", PaperValue(0.92, "1", "abstract, section 6", ">"), accuracy, True),
        _order("crest wider when nearer", "section 3.6, Fig. 12", "wider", crest_nearer, "signals, size"),
        _order("crest wider for larger things", "section 3.6, Fig. 10", "wider", crest_wider, "signals, size"),
        Claim(*_RADIUS, "0.93", radius_correlation, paper_values.RADIUS_CORRELATION, True, "size"),
        *_both("both scenes", paper_values.OVERALL, lambda rate: rate, "paper"),
        *(each for s, p in paper_values.BY_SCENE.items() for each in _both(s, p, partial(by_scene, scene=s), "paper")),
        *(each for b, p in paper_values.BY_BAND.items() for each in _both(b, p, partial(in_band, band=b), "bands")),
        _order("16-23 kHz has more true positives", "section 4.3, Fig. 18", "94.3 against 93.7 %", band_gain, "bands"),
        _order("walls do better than people", "section 4.4, Fig. 19", "larger is better", size_gain, "paper"),
        _order("S8+ does better than S5 at the same place", "section 4.5, Fig. 20", "a little better", phone_gain),
        _of("accuracy within 5 m", PaperValue(0.90, "1", "section 4.6", ">"), accuracy_in(5.0), True),
        *(
            _error(f"Distance1 at {range_m:g} m, median", value, "range_m", 0.5, "ranging", range_m)
            for range_m, value in paper_values.DISTANCE1_MEDIAN.items()
        ),
        *(
            _error(f"{name} at {range_m:g} m, P90", replace(value, source=source), column, 0.9, "ranging", range_m)
            for source, range_m in (
                ("section 4.6, Fig. 21", 1.5),
                ("section 4.6, Fig. 22", 3.0),
                ("section 4.6, Fig. 23", 5.0),
            )
            for name, column, value in (
                ("Distance1", "range_m", paper_values.DISTANCE1_P90),
                ("Distance2", "range2_m", paper_values.DISTANCE2_P90),
            )
        ),
        _error("bearing, median", paper_values.BEARING_MEDIAN, "bearing_rad", 0.5, "bearing"),
        _error("bearing, P80", paper_values.BEARING_P80, "bearing_rad", 0.8, "bearing"),
        _error("radius, median", paper_values.RADIUS_MEDIAN, "radius_m", 0.5, "size"),
        _error("radius, P80", paper_values.RADIUS_P80, "radius_m", 0.8, "size"),
        _of("false alerts over all walks", paper_values.FALSE_ALERTS["PaperDetector"], false_alerts, False),
        replace(
            _of("false alerts over all walks, distance only", paper_values.FALSE_ALERTS[BASELINE], false_alerts, False),
            baseline=True,
        ),
        *(_charge(row) for row in paper_values.ENERGY),
        _order("horizontal holding tells left from right", "section 5.1", "possible", side_known, "holding"),
        _order(
            "another band is disturbed less than the same", "section 5.3", "FDMA mitigates", other_band, "interference"
        ),
    ]


def claim_rows(runs: Sequence[RunData], detector: str = "PaperDetector") -> list[ClaimRow]:
    """All claims, each measured in the first of the runs that can.

    Args:
        runs: of any suites.
        detector: whose numbers stand beside the paper's.
    """
    return [_row(claim, runs, detector) for claim in claims()]


def claims_markdown(rows: Sequence[ClaimRow], detector: str = "PaperDetector") -> str:
    """The table as Markdown."""
    lines = [
        f"| claim | source | the paper | {detector} | 95 % interval | n | verdict |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        cells = (row.claim, row.source, row.paper, row.ours, row.interval, row.count, row.verdict)
        lines.append(f"| {' | '.join(cells)} |")
    counts = {word: sum(row.verdict == word for row in rows) for word in ("reached", "inconclusive", "not reached")}
    said = ", ".join(f"{count} {word}" for word, count in counts.items())
    return "\n".join([*lines, "", f"{said}, {len(rows) - sum(counts.values())} not measured here.", ""])


def verdict(claim: Claim, found: Measurement) -> str:
    """ "reached", "not reached", "inconclusive" or "not measured"; see the top of the file."""
    if found.n == 0:
        return "not measured"
    if found.p_value is not None:
        if found.p_value >= 0.05:
            return "inconclusive"
        return "reached" if found.value > 0.0 else "not reached"
    if claim.value is None or not np.isfinite([found.low, found.high]).all():
        return "inconclusive"
    least, most = (found.low, found.high) if claim.more else (-found.high, -found.low)
    asked = claim.value if claim.more else -claim.value
    return "reached" if least >= asked else "not reached" if most < asked else "inconclusive"


def _of(text: str, paper: PaperValue, measure: Measure, more: bool, suite: str = "paper") -> Claim:
    return Claim(text, paper.source, paper.text, measure, paper.value, more, suite)


_RADIUS = ("radius from crest against truth, correlation", "section 3.6, Fig. 11")


def _both(where: str, pair: RatePair, narrowed: Callable[[Measure], Measure], suite: str) -> list[Claim]:
    """TP and TN of one stratum."""
    return [
        _of(f"TP, {where}", pair.true_positive, narrowed(tp), True, suite),
        _of(f"TN, {where}", pair.true_negative, narrowed(tn), True, suite),
    ]


def _error(
    text: str, paper: PaperValue, column: str, quantile: float, suite: str, standing_m: float | None = None
) -> Claim:
    return _of(text, paper, error_of(column, quantile, standing_m), False, suite)


def _charge(row: EnergyRow) -> Claim:
    text, printed = (
        f"charge of 30 minutes, {row.phone} (ours: a model)",
        f"{row.used_mah:.0f} mAh, {100 * row.share:.1f} %",
    )
    return Claim(text, "section 4.9, Table 1 and Fig. 27", printed, charge, row.used_mah, False, "energy")


def _order(text: str, source: str, paper: str, measure: Measure, suite: str = "paper") -> Claim:
    return Claim(text, source, paper, measure, None, True, suite)


def _row(claim: Claim, runs: Sequence[RunData], detector: str) -> ClaimRow:
    found = NO_MEASUREMENT
    for run in runs:
        if found.n == 0:
            found = claim.measure(run, BASELINE if claim.baseline else detector)
    word = verdict(claim, found)
    if word == "not measured":
        return ClaimRow(claim.text, claim.source, claim.paper, "–", "–", f"see suite {claim.suite}", word, claim.suite)
    ends = "–" if found.p_value is None else f"p = {found.p_value:.2g}"
    if np.isfinite([found.low, found.high]).all():
        ends = f"{found.shown(found.low)} to {found.shown(found.high)}"
    ours = found.text or found.shown(found.value)
    return ClaimRow(claim.text, claim.source, claim.paper, ours, ends, found.count, word, claim.suite)
