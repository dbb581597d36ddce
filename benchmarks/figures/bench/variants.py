"""The points of a sweep as runs of their own, and what changes from one to the next (Figure 18 and its like)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.cells.spec import variant_text
from benchmarks.figures.data import Bar, BarFigure, BarPanel
from benchmarks.figures.measured import (
    INTERVALS,
    TN,
    TOP,
    TP,
    judged_detectors,
    quantile_over_walks,
    rate_against,
    rate_bar,
    rate_text,
)
from benchmarks.figures.plots import Figure, Line, Panel, PlotFigure
from benchmarks.runs.results import RunData
from benchmarks.scoring import paper_values
from benchmarks.scoring.paper_values import RatePair
from benchmarks.scoring.scores import (
    absolute_errors,
    approach_table,
    beep_table,
    true_negative_rate,
    true_positive_rate,
)
from benchmarks.scoring.statistics import Rate

WALKS = ("approach", "scene")
"""Kinds of cells that have alerts to count."""


def variants(run: RunData) -> dict[str, RunData]:
    """The run cut by the points of its sweep, in the order of the plan; one entry for a run without a sweep."""
    names = [variant_name(record["cell"].get("variant") or {}) for record in run.cells]
    parts = {}
    for name in dict.fromkeys(names):
        kept = [k for k, each in enumerate(names) if each == name]
        costs = tuple(run.costs[k] for k in kept) if run.costs else ()
        parts[name] = replace(run, cells=tuple(run.cells[k] for k in kept), costs=costs)
    return parts


def variant_name(variant: Mapping[str, Any]) -> str:
    """A point of a sweep for people: its name, or "start_hz=16000"; the unchanged suite is "as it is"."""
    return variant_text(dict(variant)).removeprefix("[").removesuffix("]") or "as it is"


def of_one_variant(builder: Callable[[RunData], Figure]) -> Callable[[RunData], Figure]:
    """The builder, given the first point of a sweep alone: pooled points would be no measurement of anything."""

    def build(run: RunData) -> Figure:
        first, remark = first_point(run)
        figure = builder(first)
        return replace(figure, note=f"{remark} {figure.note}") if remark else figure

    return build


def first_point(run: RunData) -> tuple[RunData, str]:
    """The first point of a run's sweep and a remark that says so; without a sweep the run itself and no remark."""
    parts = variants(run)
    if len(parts) < 2:
        return run, ""
    name, first = next(iter(parts.items()))
    return first, f"Of the sweep, the point '{name}' alone."


def rates_by_band(run: RunData) -> BarFigure:
    """Figure 18: the band of the beep; the paper's values where the bands are the paper's."""
    note = f"{INTERVALS} The same walks with both beeps. The paper's two figures for one place, 17 and 18, differ by "
    note += "1.5 points: noise."
    return _rates_figure(run, "fig18", "Fig. 18 · By band of the beep", paper_values.BY_BAND, note, band_name)


def rates_by_holding(run: RunData) -> BarFigure:
    """Section 5.1: the phone held vertically and horizontally."""
    note = f"{INTERVALS} The same walks. Held horizontally, the bearing is the angle to the phone's long edge, which "
    note += "now points to the left: Eq. 2 then takes what is ahead for what is abeam."
    return _rates_figure(run, "holding", "Section 5.1 · By holding of the phone", {}, note, holding_name)


def rates_by_interference(run: RunData) -> PlotFigure:
    """Section 5.3: a second phone nearby."""
    note = "The second phone stands 29° to the left of the walk's start and sends as loudly as ours."
    return _sweep_figure(run, "interference", "Section 5.3 · A second phone nearby", note)


def sweep_curves(run: RunData) -> PlotFigure:
    """TP, TN and the median range error of every point of a sweep, in its order."""
    return _sweep_figure(run, "sweep", "The points of the sweep", "")


def _sweep_figure(run: RunData, name: str, title: str, note: str) -> PlotFigure:
    parts = variants(run) if any(record["cell"].get("variant") for record in run.cells) else {}
    parts = {point: part for point, part in parts.items() if any(c["cell"]["kind"] in WALKS for c in part.cells)}
    names = tuple(_wrapped(point) for point in parts)
    detectors = judged_detectors(run)
    panels: list[Panel] = []
    said: dict[str, list[str]] = {detector: [] for detector in detectors}
    for label, measure in (("TP, % of walks", _tp), ("TN, % of walks", _tn), ("range error, median, cm", _range)):
        lines = []
        for k, detector in enumerate(detectors):
            values = np.array([measure(part, detector) for part in parts.values()]).reshape(-1, 3)
            if np.isfinite(values[:, 0]).any():
                ends_of = f"{np.nanmin(values[:, 0]):.1f} to {np.nanmax(values[:, 0]):.1f}"
                said[detector].append(f"{label.split(',')[0]} {ends_of} {'cm' if measure is _range else '%'}")
            place = np.arange(len(values)) + 0.16 * (k - 0.5 * (len(detectors) - 1))
            lines.append(Line(detector, detector, values[:, 0], place, "points", values[:, 1], values[:, 2]))
        ticks = tuple(word.replace("\n", " ") for word in names) if not panels else tuple("" for _ in names)
        ends = (-3.0, 103.0) if measure is not _range else None
        panels.append(Panel("", label, "", tuple(lines), ticks=ticks, flat=True, width_in=2.3, x_range=ends))
    return PlotFigure(
        name,
        title,
        tuple(panels),
        " ".join(f"{name}: {', '.join(words)}." for name, words in said.items() if words) or "No data.",
        f"Whiskers: 95 % intervals, Wilson's for rates, bootstrap over whole walks for medians. {note}",
        height_in=max(2.4, 0.32 * len(names) + 0.4),
    )


def band_name(cell: Mapping[str, Any]) -> str:
    """ "16-23 kHz", of whatever else is swept."""
    return f"{cell['beep']['start_hz'] / 1e3:g}-{cell['beep']['stop_hz'] / 1e3:g} kHz"


def holding_name(cell: Mapping[str, Any]) -> str:
    """How the phone is held."""
    return str((cell.get("walk") or {}).get("holding") or "vertical")


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
            shown = _wrapped(group)
            bars.append(rate_bar(shown, TP, tp, known.true_positive if known else None))
            bars.append(rate_bar(shown, TN, tn, known.true_negative if known else None))
            clause = f", {rate_against(tp, known.true_positive)}" if known else ""
            said.append(f"{detector}, {group}: TP {rate_text(tp)}{clause}, TN {rate_text(tn)}.")
        panels.append(BarPanel(detector, tuple(bars) or _no_bars()))
    return BarFigure(name, title, "share of walks, %", "%", tuple(panels), " ".join(said) or "No data.", note, TOP)


def _no_bars() -> tuple[Bar, ...]:
    return (Bar("", TP, np.nan, np.nan, np.nan, "", 0), Bar("", TN, np.nan, np.nan, np.nan, "", 0))


def _rates(run: RunData, detector: str) -> tuple[Rate, Rate]:
    table = approach_table(run, detector)
    return true_positive_rate(table), true_negative_rate(table)


def _tp(run: RunData, detector: str) -> tuple[float, float, float]:
    found = _rates(run, detector)[0]
    return 100.0 * found.value, 100.0 * found.low, 100.0 * found.high


def _tn(run: RunData, detector: str) -> tuple[float, float, float]:
    found = _rates(run, detector)[1]
    return 100.0 * found.value, 100.0 * found.low, 100.0 * found.high


def _range(run: RunData, detector: str) -> tuple[float, float, float]:
    table = beep_table(run, detector, "approach")
    errors = 100.0 * absolute_errors(table, "range_m", "true_range_m")
    return quantile_over_walks(errors, 0.5, table["label"])[:3]


def _wrapped(name: str) -> str:
    """Long names in two or three lines."""
    words, lines = name.replace(", ", ",\n").split(" "), [""]
    for word in words:
        if len(lines[-1]) + len(word) > 12 and lines[-1]:
            lines.append(word)
        else:
            lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)
