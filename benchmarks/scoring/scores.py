"""From a run's cells to tables and rates: pure functions over columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks.cells.association import BEEP_COLUMNS
from benchmarks.cells.spec import counts_as
from benchmarks.runs.results import RunData
from benchmarks.scoring.operating_points import TRUE_NEGATIVE_RATES, OperatingPoint, operating_point
from benchmarks.scoring.statistics import Rate, exact_rate, quantile_with_interval
from obstaclewatch.support.arrays import Flags, Floats

Table = dict[str, NDArray[Any]]

_CELL = ("scene", "category", "phone", "index", "seed")
_TRUTH = (
    "collides", "line_collides", "miss_distance_m", "duration_s", "contact_time_s", "overlap_m", "clearance_m",
    "detection_index_db", "moving",
)  # fmt: skip
_ALERT = ("alert", "alert_distance_m", "alert_range_m", "alert_lead_s", "alert_time_s")
_WORDS = ("label", *_CELL[:3])
_FLAGS = ("collides", "line_collides", "alert", "true_alert", "low", "moving")

LEFT_M = (1.0, 0.5, 0.0)
"""Distances, as walked, that must be left to contact at the first alert; 0 is before contact, which is all that the
paper asks (section 3.6). An alert that comes earlier than its danger distance of 3 m lasts until then. They are counted
where the beep leaves the speaker that the alert is decided by. Its echoes are in a period later, 12 cm at 1.3 m/s."""
PAPER_RECIPE = "paper"
"""The recipe of the walks that the paper's rates are about."""
NARROW_M = 0.5
"""Radius up to which targets are like those of the paper's Figure 11: people, signs, dustbins."""


def left_in_words(left_m: float) -> str:
    """What an alert must leave.

    >>> [left_in_words(left_m) for left_m in LEFT_M]
    ['1 m left', '0.5 m left', 'before contact']
    """
    return f"{left_m:g} m left" if left_m else "before contact"


def approach_table(run: RunData, detector: str) -> Table:
    """One row per walk that did not fail.

    Columns: label, scene, category, phone, index, seed, collides, line_collides, miss_distance_m, duration_s,
    contact_time_s, overlap_m (NaN without a collision), clearance_m, detection_index_db, moving, alert,
    alert_distance_m (walked from alert to contact), alert_range_m, alert_lead_s, true_alert (a collision's, before
    contact), and "score_1m", "score_0.5m", "score_0m": the greatest probability of a collision that the detector stated
    with so much left, of walks without a collision at any time; NaN if it states none.
    """
    rows = [
        {"label": record["label"]} | {name: record["cell"][name] for name in _CELL} | walk_row(record, detector)
        for record in run.ok
        if counts_as(record["cell"], "approach") and detector in record["result"]["detectors"]
    ]
    names = ("label", *_CELL, *_TRUTH, *_ALERT, "true_alert", *map(score_column, LEFT_M))
    return {name: _column(name, [row[name] for row in rows]) for name in names}


def walk_row(record: Mapping[str, Any], detector: str) -> dict[str, Any]:
    """What `approach_table` says of one walk and of a detector on it, beside "outcome" and "radius_m" of the target."""
    entry, truth = record["result"]["detectors"][detector], record["result"]["truth"]
    return (
        {name: truth[name] for name in (*_TRUTH, "radius_m")}
        | {name: entry[name] for name in (*_ALERT, "outcome")}
        | {"true_alert": entry["outcome"] == "TP"}
        | {score_column(left_m): _score(entry["decisions"], truth["collides"], left_m) for left_m in LEFT_M}
    )


def beep_table(run: RunData, detector: str, kind: str) -> Table:
    """One row per beep and target of all cells of a kind ("approach" or "standing").

    Columns: label, scene, category, phone, standing_range_m, and those of `benchmarks.cells.compute`; NaN is no
    estimate. Of standing measurements also echo_range_m and echo_range2_m, a diagnostic and no truth: which of the
    target's loud echoes is nearest to range_m and to range2_m; NaN without one, as in runs that do not tell them.
    """
    columns: dict[str, list[Any]] = {}
    for record in run.ok:
        cell = record["cell"]
        if not counts_as(cell, kind) or detector not in record["result"]["detectors"]:
            continue
        for beeps in beeps_of(record, detector):
            count = len(beeps["beep"])
            shared = {name: cell[name] for name in _CELL[:3]}
            shared |= {"label": record["label"], "standing_range_m": cell["range_m"]}
            for name, value in shared.items():
                columns.setdefault(name, []).extend([value] * count)
            for name, values in beeps.items():
                columns.setdefault(name, []).extend(values)
    if not columns:
        echoes = ECHOES if kind == "standing" else {}
        columns = {name: [] for name in ("label", *_CELL[:3], "standing_range_m", *BEEP_COLUMNS, *echoes)}
    return {name: _column(name, values) for name, values in columns.items()}


def beeps_of(record: Mapping[str, Any], detector: str) -> list[dict[str, list[Any]]]:
    """The columns over beeps of a cell, of each of its targets; of standing measurements with `ECHOES`."""
    tables = record["result"]["detectors"][detector]["beeps"]
    return [beeps | _nearest_echoes(record["result"], beeps, record["cell"]["kind"]) for beeps in tables]


ECHOES = {"echo_range_m": "range_m", "echo_range2_m": "range2_m"}
"""Columns of the nearest loud echo at microphone 0 and 1, and of the estimates that they are nearest to."""


def nearest_echo(estimate_m: ArrayLike, echoes_m: ArrayLike) -> Floats:
    """(T,) which of (E,) echoes is nearest to each of (T,) estimates; NaN without an estimate or an echo."""
    estimate, echoes = np.asarray(estimate_m, dtype=np.float64), np.asarray(echoes_m, dtype=np.float64)
    if echoes.size == 0:
        return np.full(estimate.shape, np.nan)
    nearest = echoes[np.argmin(np.abs(echoes - estimate[:, None]), axis=1)]
    return np.where(np.isnan(estimate), np.nan, nearest)


def rate(successes: ArrayLike) -> Rate:
    """Share of true entries with its exact 95 % interval."""
    outcome = np.asarray(successes, dtype=bool)
    return exact_rate(int(outcome.sum()), len(outcome))


def recipe_of(run: RunData) -> str:
    """The recipe of the run's walks; "own scenes", or "several" joined by a plus; empty without walks."""
    cells = [c["cell"] for c in run.cells if counts_as(c["cell"], "approach")]
    return " + ".join(sorted({cell["approach"].get("recipe", "own scenes") for cell in cells}))


def in_time(table: Table, left_m: float = 0.0) -> Flags:
    """(n,) whether the first alert came before contact, with at least so much left."""
    return table["true_alert"] & (table["alert_distance_m"] >= left_m)


def true_positive_rate(table: Table, left_m: float = 0.0) -> Rate:
    """Collisions with an alert before contact, with at least so much left, over all collisions (paper section 4.1)."""
    return rate(in_time(table, left_m)[table["collides"]])


def true_negative_rate(table: Table) -> Rate:
    """Walks without a collision that raise no alert, over all of them (paper section 4.1)."""
    return rate(~table["alert"][~table["collides"]])


def false_alerts_over_negatives(table: Table) -> Rate:
    """Alerts among the walks without a collision: 1 - TN."""
    return rate(table["alert"][~table["collides"]])


def false_alerts_over_all(table: Table) -> Rate:
    """Alerts on walks without a collision, over all walks: the paper's Figure 26 counts so."""
    return rate(table["alert"] & ~table["collides"])


def swept(table: Table, left_m: float, true_negative_rate: float) -> OperatingPoint | None:
    """TP and TN with the threshold on the stated probability at which TN is so high; None if none is stated."""
    score, collides = stated_scores(table, left_m), table["collides"]
    return operating_point(score[collides], score[~collides], true_negative_rate)


def stated_scores(table: Table, left_m: float) -> Floats:
    """Highest probability stated on each walk with so much left, 0 where no beep was found; all NaN if none is."""
    score = table[score_column(left_m)]
    return np.nan_to_num(score) if np.isfinite(score).any() else score


def score_column(left_m: float) -> str:
    """Name of the column of scores with so much left."""
    return f"score_{left_m:g}m"


def _score(decisions: Mapping[str, Any], collides: bool, left_m: float) -> float:
    if not decisions["probability"]:
        return np.nan
    stated = zip(decisions["probability"], decisions["left_m"], strict=True)
    return max((p for p, left in stated if not collides or left >= left_m), default=0.0)


def rows_where(table: Table, **values: str | float | None) -> Table:
    """The rows whose columns have these values; None leaves them free."""
    mask = np.ones(len(table["label"]), dtype=bool)
    for column, value in values.items():
        if value is not None:
            mask &= table[column] == value
    return chosen(table, mask)


def chosen(table: Table, mask: Flags) -> Table:
    """The rows of a mask."""
    return {name: values[mask] for name, values in table.items()}


def absolute_errors(table: Table, estimate: str, truth: str) -> Floats:
    """(n,) |estimate - truth|, NaN without an estimate."""
    return np.abs(table[estimate] - table[truth])


def summary(run: RunData, points: Mapping[str, RunData]) -> dict[str, Any]:
    """The verdict of a run, per detector: rates with intervals, and median errors while walking and standing.

    Args:
        run: all of it.
        points: its parts by the point of the sweep; see `benchmarks.runs.variants.variants`.

    Returns:
        "cells", "failed", and "detectors"; of a sweep, whose points are the same walks over again and must not be
        pooled, "points" with the detectors of each instead.
    """
    counts = {"cells": len(run.cells), "failed": len(run.cells) - len(run.ok)}
    if len(points) < 2:
        return counts | {"detectors": _verdicts(run)}
    return counts | {"points": {name: _verdicts(part) for name, part in points.items()}}


def _verdicts(run: RunData) -> dict[str, Any]:
    detectors = sorted({name for record in run.ok for name in record["result"]["detectors"]})
    return {name: _verdict(run, name) for name in detectors}


def _verdict(run: RunData, detector: str) -> dict[str, Any]:
    walks, beeps = approach_table(run, detector), beep_table(run, detector, "approach")
    still = beep_table(run, detector, "standing")
    return {
        "tp": {f"{left_m:g}": _rate_entry(true_positive_rate(walks, left_m)) for left_m in LEFT_M},
        "tn": _rate_entry(true_negative_rate(walks)),
        "false_alerts_over_negatives": _rate_entry(false_alerts_over_negatives(walks)),
        "false_alerts_over_all": _rate_entry(false_alerts_over_all(walks)),
        "swept": {f"{left_m:g}": _swept_entries(walks, left_m) for left_m in LEFT_M},
        "walking": _errors(beeps),
        "standing": _errors(still),
        "standing_against_echoes": _errors(still, {name: (name, echo) for echo, name in ECHOES.items()}),
    }


TRUE = {name: (name, f"true_{name}") for name in ("range_m", "range2_m", "bearing_rad", "radius_m")}


def _errors(table: Table, pairs: Mapping[str, tuple[str, str]] = TRUE) -> dict[str, Any]:
    """Median absolute errors by name, of pairs of estimate and what it is held against."""
    entries = {}
    for name, (estimate, truth) in pairs.items():
        rows = judged(table, estimate)
        value, low, high, count = quantile_with_interval(absolute_errors(rows, estimate, truth), 0.5, rows["label"])
        entries[name] = {"median": value, "low": low, "high": high, "n": count, "of": len(rows[truth])}
    return entries


def judged(table: Table, estimate: str) -> Table:
    """The beeps of which an estimate is judged: of a radius those of narrow targets, of all else every one.

    >>> judged({"true_radius_m": np.array([0.3, 2.0]), "radius_m": np.array([0.4, 0.5])}, "radius_m")["radius_m"]
    array([0.4])
    """
    return chosen(table, is_narrow(table)) if estimate == "radius_m" else table


def is_narrow(table: Table) -> Flags:
    """(n,) whether the target of a beep is up to `NARROW_M` in radius."""
    narrow: Flags = table["true_radius_m"] <= NARROW_M
    return narrow


def _nearest_echoes(result: Mapping[str, Any], beeps: Mapping[str, Any], kind: str) -> dict[str, list[float]]:
    """The columns `ECHOES` of a cell's beeps; none of walks."""
    if kind != "standing":
        return {}
    told = result.get("loud_echoes_m", [[], []])
    return {
        name: nearest_echo(beeps[estimate], echoes).tolist()
        for (name, estimate), echoes in zip(ECHOES.items(), told, strict=True)
    }


def _swept_entries(walks: Table, left_m: float) -> dict[str, Any]:
    found = {f"{100 * tnr:g}": swept(walks, left_m, tnr) for tnr in TRUE_NEGATIVE_RATES}
    return {tnr: _rate_entry(point.true_positive) for tnr, point in found.items() if point is not None}


def _rate_entry(found: Rate) -> dict[str, Any]:
    return {"k": found.k, "n": found.n, "value": found.value, "low": found.low, "high": found.high}


def _column(name: str, values: list[Any]) -> NDArray[Any]:
    if name in _WORDS:
        return np.array(values, dtype=np.str_)
    if name in _FLAGS:
        return np.array(values, dtype=bool)
    if name in ("index", "seed", "beep", "candidates"):
        return np.array(values, dtype=np.int64)
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
