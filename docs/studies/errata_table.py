"""What each erratum costs: a table from a run of the suite `errata`.

obstaclewatch run errata --tier full
python -m docs.studies.errata_table results/errata/latest
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from benchmarks.runs.results import RunData, load_run

HEADER = (
    "switched back",
    "range, standing (cm)",
    "bearing, standing, deg",
    "radius read, standing (m)",
    "found, standing",
    "candidates a beep, walking",
    "TP",
    "TN",
)


def errata_rows(run: RunData) -> list[list[str]]:
    """One row a detector, the corrected one first: medians of absolute errors, and counts."""
    names = list(run.ok[0]["result"]["detectors"])
    names.sort(key=lambda name: name != "PaperDetector")
    return [_row(run, name) for name in names]


def markdown(rows: list[list[str]]) -> str:
    """The rows as a table."""
    lines = [HEADER, ["---"] * len(HEADER), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _row(run: RunData, name: str) -> list[str]:
    standing = [beeps for cell, beeps in _tables(run, name) if cell["kind"] == "standing"]
    walking = [beeps for cell, beeps in _tables(run, name) if cell["kind"] != "standing"]
    outcomes = [cell["result"]["detectors"][name]["outcome"] for cell in run.ok if cell["cell"]["kind"] != "standing"]
    range_m = _column(standing, "range_m") - _column(standing, "true_range_m")
    bearing = np.degrees(_column(standing, "bearing_rad") - _column(standing, "true_bearing_rad"))
    switch = name.removeprefix("PaperDetector").strip("()").removesuffix("=False")
    return [
        f"`{switch}`" if switch else "nothing",
        _median(100.0 * np.abs(range_m), ".1f"),
        _median(np.abs(bearing), ".1f"),
        _median(_column(standing, "radius_m"), ".2f"),
        f"{np.mean(np.isfinite(range_m)):.0%}",
        f"{np.mean(_column(walking, 'candidates')):.1f}",
        _share(outcomes, "TP", "FN"),
        _share(outcomes, "TN", "FP"),
    ]


def _tables(run: RunData, name: str) -> Iterator[tuple[Mapping[str, Any], Mapping[str, Any]]]:
    """Every cell with what the detector said of its first target, beep by beep."""
    for record in run.ok:
        yield record["cell"], record["result"]["detectors"][name]["beeps"][0]


def _column(tables: list[Mapping[str, Any]], key: str) -> np.ndarray:
    return np.concatenate([np.array(table[key], dtype=np.float64) for table in tables])


def _median(values: np.ndarray, form: str) -> str:
    return f"{np.nanmedian(values):{form}}" if np.isfinite(values).any() else "none"


def _share(outcomes: list[str], good: str, bad: str) -> str:
    return f"{outcomes.count(good)} of {outcomes.count(good) + outcomes.count(bad)}"


if __name__ == "__main__":
    print(markdown(errata_rows(load_run(sys.argv[1]))))
