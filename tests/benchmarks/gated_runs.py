"""Runs made up walk by walk, and what typical mistakes in a detector do to them."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.runs.results import RunData

from .synthetic_run import MANIFEST, standing, walk

DETECTOR = "PaperDetector"
LATE_M = 2 / 192_000 * 343.0 / 2
"""What two samples of delay add to a microphone's range."""


def good_run(folder: Path, seed: int = 2018, walks: int = 80) -> RunData:
    """Half collisions, nine in ten judged right, with range errors of some millimetres that differ between walks."""
    rng = np.random.default_rng(seed)
    cells = []
    for k in range(walks):
        collides, right = k % 2 == 0, k % 20 > 1
        alert_m = 2.0 if collides == right else None
        cells.append(walk(index=k, collides=collides, alert_distance_m=alert_m, detectors=(DETECTOR,)))
    cells += [standing(1.5, k, detectors=(DETECTOR,)) for k in range(6)]
    for cell in cells:
        cell["result"] = copy.deepcopy(cell["result"])
        _shift(cell, "range_m", float(rng.normal(0.0, 0.004)))
        _shift(cell, "range2_m", float(rng.normal(0.0, 0.004)))
    return run_of(folder, cells, seed)


def run_of(folder: Path, cells: list[dict[str, Any]], seed: int = 2018) -> RunData:
    """A whole run of these cells."""
    plan = [f"{k:064x}" for k in range(len(cells))]
    manifest = MANIFEST | {"plan": plan, "seed": seed, "source_sha256": "0" * 64}
    return RunData(folder, manifest, tuple(cells))


def changed(run: RunData, change: Any) -> RunData:
    """The run with a change made to a copy of every cell."""
    cells = [copy.deepcopy(cell) for cell in run.cells]
    for k, cell in enumerate(cells):
        change(cell, k)
    return RunData(run.folder, run.manifest, tuple(cells))


def one_channel_late(cell: dict[str, Any], _: int) -> None:
    """Microphone 2 comes two samples late."""
    _shift(cell, "range2_m", LATE_M)


def threshold_too_high(cell: dict[str, Any], k: int) -> None:
    """3 dB: every second beep loses a candidate, every tenth the target."""
    beeps = _beeps(cell)
    beeps["candidates"] = [max(count - (row % 2), 0) for row, count in enumerate(beeps["candidates"])]
    if k % 5 == 0:
        for name in ("range_m", "range2_m", "bearing_rad", "radius_m", "snr_db"):
            beeps[name][-1] = None


def votes_too_few(cell: dict[str, Any], k: int) -> None:
    """One vote is enough: half of the walks without a collision raise an alert."""
    if cell["cell"]["kind"] == "approach" and not cell["result"]["truth"]["collides"] and k % 4 == 1:
        cell["result"]["detectors"][DETECTOR] |= {"alert": True, "outcome": "FP"}


def _beeps(cell: dict[str, Any]) -> dict[str, list[Any]]:
    return cell["result"]["detectors"][DETECTOR]["beeps"][0]


def _shift(cell: dict[str, Any], column: str, by: float) -> None:
    beeps = _beeps(cell)
    beeps[column] = [None if value is None else value + by for value in beeps[column]]
