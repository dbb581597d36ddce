"""Every claim of the paper that the bench can test, beside what was measured, with exact intervals and a verdict.

Rates carry the exact interval of Clopper and Pearson (1934), medians and percentiles a bootstrap over walks. A
claim is "reached" where all of the 95 % interval is at least as good as the paper says, "not reached" where all of it
is worse, and "open" in between; the paper's "about" and "around" are taken as the number they precede. Claims of an
order ("larger is better") are decided at 5 %, by Fisher's exact test or by rank correlation; tests over beeps take them
as independent, which flatters them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
from benchmarks.scoring.paper_values import PaperValue

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
    found = [
        _of("accuracy of collision prediction", PaperValue(0.92, "1", "abstract, section 6", ">"), accuracy, True),
        _order("crest wider when nearer", "section 3.6, Fig. 12", "wider", crest_nearer, "signals, size"),
        _order("crest wider for larger things", "section 3.6, Fig. 10", "wider", crest_wider, "signals, size"),
        Claim(
            "radius from crest against truth, correlation",
            "section 3.6, Fig. 11",
            "0.93",
            radius_correlation,
            paper_values.RADIUS_CORRELATION,
            True,
            "size",
        ),
        _of("TP, both scenes", paper_values.OVERALL.true_positive, tp, True),
        _of("TN, both scenes", paper_values.OVERALL.true_negative, tn, True),
    ]
    for scene, pair in paper_values.BY_SCENE.items():
        found.append(_of(f"TP, {scene}", pair.true_positive, by_scene(tp, scene), True))
        found.append(_of(f"TN, {scene}", pair.true_negative, by_scene(tn, scene), True))
    for band, pair in paper_values.BY_BAND.items():
        found.append(_of(f"TP, {band}", pair.true_positive, in_band(tp, band), True, "bands"))
        found.append(_of(f"TN, {band}", pair.true_negative, in_band(tn, band), True, "bands"))
    found += [
        _order("16-23 kHz has more true positives", "section 4.3, Fig. 18", "94.3 against 93.7 %", band_gain, "bands"),
        _order("walls do better than people", "section 4.4, Fig. 19", "larger is better", size_gain, "paper"),
        _order(
            "S8+ does better than S5 at the same place", "section 4.5, Fig. 20", "a little better", phone_gain, "paper"
        ),
        _of("accuracy within 5 m", PaperValue(0.90, "1", "section 4.6", ">"), accuracy_in(5.0), True),
    ]
    for range_m, value in paper_values.DISTANCE1_MEDIAN.items():
        found.append(
            _of(f"Distance1 at {range_m:g} m, median", value, error_of("range_m", 0.5, range_m), False, "ranging")
        )
    for range_m in (1.5, 3.0, 5.0):
        found.append(
            _of(
                f"Distance1 at {range_m:g} m, P90",
                paper_values.DISTANCE1_P90,
                error_of("range_m", 0.9, range_m),
                False,
                "ranging",
            )
        )
        found.append(
            _of(
                f"Distance2 at {range_m:g} m, P90",
                paper_values.DISTANCE2_P90,
                error_of("range2_m", 0.9, range_m),
                False,
                "ranging",
            )
        )
    found += [
        _of("bearing, median", paper_values.BEARING_MEDIAN, error_of("bearing_rad", 0.5), False, "bearing"),
        _of("bearing, P80", paper_values.BEARING_P80, error_of("bearing_rad", 0.8), False, "bearing"),
        _of("radius, median", paper_values.RADIUS_MEDIAN, error_of("radius_m", 0.5), False, "size"),
        _of("radius, P80", paper_values.RADIUS_P80, error_of("radius_m", 0.8), False, "size"),
        _of("false alerts over all walks", paper_values.FALSE_ALERTS["PaperDetector"], false_alerts, False),
        replace(
            _of("false alerts over all walks, distance only", paper_values.FALSE_ALERTS[BASELINE], false_alerts, False),
            baseline=True,
        ),
    ]
    for row in paper_values.ENERGY:
        printed = f"{row.used_mah:.0f} mAh, {100 * row.share:.1f} %"
        found.append(
            Claim(
                f"charge of 30 minutes, {row.phone} (ours: a model)",
                "section 4.9, Table 1",
                printed,
                charge,
                row.used_mah,
                False,
                "energy",
            )
        )
    return [
        *found,
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
    counts = {word: sum(row.verdict == word for row in rows) for word in ("reached", "open", "not reached")}
    said = ", ".join(f"{count} {word}" for word, count in counts.items())
    return "\n".join([*lines, "", f"{said}, {len(rows) - sum(counts.values())} not measured here.", ""])


def verdict(claim: Claim, found: Measurement) -> str:
    """ "reached", "not reached", "open" or "not measured"; see the top of the file."""
    if found.n == 0:
        return "not measured"
    if found.p_value is not None:
        if found.p_value >= 0.05:
            return "open"
        return "reached" if found.value > 0.0 else "not reached"
    if claim.value is None or not np.isfinite([found.low, found.high]).all():
        return "open"
    least, most = (found.low, found.high) if claim.more else (-found.high, -found.low)
    asked = claim.value if claim.more else -claim.value
    return "reached" if least >= asked else "not reached" if most < asked else "open"


def _of(text: str, paper: PaperValue, measure: Measure, more: bool, suite: str = "paper") -> Claim:
    return Claim(text, paper.source, paper.text, measure, paper.value, more, suite)


def _order(text: str, source: str, paper: str, measure: Measure, suite: str) -> Claim:
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
    return ClaimRow(
        claim.text,
        claim.source,
        claim.paper,
        found.text or found.shown(found.value),
        ends,
        found.count,
        word,
        claim.suite,
    )
