"""What changes from one point of a sweep to the next (Figure 18 and its like)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.cells.spec import counts_as
from benchmarks.figures.bench.parameters import in_words, scale_of, value_text
from benchmarks.figures.data import BarFigure, BarPanel
from benchmarks.figures.measured import (
    INTERVALS,
    TOP,
    judged_detectors,
    percents,
    rate_against,
    rate_pair,
    rate_text,
)
from benchmarks.figures.paper.rates import held_against
from benchmarks.figures.plots import Line, Panel, PlotFigure
from benchmarks.plan.sweep import NAME
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import band_name, holding_name, same_walks, variants
from benchmarks.scoring import paper_values
from benchmarks.scoring.paper_values import RatePair
from benchmarks.scoring.scores import (
    absolute_errors,
    approach_table,
    beep_table,
    true_negative_rate,
    true_positive_rate,
)
from benchmarks.scoring.statistics import Rate, quantile_with_interval
from obstaclewatch.support.arrays import Floats

Measured = tuple[float, float, float]
"""A value and the ends of its interval."""


def rates_by_band(run: RunData) -> BarFigure:
    """Figure 18: the band of the beep; the paper's values where the bands are the paper's."""
    note = f"{INTERVALS} {same_walks(variants(run))} The paper's two figures for one place, 17 and 18, differ by 1.5 "
    note += "points: noise."
    known = held_against(run, paper_values.BY_BAND)
    return _rates_figure(run, "fig18", "Fig. 18 · TP and TN by band of the beep", known, note, band_name)


def rates_by_holding(run: RunData) -> BarFigure:
    """Section 5.1: the phone held vertically and horizontally."""
    note = f"{INTERVALS} {same_walks(variants(run))} Held horizontally, the bearing is the angle to the phone's long "
    note += "edge, which now points to the left: so Eq. 2 gives about 90° for an obstacle straight ahead."
    return _rates_figure(run, "holding", "Section 5.1 · TP and TN by holding of the phone", {}, note, holding_name)


def rates_by_interference(run: RunData) -> PlotFigure:
    """Section 5.3: a second phone nearby."""
    note = "The second phone stands 29° to the left of the walk's start and sends as loudly as ours."
    return _sweep_figure(run, "interference", "Section 5.3 · {} with a second phone nearby", note)


def sweep_curves(run: RunData) -> PlotFigure:
    """TP, TN and the median range error of every point of a sweep, in its order; of standing phones alone, errors."""
    return _sweep_figure(run, "sweep", "{} at the points of the sweep", "")


def _sweep_figure(run: RunData, name: str, title: str, note: str) -> PlotFigure:
    points = variants(run) if any(record["cell"].get("variant") for record in run.cells) else {}
    kind = "approach" if any(counts_as(record["cell"], "approach") for record in run.cells) else "standing"
    points = {point: part for point, part in points.items() if any(counts_as(c["cell"], kind) for c in part.cells)}
    axis, detectors = swept_axis(points), judged_detectors(run)
    names = [_in_words(point, part.cells[0]["cell"].get("variant") or {}) for point, part in points.items()]
    panels: list[Panel] = []
    said: dict[str, list[str]] = {detector: [] for detector in detectors}
    for label, unit, measure in _MEASURES[kind]:
        found = {d: np.array([measure(part, d) for part in points.values()]).reshape(-1, 3) for d in detectors}
        for detector, values in found.items():
            if np.isfinite(values[:, 0]).any():
                ends = f"{np.nanmin(values[:, 0]):.1f} to {np.nanmax(values[:, 0]):.1f}"
                said[detector].append(f"{label.split(',')[0]} {ends} {unit}")
        span = (-3.0, 103.0) if unit == "%" else None
        if axis is None:
            panels.append(_named_points(label, found, names, span))
        else:
            panels.append(_numeric_points(label, found, *axis, span))
    return PlotFigure(
        name,
        title.format(_MEASURED[kind]),
        tuple(panels),
        " ".join(f"{name}: {', '.join(words)}." for name, words in said.items() if words) or "No data.",
        f"{_WHISKERS[kind]} {note}",
        height_in=2.7 if axis else max(2.4, 0.32 * len(points) + 0.4),
    )


def swept_axis(points: Mapping[str, RunData]) -> tuple[str, Floats] | None:
    """The one parameter of a sweep and its values in the unit of its words; None unless it is one, and numeric."""
    swept = [part.cells[0]["cell"].get("variant") or {} for part in points.values()]
    parameters = {name for point in swept for name in point}
    if len(parameters) != 1 or len(swept) < 2:
        return None
    (parameter,) = parameters
    values = [point.get(parameter) for point in swept]
    if any(isinstance(value, bool) or not isinstance(value, int | float) for value in values):
        return None
    return parameter, scale_of(parameter) * np.array(values, dtype=np.float64)


def _numeric_points(
    label: str, found: Mapping[str, Floats], parameter: str, x: Floats, span: tuple[float, float] | None
) -> Panel:
    """Values over the parameter's own axis, joined in its order."""
    order = np.argsort(x)
    lines = []
    for detector, values in found.items():
        value, low, high = values[order].T
        lines += [Line(detector, detector, x[order], value, "points", low, high), Line("", detector, x[order], value)]
    spread = x.min() > 0.0 and x.max() / x.min() > LOG_FROM
    return Panel("", in_words(parameter), label, tuple(lines), log="x" if spread else "", y_range=span, width_in=2.6)


def _named_points(label: str, found: Mapping[str, Floats], names: list[str], span: tuple[float, float] | None) -> Panel:
    """One row a point, for points that differ in more than a number."""
    place = np.arange(len(names))
    lines = tuple(
        Line(detector, detector, values[:, 0], place + 0.16 * (k - 0.5 * (len(found) - 1)), "points", *values[:, 1:].T)
        for k, (detector, values) in enumerate(found.items())
    )
    return Panel("", label, "", lines, ticks=tuple(names), flat=True, width_in=1.9, x_range=span)


def _in_words(point: str, variant: Mapping[str, Any]) -> str:
    """A point's own name, or its values in the units that people read."""
    if not variant or NAME in variant:
        return point
    return ", ".join(f"{in_words(name)}: {value_text(name, value)}" for name, value in variant.items())


def _rates_figure(
    run: RunData,
    name: str,
    title: str,
    paper: Mapping[str, RatePair],
    note: str,
    name_of: Callable[[Mapping[str, Any]], str],
) -> BarFigure:
    parts = list(variants(run).values())
    named = {name_of(part.cells[0]["cell"]): part for part in parts}
    swept = any(record["cell"].get("variant") for record in run.cells)
    panels, said = [], []
    for detector in judged_detectors(run):
        bars = []
        for group, part in named.items() if swept else ():
            tp, tn = _rates(part, detector)
            known = paper.get(group)
            bars += rate_pair(_wrapped(group), approach_table(part, detector), known)
            clause = f", {rate_against(tp, known.true_positive)}" if known else ""
            said.append(f"{detector}, {group}: TP {rate_text(tp)}{clause}, TN {rate_text(tn)}.")
        no_walks = approach_table(replace(run, cells=()), detector)
        panels.append(BarPanel(detector, tuple(bars or rate_pair("", no_walks, None))))
    return BarFigure(name, title, "share of walks (%)", "%", tuple(panels), " ".join(said) or "No data.", note, TOP)


def _rates(run: RunData, detector: str) -> tuple[Rate, Rate]:
    table = approach_table(run, detector)
    return true_positive_rate(table), true_negative_rate(table)


def _tp(run: RunData, detector: str) -> Measured:
    return percents(_rates(run, detector)[0])


def _tn(run: RunData, detector: str) -> Measured:
    return percents(_rates(run, detector)[1])


def _error(kind: str, quantity: str, scale: float) -> Callable[[RunData, str], Measured]:
    def median(run: RunData, detector: str) -> Measured:
        table = beep_table(run, detector, kind)
        errors = scale * absolute_errors(table, quantity, f"true_{quantity}")
        return quantile_with_interval(errors, 0.5, table["label"])[:3]

    return median


_MEASURES: dict[str, tuple[tuple[str, str, Callable[[RunData, str], Measured]], ...]] = {
    "approach": (
        ("TP, % of collisions", "%", _tp),
        ("TN, % of other walks", "%", _tn),
        ("range error, median (cm)", "cm", _error("approach", "range_m", 100.0)),
    ),
    "standing": (
        ("range error, median (cm)", "cm", _error("standing", "range_m", 100.0)),
        ("bearing error, median (°)", "°", _error("standing", "bearing_rad", math.degrees(1.0))),
    ),
}
_WHISKERS = {
    "approach": "Whiskers: 95 % intervals, exact for rates, bootstrap over walks for medians.",
    "standing": "Whiskers: 95 % bootstrap intervals over places of the phone; none with fewer than six.",
}
_MEASURED = {"approach": "TP, TN and range error", "standing": "Range and bearing error of a standing phone"}
"""What the figure has of walks, and where there are none of standing measurements."""
LOG_FROM = 30.0
"""Ratio of the greatest to the least value from which an axis is logarithmic."""


def _wrapped(name: str) -> str:
    """Long names in two or three lines."""
    words, lines = name.replace(", ", ",\n").split(" "), [""]
    for word in words:
        if len(lines[-1]) + len(word) > 12 and lines[-1]:
            lines.append(word)
        else:
            lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)
