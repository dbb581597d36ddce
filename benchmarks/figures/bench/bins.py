"""Errors by range, speed and bearing, and how often there is none: the curves that pooled medians hide."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.figures.bench.budget import closing_speed
from benchmarks.figures.measured import binned_line, binned_rates, judged_detectors, quantile_over_walks, sentences
from benchmarks.figures.plots import Line, Panel, PlotFigure
from benchmarks.runs.results import RunData
from benchmarks.scoring.scores import Table, beep_table, chosen
from obstaclewatch import Flag
from obstaclewatch.support.arrays import Floats, Strings

RANGE_M = (0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 7.0)
SPEED_M_S = (0.0, 0.5, 0.8, 1.1, 1.4, 1.7, 3.0)
BEARING_DEG = (0.0, 5.0, 10.0, 20.0, 30.0, 45.0, 90.0)
INTERVALS = "Whiskers: 95 % intervals, bootstrap over walks for errors, exact (beeps taken as independent) for shares."


def errors_by_bin(run: RunData) -> PlotFigure:
    """Signed range error by range and closing speed, bearing error by bearing, all while walking."""
    cuts: tuple[tuple[str, str, tuple[float, ...], Callable[[Table], Floats], Callable[[Table], Floats]], ...] = (
        ("true range, m", "range error, median with sign, cm", RANGE_M, _range_m, _signed_range_cm),
        ("closing speed, m/s", "range error, median with sign, cm", SPEED_M_S, closing_speed, _signed_range_cm),
        ("true bearing, °", "bearing error, median, °", BEARING_DEG, _bearing_deg, _bearing_error_deg),
    )
    panels, said = [], []
    for x_label, y_label, edges, place, error in cuts:
        lines = []
        for detector in judged_detectors(run):
            table = beep_table(run, detector, "approach")
            lines.append(_error_line(detector, edges, place(table), error(table), table["label"]))
        panels.append(Panel("", x_label, y_label, tuple(lines)))
        said += [
            f"{line.label}, by {x_label.split(',')[0]}: {np.nanmin(line.y):.1f} to {np.nanmax(line.y):.1f} "
            f"{y_label.split(', ')[-1]}"
            for line in lines
            if np.isfinite(line.y).any()
        ]
    return PlotFigure(
        "error_bins",
        "Range and bearing error while walking, by range, speed and bearing",
        tuple(panels),
        sentences(said),
        INTERVALS,
    )


def missing_by_bin(run: RunData) -> PlotFigure:
    """Beeps without an estimate by range, and bearings that were clamped by bearing, while walking."""
    missing, clamped, said = [], [], []
    for detector in judged_detectors(run):
        table = beep_table(run, detector, "approach")
        none = ~np.isfinite(table["range_m"])
        missing.append(binned_rates(detector, RANGE_M, _range_m(table), none))
        known = chosen(table, np.isfinite(table["bearing_rad"]))
        bits = known["flags"].astype(int) & int(Flag.CLAMPED) if "flags" in known else np.zeros(0, dtype=int)
        places = _bearing_deg(known) if "flags" in known else np.zeros(0)
        clamped.append(binned_rates(detector, BEARING_DEG, places, bits != 0))
        if len(none):
            share = f", {100 * np.mean(bits != 0):.0f} % of its bearings clamped" if len(bits) else ""
            said.append(f"{detector}: no estimate in {100 * none.mean():.0f} % of the beeps{share}")
    panels = (
        Panel("", "true range, m", "beeps without an estimate, %", tuple(missing), y_range=(-3.0, 103.0)),
        Panel("", "true bearing, °", "bearings clamped, %", tuple(clamped), y_range=(-3.0, 103.0)),
    )
    return PlotFigure(
        "missing_bins",
        "Missing estimates by range, and clamped bearings by bearing",
        panels,
        sentences(said),
        INTERVALS,
    )


def _error_line(detector: str, edges: tuple[float, ...], place: Floats, error: Floats, walks: Strings) -> Line:
    return binned_line(detector, edges, place, lambda bin_: quantile_over_walks(error[bin_], 0.5, walks[bin_])[:3])


def _range_m(table: Table) -> Floats:
    return table["true_range_m"]


def _bearing_deg(table: Table) -> Floats:
    return np.rad2deg(table["true_bearing_rad"])


def _signed_range_cm(table: Table) -> Floats:
    return 100.0 * (table["range_m"] - table["true_range_m"])


def _bearing_error_deg(table: Table) -> Floats:
    return np.rad2deg(np.abs(table["bearing_rad"] - table["true_bearing_rad"]))
