"""The verdict of a report: every headline number of every detector with n and interval, beside the paper's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.cells.spec import counts_as
from benchmarks.figures.measured import (
    BASELINE,
    NO_DATA,
    against_paper,
    detectors_of,
    judged_detectors,
    significant,
)
from benchmarks.report.verdict_lines import left_in_words
from benchmarks.runs.results import RunData
from benchmarks.scoring import paper_values
from benchmarks.scoring.operating_points import TRUE_NEGATIVE_RATES
from benchmarks.scoring.paper_values import SHOWN, PaperValue
from benchmarks.scoring.scores import (
    LEFT_M,
    NARROW_M,
    PAPER_RECIPE,
    Table,
    approach_table,
    beep_table,
    chosen,
    false_alerts_over_all,
    false_alerts_over_negatives,
    judged,
    recipe_of,
    rows_where,
    swept,
    true_negative_rate,
    true_positive_rate,
)
from benchmarks.scoring.statistics import Rate, quantile_with_interval
from obstaclewatch.support.arrays import Floats


@dataclass(frozen=True)
class Measured:
    """One number of one detector.

    Attributes:
        text: value with unit; "no data" without any.
        interval: its 95 % interval, or empty.
        count: observations behind it.
        against: "better", "worse" or "inconclusive" (the interval holds the paper's value, so that it decides nothing);
            empty where the paper has none.
    """

    text: str
    interval: str = ""
    count: str = ""
    against: str = ""


@dataclass(frozen=True)
class Row:
    """One quantity: what it is, what the paper prints, and one measurement per detector (None: not judged)."""

    group: str
    label: str
    paper: str
    source: str
    cells: tuple[Measured | None, ...]


@dataclass(frozen=True)
class Tables:
    """All tables of one detector."""

    walks: Table
    walking: Table
    standing: Table


Quantity = Callable[[Tables, PaperValue | None], Measured]


def verdict_rows(run: RunData) -> list[Row]:
    """All rows of what the run holds, one column a detector of the suite: none of alerts and walking errors without
    walks, none of standing errors without standing phones. Errors of the baseline, which measures as the paper's
    detector does, are left out.
    """
    names = detectors_of(run)
    judged = judged_detectors(run)
    tables = {name: _tables(run, name) for name in names}
    comparable = recipe_of(run) == PAPER_RECIPE
    rows = [_rate_row(tables, names, comparable, *spec) for spec in _RATES]
    rows += [_swept_row(tables, names, left_m, tnr) for left_m in sorted(LEFT_M) for tnr in TRUE_NEGATIVE_RATES]
    for group, label, quantity, paper in _quantities(_standing_ranges(run)):
        asked = names if group == "Alerts" else judged
        cells = tuple(quantity(tables[name], paper) if name in asked else None for name in names)
        rows.append(Row(group, label, *_printed(paper), cells))
    held = _groups(run)
    echoing = any("loud_echoes_m" in record["result"] for record in run.ok)
    return [row for row in rows if row.group in held and (echoing or row.label not in AGAINST_ECHOES)]


def _groups(run: RunData) -> set[str]:
    """Groups of rows that the run's cells can fill, whether or not a detector found anything."""
    walked = any(counts_as(cell["cell"], "approach") for cell in run.cells)
    stood = any(counts_as(cell["cell"], "standing") for cell in run.cells)
    return ({"Alerts", "Thresholds", "Walking"} if walked else set()) | ({"Standing"} if stood else set())


def headline(rows: Sequence[Row], names: Sequence[str]) -> list[str]:
    """One sentence a detector: from its alerts, without walks from its standing errors, and none without either."""
    found = {row.label: row.cells for row in rows}
    for sentence, labels in ((_alert_sentence, ALERTS), (_standing_sentence, STANDING)):
        if set(labels) <= set(found):
            return [sentence(name, *(_said(found[label][k]) for label in labels)) for k, name in enumerate(names)]
    return []


def _alert_sentence(name: str, tp: str, at_half_m: str, at_1m: str, tn: str) -> str:
    return f"{name}: TP {tp} before contact, {at_half_m} with 0.5 m left, {at_1m} with 1 m left; TN {tn}."


def _standing_sentence(name: str, first: str, second: str) -> str:
    return f"{name}, standing, has nine of ten errors of Distance1 within {first}, of Distance2 within {second}."


def rate_measured(found: Rate, paper: PaperValue | None = None, higher_is_better: bool = True) -> Measured:
    """A rate in percent."""
    if found.n == 0:
        return Measured(NO_DATA)
    word = "" if paper is None else against_paper(found.value, found.low, found.high, paper, higher_is_better)
    interval = f"{100.0 * found.low:.1f}–{100.0 * found.high:.1f} %"
    return Measured(f"{100.0 * found.value:.1f} %", interval, f"{found.k} of {found.n}", word)


_OVERALL, _FALSE = paper_values.OVERALL, paper_values.FALSE_ALERTS
_RATES: tuple[tuple[str, Callable[[Table], Rate], PaperValue | None, PaperValue | None, bool], ...] = (
    ("TP: collisions with an alert before contact", true_positive_rate, _OVERALL.true_positive, None, True),
    *(
        (f"TP, {left_in_words(left_m)}", partial(true_positive_rate, left_m=left_m), None, None, True)
        for left_m in sorted(LEFT_M) if left_m
    ),
    ("TN: other walks without an alert", true_negative_rate, _OVERALL.true_negative, None, True),
    ("false alerts over all walks", false_alerts_over_all, _FALSE["PaperDetector"], _FALSE[BASELINE], False),
    ("false alerts over walks without a collision", false_alerts_over_negatives, None, None, False),
)  # fmt: skip
"""Label, score, the paper's value for its detector and for its baseline, whether more is better."""

ALERTS = tuple(label for label, *_ in _RATES[:-2])
STANDING = ("Distance1, P90", "Distance2, P90")
"""Rows that a headline is made of."""


def _rate_row(
    tables: dict[str, Tables],
    names: Sequence[str],
    comparable: bool,
    label: str,
    score: Callable[[Table], Rate],
    paper: PaperValue | None,
    baseline: PaperValue | None,
    higher_is_better: bool,
) -> Row:
    if not comparable:
        paper = baseline = None
    known = {name: baseline if name == BASELINE else paper for name in names}
    cells = tuple(rate_measured(score(tables[name].walks), known[name], higher_is_better) for name in names)
    printed, source = _printed(paper)
    both = f"{printed}; distance only {baseline.text}" if baseline is not None and BASELINE in names else printed
    return Row("Alerts", label, both, source, cells)


def _swept_row(tables: dict[str, Tables], names: Sequence[str], left_m: float, tnr: float) -> Row:
    """TP with each detector's threshold where so many other walks stay quiet; none where it states no probability."""
    points = [swept(tables[name].walks, left_m, tnr) for name in names]
    cells = tuple(None if point is None else rate_measured(point.true_positive) for point in points)
    return Row("Thresholds", f"TP at TN {100 * tnr:g} %, {left_in_words(left_m)}", "–", "", cells)


def _quantities(standing_m: Sequence[float]) -> list[tuple[str, str, Quantity, PaperValue | None]]:
    """Group, label, how it is measured, and the paper's value."""
    at_alert = "to contact at the alert, collisions"
    standing: list[tuple[str, str, Quantity, PaperValue | None]] = [
        (
            "Standing",
            f"Distance1, median at {range_m:g} m",
            partial(_standing_error, column="range_m", quantile=0.5, range_m=range_m),
            paper_values.DISTANCE1_MEDIAN.get(range_m),
        )
        for range_m in standing_m
    ]
    error = partial(partial, _error)
    return [
        ("Alerts", f"median distance {at_alert}", partial(_of_alerts, column="alert_distance_m", unit=" m"), None),
        ("Alerts", f"median time {at_alert}", partial(_of_alerts, column="alert_lead_s", unit=" s"), None),
        *standing,
        ("Standing", STANDING[0], error("standing", "range_m", "m", 0.9), paper_values.DISTANCE1_P90),
        ("Standing", STANDING[1], error("standing", "range2_m", "m", 0.9), paper_values.DISTANCE2_P90),
        *_AGAINST_ECHOES,
        ("Walking", "distance, median", error("walking", "range_m", "m", 0.5), None),
        ("Walking", "distance, median with its sign", error("walking", "range_m", "m", 0.5, signed=True), None),
        ("Walking", "bearing, median", error("walking", "bearing_rad", "rad", 0.5), paper_values.BEARING_MEDIAN),
        ("Walking", "bearing, P80", error("walking", "bearing_rad", "rad", 0.8), paper_values.BEARING_P80),
        ("Walking", _NARROW + ", median", error("walking", "radius_m", "m", 0.5), paper_values.RADIUS_MEDIAN),
        ("Walking", _NARROW + ", P80", error("walking", "radius_m", "m", 0.8), paper_values.RADIUS_P80),
    ]


def _error_to_echo(tables: Tables, paper: PaperValue | None, column: str, quantile: float) -> Measured:
    table = tables.standing
    return _quantile(np.abs(table[column] - table[f"echo_{column}"]), quantile, table["label"], *SHOWN["m"], paper)


_AGAINST_ECHOES: tuple[tuple[str, str, Quantity, None], ...] = tuple(
    (
        "Standing",
        f"{label} against the nearest loud echo, {said} (diagnostic)",
        partial(_error_to_echo, column=column, quantile=quantile),
        None,
    )
    for column, label in (("range_m", "Distance1"), ("range2_m", "Distance2"))
    for said, quantile in (("median", 0.5), ("P90", 0.9))
)
"""Not compared with the paper, whose errors are to the obstacle."""
AGAINST_ECHOES = tuple(label for _, label, *_ in _AGAINST_ECHOES)

_NARROW = f"radius of targets up to {2 * NARROW_M:g} m wide"


def _error(
    state: str, column: str, unit: str, quantile: float, tables: Tables, paper: PaperValue | None, signed: bool = False
) -> Measured:
    table = judged(getattr(tables, state), column)
    error = table[column] - table[f"true_{column}"]
    return _quantile(error if signed else np.abs(error), quantile, table["label"], *SHOWN[unit], paper)


def _standing_error(tables: Tables, paper: PaperValue | None, column: str, quantile: float, range_m: float) -> Measured:
    there = Tables(tables.walks, tables.walking, rows_where(tables.standing, standing_range_m=range_m))
    return _error("standing", column, "m", quantile, there, paper)


def _of_alerts(tables: Tables, paper: PaperValue | None, column: str, unit: str) -> Measured:
    """Over the collisions with an alert, of all collisions."""
    collisions = chosen(tables.walks, tables.walks["collides"])
    if collisions["alert"].size and not collisions["alert"].any():
        return Measured("no alert", "", f"0 of {len(collisions['alert'])}")
    return _quantile(collisions[column], 0.5, collisions["label"], 1.0, unit, paper)


def _quantile(
    values: Floats, quantile: float, walks: NDArray[Any], scale: float, unit: str, paper: PaperValue | None
) -> Measured:
    value, low, high, count = quantile_with_interval(values, quantile, walks)
    of = f"{count} of {len(values)}"
    if count == 0:
        return Measured("no estimate" if len(values) else NO_DATA, "", of)
    word = "" if paper is None else against_paper(value, low, high, paper, higher_is_better=False)
    interval = f"{significant(scale * low)} to {significant(scale * high)}{unit}" if np.isfinite(low) else ""
    return Measured(f"{significant(scale * value)}{unit}", interval, of, word)


def _tables(run: RunData, name: str) -> Tables:
    return Tables(approach_table(run, name), beep_table(run, name, "approach"), beep_table(run, name, "standing"))


def _standing_ranges(run: RunData) -> list[float]:
    """Distances of the standing measurements; the paper's where the run has none."""
    found = {float(c["cell"]["range_m"]) for c in run.cells if c["cell"]["kind"] == "standing"}
    return sorted(found) or [1.5, 3.0, 5.0]


def _printed(paper: PaperValue | None) -> tuple[str, str]:
    return ("–", "") if paper is None else (paper.text, paper.source)


def _said(measured: Measured | None) -> str:
    if measured is None:
        return NO_DATA
    return f"{measured.text} ({measured.interval.removesuffix(' %')})" if measured.interval else measured.text
