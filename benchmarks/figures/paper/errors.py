"""Errors of distance, bearing and radius (Figures 21 to 25)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from benchmarks.figures.data import Bar, BarFigure, BarPanel, Curve, CurveFigure, Mark
from benchmarks.figures.measured import (
    NO_DATA,
    error_curve,
    finite_quantile,
    judged_detectors,
    significant,
)
from benchmarks.runs.results import RunData
from benchmarks.scoring import paper_values
from benchmarks.scoring.scores import NARROW_M, Table, absolute_errors, beep_table, judged, rows_where
from benchmarks.scoring.statistics import quantile_with_interval

BEARING_BINS_DEG = (0.0, 10.0, 20.0, 40.0, 90.0)
INTERVALS = "In brackets: 95 % bootstrap intervals over walks."
BEARING_MARKS = (
    Mark("median", 0.5, paper_values.BEARING_MEDIAN, "diamond"),
    Mark("P80", 0.8, paper_values.BEARING_P80, "circle"),
)
RADIUS_MARKS = (
    Mark("median", 0.5, paper_values.RADIUS_MEDIAN, "diamond"),
    Mark("P80", 0.8, paper_values.RADIUS_P80, "circle"),
)


def distance_errors(run: RunData, range_m: float, name: str) -> CurveFigure:
    """Figures 21 to 23: a standing phone, Distance1 to the top and Distance2 to the bottom microphone.

    Beside the errors, against the target's nearest point, those against its nearest loud echo, of runs that store them.
    """
    curves: list[Curve] = []
    for detector in judged_detectors(run):
        table = rows_where(beep_table(run, detector, "standing"), standing_range_m=range_m)
        curves += [
            error_curve(table, f"{column}_m", f"true_{column}_m", "m", f"{detector}, {label}", detector, 0.9, dashed)
            for column, label, dashed in DISTANCES
        ]
        against = [
            replace(
                error_curve(
                    table, f"{column}_m", f"echo_{column}_m", "m", f"{detector}, {label} against the nearest loud echo",
                    detector, 0.9, dashed,
                ),
                diagnostic=True,
            )
            for column, label, dashed in DISTANCES
        ]  # fmt: skip
        curves += [curve for curve in against if curve.n]
    remark = DIAGNOSTIC if any(curve.diagnostic for curve in curves) else ""
    return CurveFigure(
        name=name,
        title=f"Fig. {name[3:]} · Distance error of a standing phone, {range_m:g} m",
        x_label="absolute error of the distance (cm)",
        unit="cm",
        curves=tuple(curves),
        marks=(marks := _distance_marks(range_m)),
        reading=_curves_sentence(curves, marks),
        note=f"{INTERVALS} Only echoes within the association gate count as estimates of the target.{remark}",
        reach=_distance_reach(run),
    )


def _distance_reach(run: RunData) -> float:
    """The greatest 95th percentile among Figures 21 to 23, cm, so that their axes are the same."""
    reach = [0.0]
    for detector in judged_detectors(run):
        table = beep_table(run, detector, "standing")
        for range_m in np.unique(table["standing_range_m"]) if len(table["label"]) else ():
            there = rows_where(table, standing_range_m=range_m)
            errors = (absolute_errors(there, f"{column}_m", f"true_{column}_m") for column, *_ in DISTANCES)
            reach += [100.0 * finite_quantile(each, 0.95) for each in errors]
    return float(np.nanmax(reach))


def bearing_errors(run: RunData) -> CurveFigure:
    """Figure 24: walking and standing, where the target is associated by its range."""
    curves = _state_curves(run, "bearing_rad", "rad")
    return CurveFigure(
        name="fig24",
        title="Fig. 24 · Bearing error",
        x_label="absolute error of the bearing (°)",
        unit="°",
        curves=curves,
        marks=BEARING_MARKS,
        reading=_curves_sentence(curves, BEARING_MARKS),
        note=" ".join([INTERVALS, *_standing_bearings(run)]),
    )


def _standing_bearings(run: RunData) -> list[str]:
    """Where the standing targets are, from the run itself: straight ahead the estimate clamps at 0."""
    bearings = {float(c["cell"]["bearing_rad"]) for c in run.cells if c["cell"]["kind"] == "standing"}
    if not bearings:
        return []
    if bearings == {0.0}:
        return ["Standing targets are straight ahead, where the estimate clamps at 0."]
    return [f"Standing targets are at {', '.join(f'{np.rad2deg(bearing):.3g}°' for bearing in sorted(bearings))}."]


def radius_errors(run: RunData) -> CurveFigure:
    """Figure 25, over targets up to `NARROW_M` in radius, as in the paper's Figure 11: people, signs, dustbins."""
    curves = _state_curves(run, "radius_m", "m")
    return CurveFigure(
        name="fig25",
        title=f"Fig. 25 · Radius error, targets up to {2 * NARROW_M:g} m wide",
        x_label="absolute error of the radius (cm)",
        unit="cm",
        curves=curves,
        marks=RADIUS_MARKS,
        reading=_curves_sentence(curves, RADIUS_MARKS),
        note=f"{INTERVALS} The true radius is half the target's width across the walk.",
    )


def bearing_errors_by_bin(run: RunData) -> BarFigure:
    """Figure 24, cut by the true bearing: near 0 the cosine clamps, and a pooled median hides the rest."""
    panels = []
    for detector in judged_detectors(run):
        table = beep_table(run, detector, "approach")
        panels.append(BarPanel(detector, tuple(_bin_bars(table))))
    sentences = [_bins_sentence(panel) for panel in panels]
    return BarFigure(
        name="fig24_bins",
        title="Fig. 24, cut by true bearing · Bearing error while walking",
        y_label="absolute error (°)",
        unit="°",
        panels=tuple(panels),
        reading=" ".join(sentences),
        note="Whiskers: 95 % bootstrap intervals over walks; beeps counted below the bars. "
        "The paper pools all bearings: median 4°, P80 8°.",
    )


DISTANCES = (("range", "Distance1", False), ("range2", "Distance2", True))
"""Columns, what the paper calls them, and whether they are dashed."""
DIAGNOSTIC = (
    " Thin (Distance1 dotted, Distance2 dots and dashes), a diagnostic: the same estimates against whichever of the "
    "target's loud echoes is nearest, by the simulator's paths."
)

DISTANCE_FIGURES = {
    name: partial(distance_errors, range_m=range_m, name=name)
    for name, range_m in (("fig21", 1.5), ("fig22", 3.0), ("fig23", 5.0))
}


def _distance_marks(range_m: float) -> tuple[Mark, ...]:
    """The paper prints the median of Distance1 at 1.5 and 5 m, and the 90th percentiles "across distances"."""
    median = paper_values.DISTANCE1_MEDIAN.get(range_m)
    middle = () if median is None else (Mark("Distance1 median", 0.5, median, "diamond"),)
    first = Mark("Distance1 P90", 0.9, paper_values.DISTANCE1_P90, "circle")
    return (*middle, first, Mark("Distance2 P90", 0.9, paper_values.DISTANCE2_P90, "square"))


def _state_curves(run: RunData, column: str, unit: str) -> tuple[Curve, ...]:
    """One curve a detector and state, walking solid and standing dashed."""
    curves = []
    for detector in judged_detectors(run):
        for kind, state in (("approach", "walking"), ("standing", "standing")):
            table = judged(beep_table(run, detector, kind), column)
            label = f"{detector}, {state}"
            curves.append(error_curve(table, column, f"true_{column}", unit, label, detector, 0.8, kind == "standing"))
    return tuple(curves)


def _curves_sentence(curves: Sequence[Curve], marks: Sequence[Mark]) -> str:
    said = [f"{curve.label}: {curve.summary.replace('; ', ', ')}" for curve in curves if curve.n]
    paper = ", ".join(f"{mark.label} {mark.paper.text}" for mark in marks)
    return f"{'; '.join(said) if said else NO_DATA.capitalize()}. The paper: {paper}."


def _bin_bars(table: Table) -> list[Bar]:
    bearing = np.rad2deg(table["true_bearing_rad"])
    errors = np.rad2deg(absolute_errors(table, "bearing_rad", "true_bearing_rad"))
    bars = []
    for low, high in pairwise(BEARING_BINS_DEG):
        inside = (bearing >= low) & (bearing < high)
        for label, quantile in (("median", 0.5), ("P80", 0.8)):
            value, least, most, count = quantile_with_interval(errors[inside], quantile, table["label"][inside])
            bars.append(Bar(f"{low:g}–{high:g}°", label, value, least, most, f"{count}", count))
    return bars


def _bins_sentence(panel: BarPanel) -> str:
    upper = [bar for bar in panel.bars if bar.series == "P80" and bar.n]
    if not upper:
        return f"{panel.title}: {NO_DATA}."
    said = ", ".join(f"{significant(bar.value)}° at {bar.group}" for bar in upper)
    return f"{panel.title}: 80 % of the errors are within {said}."
