"""Numerical stability at the extremes: every case's error as a share of what it may be."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure, TableFigure
from benchmarks.runs.results import RunData
from obstaclewatch.support.arrays import Floats

SMALLEST, GREATEST = 1e-15, 1e3
"""Shares beyond these are drawn there: errors of exactly 0, echoes that are missing."""
COLOURS = {"correct": "0", "refused": "muted", "wrong": "1"}
PANELS = {
    "wall-distance": ("distance_m", "distance of a wall (m)", "xy"),
    "wall-offset": ("offset_m", "distance from the origin (m)", "xy"),
    "sheets": ("gap_m", "gap between two sheets (m)", "xy"),
    "ball-incidence": ("angle_rad", "incidence on a sphere, rad", "y"),
    "weather": ("temperature_c", "temperature (°C)", "y"),
    "detector-snr": ("snr_db", "2E/N0 (dB)", "y"),
}
"""Axes drawn over their parameter: which, its words, and which scales are logarithmic."""


def extremes_map(run: RunData) -> PlotFigure:
    """Every case of every axis: the greatest error as a share of its limit."""
    names = _axes(run)
    lines = []
    for verdict, colour in COLOURS.items():
        found = [(k, case) for k, name in enumerate(names) for case in _cases(run, name) if case["verdict"] == verdict]
        share = np.array([_share(case) for _, case in found])
        lines.append(Line(verdict, colour, share, np.array([float(k) for k, _ in found]), "points"))
    panel = Panel(
        "", "error, share of its limit", "", tuple(lines), (Guide("x", 1.0, "limit"),), log="x",
        x_range=(0.3 * SMALLEST, 3.0 * GREATEST), ticks=tuple(names), flat=True, width_in=6.0,
    )  # fmt: skip
    note = f"Refused cases and errors of 0 are drawn at {SMALLEST:g}, missing echoes at {GREATEST:g}."
    return PlotFigure(
        "extremes", "Verdicts at the extremes", (panel,) if names else (), _reading(run), note, 0.19 * len(names) + 0.5
    )


def extremes_axes(run: RunData) -> PlotFigure:
    """The same share over the parameter of those axes that are scales."""
    panels: list[Panel] = []
    for name, (parameter, label, log) in PANELS.items():
        records = _records(run, name)
        if not records:
            continue
        x = np.array([float(record["cell"]["probe"][parameter]) for record in records])
        share = np.array([_share(record["result"]["numerics"]) for record in records])
        lines = tuple(
            Line(verdict, colour, *_where(x, share, records, verdict), "points") for verdict, colour in COLOURS.items()
        )
        y_label = "" if panels else "error, share of its limit"
        ends = (0.3 * SMALLEST, 3.0 * GREATEST)
        panels.append(
            Panel(name, label, y_label, lines, (Guide("y", 1.0, "limit"),), None, log, y_range=ends, width_in=2.4)  # type: ignore[arg-type]
        )
    return PlotFigure("extremes_axes", "Errors over the axes", tuple(panels), _reading(run))


def extremes_table(run: RunData) -> TableFigure:
    """Axis by axis: cases, verdicts, and the worst case that was not refused."""
    rows = []
    for name in _axes(run):
        cases = _cases(run, name)
        count = Counter(case["verdict"] for case in cases)
        verdicts = (str(count[verdict]) for verdict in COLOURS)
        rows.append((name, str(len(cases)), *verdicts, *_worst([c for c in cases if c["verdict"] != "refused"])))
    columns = ("axis", "cases", *COLOURS, "worst / limit", "of")
    return TableFigure(
        "extremes_table", "Verdicts by axis", columns, tuple(rows), (2.0, 0.7, 0.8, 0.8, 0.8, 1.1, 1.4), _reading(run)
    )


def _worst(cases: list[dict[str, Any]]) -> tuple[str, str]:
    """The greatest share of a limit, and of which; dashes where all was refused."""
    if not cases:
        return "–", "–"
    worst = max(cases, key=_share)
    shares = {key: abs(value or 0.0) / worst["limits"][key] for key, value in worst["errors"].items()}
    share = _share(worst)
    return f"{share:.2g}" if share > SMALLEST else "0", max(shares, key=shares.__getitem__, default="")


def _reading(run: RunData) -> str:
    cases = [case for name in _axes(run) for case in _cases(run, name)]
    count = Counter(case["verdict"] for case in cases)
    if not cases:
        return "No data."
    return (
        f"{len(cases)} cases: {count['correct']} correct, {count['refused']} refused with a named error, "
        f"{count['wrong']} silently wrong."
    )


def _axes(run: RunData) -> list[str]:
    """Names in the order of the run."""
    return list(dict.fromkeys(r["cell"]["category"] for r in run.ok if r["cell"]["kind"] == "numerics"))


def _records(run: RunData, axis: str) -> list[dict[str, Any]]:
    return [r for r in run.ok if r["cell"]["kind"] == "numerics" and r["cell"]["category"] == axis]


def _cases(run: RunData, axis: str) -> list[dict[str, Any]]:
    return [record["result"]["numerics"] for record in _records(run, axis)]


def _share(case: dict[str, Any]) -> float:
    """Worst error of its limit; what is infinite is stored as null."""
    worst = GREATEST if case["worst"] is None else float(case["worst"])
    return float(np.clip(worst, SMALLEST, GREATEST))


def _where(x: Floats, share: Floats, records: list[dict[str, Any]], verdict: str) -> tuple[Floats, Floats]:
    mask = np.array([record["result"]["numerics"]["verdict"] == verdict for record in records])
    return x[mask], share[mask]
