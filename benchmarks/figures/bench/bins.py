"""Errors by range, speed and bearing, and how often there is none: the curves that pooled medians hide."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from benchmarks.figures.bench.budget import closing_speed
from benchmarks.figures.measured import judged_detectors, quantile_over_walks
from benchmarks.figures.plots import Line, Panel, PlotFigure
from benchmarks.runs.results import RunData
from benchmarks.scoring.scores import Table, beep_table, chosen, rate
from obstaclewatch import Flag

RANGE_M = (0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 7.0)
SPEED_M_S = (0.0, 0.5, 0.8, 1.1, 1.4, 1.7, 3.0)
BEARING_DEG = (0.0, 5.0, 10.0, 20.0, 30.0, 45.0, 90.0)
INTERVALS = (
    "Whiskers: 95 % intervals, bootstrap over whole walks for errors, Wilson's (beeps taken as independent) for shares."
)


def errors_by_bin(run: RunData) -> PlotFigure:
    """Signed range error by range and closing speed, bearing error by bearing, all while walking."""
    cuts: tuple[
        tuple[str, str, tuple[float, ...], Callable[[Table], np.ndarray], Callable[[Table], np.ndarray]], ...
    ] = (
        ("true range, m", "range error, median with sign, cm", RANGE_M, _range_m, _signed_range_cm),
        ("closing speed, m/s", "range error, median with sign, cm", SPEED_M_S, closing_speed, _signed_range_cm),
        ("true bearing, °", "bearing error, median, °", BEARING_DEG, _bearing_deg, _bearing_error_deg),
    )
    panels, said = [], []
    for x_label, y_label, edges, place, error in cuts:
        lines = []
        for detector in judged_detectors(run):
            table = beep_table(run, detector, "approach")
            lines.append(_line(detector, edges, place(table), error(table), table["label"]))
        panels.append(Panel("", x_label, y_label, tuple(lines)))
        said += [
            f"{line.label}, by {x_label.split(',')[0]}: {np.nanmin(line.y):.1f} to {np.nanmax(line.y):.1f} "
            f"{y_label.split(', ')[-1]}"
            for line in lines
            if np.isfinite(line.y).any()
        ]
    return PlotFigure(
        "error_bins",
        "Errors while walking, by range, speed and bearing",
        tuple(panels),
        f"{'; '.join(said)}." if said else "No data.",
        INTERVALS,
    )


def missing_by_bin(run: RunData) -> PlotFigure:
    """Beeps without an estimate by range, and bearings that were clamped by bearing, while walking."""
    missing, clamped, said = [], [], []
    for detector in judged_detectors(run):
        table = beep_table(run, detector, "approach")
        none = ~np.isfinite(table["range_m"])
        missing.append(_share_line(detector, RANGE_M, _range_m(table), none))
        known = chosen(table, np.isfinite(table["bearing_rad"]))
        bits = known["flags"].astype(int) & int(Flag.CLAMPED) if "flags" in known else np.zeros(0, dtype=int)
        places = _bearing_deg(known) if "flags" in known else np.zeros(0)
        clamped.append(_share_line(detector, BEARING_DEG, places, bits != 0))
        if len(none):
            share = f", {100 * np.mean(bits != 0):.0f} % of its bearings clamped" if len(bits) else ""
            said.append(f"{detector}: no estimate in {100 * none.mean():.0f} % of the beeps{share}")
    panels = (
        Panel("", "true range, m", "beeps without an estimate, %", tuple(missing), y_range=(-3.0, 103.0)),
        Panel("", "true bearing, °", "bearings clamped, %", tuple(clamped), y_range=(-3.0, 103.0)),
    )
    return PlotFigure(
        "missing_bins",
        "What is not estimated, and what is clamped",
        panels,
        f"{'; '.join(said)}." if said else "No data.",
        INTERVALS,
    )


def _line(detector: str, edges: tuple[float, ...], place: np.ndarray, error: np.ndarray, walks: np.ndarray) -> Line:
    x, values = [], []
    for low, high in pairwise(edges):
        inside = (place >= low) & (place < high)
        found = quantile_over_walks(error[inside], 0.5, walks[inside])
        if found[3]:
            x.append(float(place[inside].mean()))
            values.append(found[:3])
    y = np.array(values).reshape(-1, 3)
    least, most = (np.where(np.isfinite(y[:, k]), y[:, k], y[:, 0]) for k in (1, 2))
    return Line(detector, detector, np.array(x), y[:, 0], "points", least, most)


def _share_line(detector: str, edges: tuple[float, ...], place: np.ndarray, hit: np.ndarray) -> Line:
    x, values = [], []
    for low, high in pairwise(edges):
        inside = (place >= low) & (place < high)
        found = rate(hit[inside])
        if found.n:
            x.append(float(place[inside].mean()))
            values.append((100.0 * found.value, 100.0 * found.low, 100.0 * found.high))
    y = np.array(values).reshape(-1, 3)
    return Line(detector, detector, np.array(x), y[:, 0], "points", y[:, 1], y[:, 2])


def _range_m(table: Table) -> np.ndarray:
    return table["true_range_m"]


def _bearing_deg(table: Table) -> np.ndarray:
    return np.rad2deg(table["true_bearing_rad"])


def _signed_range_cm(table: Table) -> np.ndarray:
    return 100.0 * (table["range_m"] - table["true_range_m"])


def _bearing_error_deg(table: Table) -> np.ndarray:
    return np.rad2deg(np.abs(table["bearing_rad"] - table["true_bearing_rad"]))
