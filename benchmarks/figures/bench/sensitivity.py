"""What one changed parameter at a time does to alerts and errors (tornado), and left against right."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.figures.bench.parameters import in_words, value_text
from benchmarks.figures.measured import binned_rates, finite_quantile, judged_detectors, sentences
from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import holding_name, same_walks, variant_name, variants
from benchmarks.scoring.scores import (
    absolute_errors,
    approach_table,
    beep_table,
    rate,
    true_negative_rate,
    true_positive_rate,
)
from obstaclewatch.support.arrays import Flags, Floats, Strings

Measure = Callable[[RunData, str], float]
SIDE_BINS_DEG = (0.0, 5.0, 10.0, 20.0, 30.0, 45.0)
LEAST_CHANGE = 1.0
"""In the unit of a panel (cm, degrees, percentage points): changes below it are not drawn at full width."""
Rows = dict[str, list[tuple[Any, RunData]]]


@dataclass(frozen=True)
class Change:
    """What one point of the sweep does: by how much, where it is drawn, whether its value is the highest, in words."""

    by: float
    place: float
    highest: bool
    words: str


def error_tornado(run: RunData) -> PlotFigure:
    """Change of the median range error, the median bearing error, and the share of beeps with an estimate."""
    return _tornado(
        run,
        "tornado",
        "One-at-a-time sensitivity · estimation errors",
        (
            ("range, median error", "cm", _range_error),
            ("bearing, median error", "°", _bearing_error),
            ("beeps with an estimate", "%", _estimates),
        ),
        judged_detectors(run)[:1],
    )


def alert_tornado(run: RunData) -> PlotFigure:
    """Change of TP and TN."""
    measures = (("TP", "%", _tp), ("TN", "%", _tn))
    return _tornado(run, "tornado_alerts", "One-at-a-time sensitivity · TP and TN", measures, judged_detectors(run))


def sides(run: RunData) -> PlotFigure:
    """How often the side of an obstacle is called correctly, by its true bearing (section 5.1: horizontal holding)."""
    panels, said = [], []
    for part in variants(run).values():
        lines = []
        for detector in judged_detectors(part):
            bearing, right, label = side_calls(part, detector)
            lines.append(binned_rates(detector, SIDE_BINS_DEG, bearing, right, walks=label))
            total = rate(right[bearing >= 5.0])
            if total.n:
                said.append(
                    f"{_holding(part)}: {100 * total.value:.0f} % of {total.n} beeps beyond 5° on the right side"
                )
        panels.append(
            Panel(
                _holding(part),
                "true bearing off the heading (°)",
                "right side called (%)",
                tuple(lines),
                (Guide("y", 50.0, "guessing"),),
                x_range=(0.0, 45.0),
                y_range=(0.0, 103.0),
            )
        )
    return PlotFigure(
        "sides",
        "Side of the obstacle called correctly, by true bearing",
        tuple(panels),
        sentences(said),
        "The side is called by which half of the phone the bearing lies in: an estimate below 90° is "
        "towards microphone 1, to the left if held horizontally. Held vertically it says nothing of sides, and the "
        "share is that of targets on the left. Whiskers: 95 % intervals over walks.",
    )


def _tornado(
    run: RunData, name: str, title: str, measures: tuple[tuple[str, str, Measure], ...], detectors: list[str]
) -> PlotFigure:
    parts = variants(run)
    base, rows = parts.get("as it is"), _by_parameter(parts)
    panels: list[Panel] = []
    said: list[str] = []
    if base is not None and rows:
        order = _by_effect(base, rows, measures[0][2], detectors[0])
        for label, unit, measure in measures:
            lines = []
            for k, detector in enumerate(detectors):
                aside = 0.2 * (k - 0.5 * (len(detectors) - 1))
                before = measure(base, detector)
                found = _changes(rows, order, before, aside, measure, detector)
                lines += _change_lines(detector, found)
                if np.isfinite(before) and found:
                    most = max(found, key=lambda change: np.nan_to_num(abs(change.by)))
                    said.append(f"{label}, {detector}: {before:.1f} {unit} as it is, {most.by:+.1f} by {most.words}")
            ticks = tuple(_named(rows, each) for each in order)
            shown = "percentage points" if unit == "%" else unit
            guides = (Guide("x", 0.0, ""),)
            span = _ends(lines)
            words = f"change ({shown})"
            panels.append(
                Panel(label, words, "", tuple(lines), guides, x_range=span, ticks=ticks, flat=True, width_in=2.0)
            )
    note = f"{same_walks(parts)} 0 is the suite as it is; elsewhere one thing is changed."
    missing = " Errors are over the beeps with an estimate: a change that suppresses estimates may look harmless."
    return PlotFigure(
        name,
        title,
        tuple(panels),
        sentences(said),
        note + (missing if name == "tornado" else ""),
        height_in=max(2.7, 0.27 * len(rows) + 0.4),
    )


def _by_parameter(parts: dict[str, RunData]) -> Rows:
    """Values and runs of every parameter that was changed alone, values rising."""
    rows: Rows = {}
    for part in parts.values():
        variant = part.cells[0]["cell"].get("variant") or {}
        if len(variant) == 1:
            ((parameter, value),) = variant.items()
            rows.setdefault(parameter, []).append((value, part))
    for found in rows.values():
        found.sort(key=lambda pair: (str(type(pair[0])), str(pair[0]) if isinstance(pair[0], list) else pair[0]))
    return rows


def _changes(
    rows: Rows, order: list[str], before: float, aside: float, measure: Measure, detector: str
) -> list[Change]:
    return [
        Change(
            measure(part, detector) - before,
            place + aside,
            0 < k == len(rows[name]) - 1,
            f"{in_words(name)} {value_text(name, value)}",
        )
        for place, name in enumerate(order)
        for k, (value, part) in enumerate(rows[name])
    ]


def _change_lines(detector: str, found: list[Change]) -> list[Line]:
    """A bar from 0 to every change, and a point at its end: filled for lower values, hollow for the highest."""
    lines = [Line("", detector, np.array([0.0, one.by]), np.full(2, one.place)) for one in found]
    for highest, label in ((False, "lower or only value"), (True, "highest value")):
        chosen = [one for one in found if one.highest == highest]
        by, place = np.array([one.by for one in chosen]), np.array([one.place for one in chosen])
        lines.append(Line(f"{detector}, {label}", detector, by, place, "ring" if highest else "points"))
    return lines


def _ends(lines: Sequence[Line]) -> tuple[float, float] | None:
    """The axis where nothing changed: hundredths would look like much. None where the data say it."""
    changes = np.concatenate([line.x for line in lines])
    if np.nanmax(np.abs(changes), initial=0.0) >= LEAST_CHANGE:
        return None
    return -1.2 * LEAST_CHANGE, 1.2 * LEAST_CHANGE


def _by_effect(base: RunData, rows: Rows, measure: Measure, detector: str) -> list[str]:
    before = measure(base, detector)

    def effect(name: str) -> float:
        return max(float(np.nan_to_num(abs(measure(part, detector) - before))) for _, part in rows[name])

    return sorted(rows, key=effect, reverse=True)


def _named(rows: Rows, parameter: str) -> str:
    """A parameter and the values that it took: "air, °C: -10, 40"."""
    return f"{in_words(parameter)}: {', '.join(value_text(parameter, value) for value, _ in rows[parameter])}"


def side_calls(run: RunData, detector: str) -> tuple[Floats, Flags, Strings]:
    """Of beeps with a bearing: the true one off the heading, degrees, whether its side was called rightly, the walk."""
    tables = [beep_table(run, detector, kind) for kind in ("approach", "standing")]
    signed, found, label = (
        np.concatenate([table.get(column, np.zeros(0)) for table in tables])
        for column in ("true_signed_bearing_rad", "bearing_rad", "label")
    )
    kept = np.isfinite(signed) & np.isfinite(found) & (np.abs(signed) > 0.0)
    return np.rad2deg(np.abs(signed[kept])), (found[kept] < 0.5 * np.pi) == (signed[kept] > 0.0), label[kept]


def _holding(run: RunData) -> str:
    cell = run.cells[0]["cell"]
    variant = cell.get("variant") or {}
    return holding_name(cell) if "walk.holding" in variant else variant_name(variant)


def _range_error(run: RunData, detector: str) -> float:
    return 100.0 * _median(run, detector, "range_m", "true_range_m")


def _bearing_error(run: RunData, detector: str) -> float:
    return float(np.rad2deg(_median(run, detector, "bearing_rad", "true_bearing_rad")))


def _median(run: RunData, detector: str, column: str, truth: str) -> float:
    return finite_quantile(absolute_errors(beep_table(run, detector, "approach"), column, truth), 0.5)


def _estimates(run: RunData, detector: str) -> float:
    found = beep_table(run, detector, "approach")["range_m"]
    return 100.0 * float(np.isfinite(found).mean()) if len(found) else np.nan


def _tp(run: RunData, detector: str) -> float:
    return 100.0 * true_positive_rate(approach_table(run, detector)).value


def _tn(run: RunData, detector: str) -> float:
    return 100.0 * true_negative_rate(approach_table(run, detector)).value
