"""A run as data frames: every number that the figures use, for statistics and pictures of one's own.

`results` has a row a cell and detector, `beeps` one a beep and target of these, `costs` what each cell took. A column
is defined once, in `benchmarks.scoring.scores`; its unit ends its name. What probes store as arrays stays in their
cells.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.cells.spec import counts_as, variant_text
from benchmarks.plan.sweep import NAME, value_at
from benchmarks.runs.reasons import reason
from benchmarks.runs.results import RunData
from benchmarks.runs.store import write_atomically, write_bytes_atomically
from benchmarks.scoring.scores import TRUE, beeps_of, judged, walk_row

CELL = ("kind", "scene", "category", "index", "phone", "seed")
WORDS = ("error", "point", "detector", "outcome")
Row = dict[str, Any]


def results_frame(run: RunData) -> pd.DataFrame:
    """One row per cell and detector; of a cell that failed, or is a probe, one row without a detector.

    Columns: label, what the cell is, its status and error, the parameters of its sweep or probe under their dotted
    names with the values that the cell has, those of `scores.approach_table`, and by quantity the median of the
    absolute and of the signed error over the beeps of which it is judged (`scores.judged`), and how many of these have
    an estimate; and how many beeps there are.
    """
    swept = swept_names(record["cell"].get("variant") or {} for record in run.cells)
    return frame_of([row for record in run.cells for row in _rows(record, swept)])


def beeps_frame(run: RunData) -> pd.DataFrame:
    """One row per beep, target and detector of all walks and standing measurements: see `scores.beep_table`."""
    parts = [
        pd.DataFrame({"label": record["label"], "detector": name, "target": target} | columns)
        for record in run.ok
        for name in record["result"]["detectors"]
        for target, columns in zip(record["result"]["truth"]["targets"], beeps_of(record, name), strict=True)
    ]
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=["label", "detector", "target"])


def costs_frame(run: RunData) -> pd.DataFrame:
    """One row per cell and detector: what simulating and detecting took; these alone differ from run to run."""
    rows = [
        {"label": record["label"], "detector": name, "detect_s": cost["detect_s"][name], "detect_cpu_s": cpu_s}
        | {column: cost.get(column) for column in ("beeps", "recording_s", "simulate_s", "peak_rss_mb")}
        for record, cost in zip(run.cells, run.costs, strict=True)
        for name, cpu_s in cost.get("detect_cpu_s", {}).items()
    ]
    return frame_of(rows)


FRAMES: dict[str, Callable[[RunData], pd.DataFrame]] = {
    "results": results_frame,
    "beeps": beeps_frame,
    "costs": costs_frame,
}


def write_frames(run: RunData) -> list[Path]:
    """results.csv, and results, beeps and costs as Parquet, in the run's folder."""
    written = [run.folder / "results.csv"]
    for name, build in FRAMES.items():
        frame = build(run)
        if name == "results":
            write_atomically(written[0], frame.to_csv(index=False, lineterminator="\n"))
        written.append(run.folder / f"{name}.parquet")
        write_bytes_atomically(written[-1], frame.to_parquet(index=False))
    return written


def swept_names(variants: Iterable[Mapping[str, Any]]) -> list[str]:
    """Parameters that points of a sweep name."""
    return sorted({name for variant in variants for name in variant} - {NAME})


def cell_row(record: Mapping[str, Any], swept: Sequence[str]) -> Row:
    """What a cell is, whoever runs on it: identity, status, and the values of swept and probed parameters."""
    cell, error = record["cell"], record["error"]
    return (
        {"label": record["label"]}
        | {name: cell[name] for name in CELL}
        | {"standing_range_m": cell["range_m"], "standing_bearing_rad": cell.get("bearing_rad")}
        | {"status": record["status"], "error": None if error is None else reason(error)}
        | {"point": variant_text(cell.get("variant") or {}).strip("[]") or None}
        | {name: _scalar(value_at(cell, name)) for name in swept}
        | {f"probe.{name}": _scalar(value) for name, value in (cell.get("probe") or {}).items()}
    )


def _rows(record: Mapping[str, Any], swept: Sequence[str]) -> list[Row]:
    shared, result = cell_row(record, swept), record["result"]
    detectors = {} if result is None else result["detectors"]
    if not detectors:
        return [shared | {"detector": None} | _numbers(result)]
    # A standing phone meets nothing: its row would count as a walk without a collision.
    unjudged = {} if counts_as(record["cell"], "approach") else {"outcome": None, "true_alert": None}
    return [
        shared | {"detector": name} | walk_row(record, name) | unjudged | _errors(record, name) for name in detectors
    ]


def _errors(record: Mapping[str, Any], detector: str) -> Row:
    """Medians over the beeps of all targets."""
    parts = beeps_of(record, detector)
    table = {
        column: np.array([value for columns in parts for value in columns[column]], dtype=np.float64)
        for column in itertools.chain.from_iterable(TRUE.values())
    }
    row: Row = {"beeps": sum(len(columns["beep"]) for columns in parts)}
    for name, (estimate, truth) in TRUE.items():
        quantity, _, unit = name.rpartition("_")
        rows = judged(table, estimate)
        error = rows[estimate] - rows[truth]
        error = error[~np.isnan(error)]
        row[f"{quantity}_estimates"] = len(error)
        for kind, values in (("error", np.abs(error)), ("bias", error)):
            row[f"{quantity}_{kind}_median_{unit}"] = float(np.median(values)) if len(values) else math.nan
    return row


def _numbers(result: Mapping[str, Any] | None) -> Row:
    """Single numbers and words of a probe, by their dotted place."""
    flat = pd.json_normalize({} if result is None else dict(result)).to_dict("records")
    return {str(name): value for row in flat for name, value in row.items() if not isinstance(value, list | dict)}


def _scalar(value: Any) -> Any:
    return value if value is None or isinstance(value, bool | int | float | str) else json.dumps(value)


def frame_of(rows: list[Row]) -> pd.DataFrame:
    """Rows as a frame whose columns hold one type, as Parquet asks for: words among numbers make all of them words."""
    frame = pd.DataFrame(rows)
    for name in (name for name in frame if pd.api.types.is_object_dtype(frame[name])):
        kinds = {type(value) for value in frame[name].dropna()}
        if len(kinds) > 1:
            frame[name] = frame[name].map(str, na_action="ignore")
        elif kinds == {bool}:
            frame[name] = frame[name].astype("boolean")  # the type of bool that can be missing
        elif not kinds:
            frame[name] = frame[name].astype("str" if name in WORDS else "float64")
    return frame
