"""Accuracy and cost over stored runs: what each commit has measured of the same walks."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.figures.plots import Line, Panel, PlotFigure
from benchmarks.runs.stored import DatedManifest, StoredSummary, check_stored, read_json
from obstaclewatch.support.words import counted

SERIES = ["suite", "tier", "split", "seed", "cells"]
"""Runs that agree in these are compared: `cells` sets those apart that were cut by -k or --limit."""
MEDIANS = {"range_error_median_m": "range_m", "bearing_error_median_rad": "bearing_rad"}
PANELS = (
    ("TP before contact, % of collisions", "tp_before_contact", 100.0),
    ("TN, % of other walks", "tn", 100.0),
    ("range error, median (cm)", "range_error_median_m", 100.0),
    ("CPU of the detector, ms a beep,\nmedian over walks", "detect_cpu_s_per_beep", 1e3),
)
COSTS = ("simulate_s", "recording_s", "detect_cpu_s", "beeps")
WORDS = 10
"""Characters of a revision shown."""


def history(results: Path) -> tuple[pd.DataFrame, list[Path]]:
    """A row a run and detector, in the order in which runs began, and the runs that say nothing: not finished, swept,
    or of an older format.

    Raises:
        ValueError: the folder holds no run.
    """
    folders = sorted({path.parent.resolve() for path in results.glob("**/manifest.json")})
    if not folders:
        raise ValueError(f"results must be a folder with runs of `obstaclewatch run`, got '{results}'")
    rows, silent = [], []
    for folder in folders:
        try:
            rows += list(_rows(folder))
        except (OSError, KeyError, TypeError, ValueError):  # pyarrow's words for damage are the system's
            silent.append(folder)
    frame = pd.DataFrame(rows)
    return frame if frame.empty else frame.sort_values("started", kind="stable", ignore_index=True), silent


def history_figures(frame: pd.DataFrame) -> Iterator[PlotFigure]:
    """A figure of all runs that agree in `SERIES`, where these are two or more."""
    for key, part in frame.groupby(SERIES, sort=False):
        runs = part.drop_duplicates("run")
        if len(runs) < 2:
            continue
        place = dict(zip(runs.run, range(len(runs)), strict=True))
        ticks = tuple(f"{start[:10]}\n{revision}" for start, revision in zip(runs.started, runs.revision, strict=True))
        panels = tuple(_panel(part, place, ticks, *panel) for panel in PANELS)
        name = "-".join(map(str, key))
        title = f"{counted(len(runs), 'run')} of {key[0]}, tier {key[1]}, {counted(int(runs.cells.iloc[0]), 'cell')}"
        yield PlotFigure(
            f"history-{name}", title, panels, _reading(part),
            "Whiskers: exact 95 % intervals of rates. A + marks a run of a source with changes that are in no commit.",
        )  # fmt: skip


def _rows(folder: Path) -> Iterator[dict[str, Any]]:
    manifest = read_json(folder / "manifest.json")
    check_stored(manifest, DatedManifest, f"'{folder}'")
    found = read_json(folder / "summary.json")
    check_stored(found, StoredSummary, f"'{folder}'")
    revision = manifest["git_revision"] or f"source {manifest['source_sha256']}"
    costs = _costs(folder)
    for detector, measured in found["detectors"].items():
        yield {
            "run": folder.name, "started": manifest["started"],
            "revision": revision[:WORDS] + "+" * bool(manifest["git_dirty"]),
            **{name: manifest[name] for name in SERIES[:-1]},
            "cells": found["cells"], "failed": found["failed"], "detector": detector,
            **_measured(measured), **_cost(costs, detector), "folder": str(folder),
        }  # fmt: skip


def _measured(measured: dict[str, Any]) -> dict[str, float]:
    rates = {"tp_before_contact": measured["tp"]["0"], "tp_1m_left": measured["tp"]["1"], "tn": measured["tn"]}
    ends = (("", "value"), ("_low", "low"), ("_high", "high"))
    row = {f"{name}{end}": rate[key] for name, rate in rates.items() for end, key in ends}
    row |= {name: measured["walking"][quantity]["median"] for name, quantity in MEDIANS.items()}
    return {name: np.nan if value is None else value for name, value in row.items()}


def _costs(folder: Path) -> pd.DataFrame:
    """Those of walks, or of standing measurements where there are no walks; empty of a run that has no such table."""
    if not (folder / "costs.parquet").is_file():
        return pd.DataFrame(columns=["detector"])
    kinds = pd.read_csv(folder / "results.csv", usecols=["label", "kind", "detector"])
    costs = pd.read_parquet(folder / "costs.parquet").merge(kinds)
    if not all(pd.api.types.is_numeric_dtype(costs[name]) for name in COSTS):
        raise ValueError(f"costs must be numbers, got {costs[list(COSTS)].dtypes.to_dict()}")
    walks = costs[costs.kind != "standing"]
    return costs if walks.empty else walks


def _cost(costs: pd.DataFrame, detector: str) -> dict[str, float]:
    """Of simulation by second of recording over all walks; of the detector by beep, the median over walks as in the
    report, which one walk that waited for a compiler does not move."""
    ran = costs[costs.detector == detector]
    if ran.empty:
        return dict.fromkeys(("simulate_s_per_s", "detect_cpu_s_per_beep"), np.nan)
    return {
        "simulate_s_per_s": ran.simulate_s.sum() / ran.recording_s.sum(),
        "detect_cpu_s_per_beep": float(np.median(ran.detect_cpu_s / ran.beeps)),
    }


def _panel(
    part: pd.DataFrame, place: dict[str, int], ticks: tuple[str, ...], label: str, column: str, scale: float
) -> Panel:
    lines = []
    for detector, rows in part.groupby("detector", sort=False):
        x, value = np.array([float(place[run]) for run in rows.run]), scale * rows[column].to_numpy(float)
        ends = [scale * rows[f"{column}_{end}"].to_numpy(float) for end in ("low", "high") if f"{column}_low" in rows]
        lines += [Line(str(detector), str(detector), x, value, "points", *ends), Line("", str(detector), x, value)]
    span = (-3.0, 103.0) if "%" in label else None
    return Panel("", "", label, tuple(lines), ticks=ticks, y_range=span, width_in=max(2.6, 0.7 * len(ticks)))


def _reading(part: pd.DataFrame) -> str:
    """By detector, from the first run to the last; no rate of walks that are not there."""
    said = []
    for detector, rows in part.groupby("detector", sort=False):
        ends = [
            f"{label} {first:.1f} to {last:.1f} %"
            for label, name in (("TP", "tp_before_contact"), ("TN", "tn"))
            if np.isfinite([first := 100.0 * rows[name].iloc[0], last := 100.0 * rows[name].iloc[-1]]).all()
        ]
        said += [f"{detector}: {', '.join(ends)}."] if ends else []
    return " ".join(said) or "No walks."
