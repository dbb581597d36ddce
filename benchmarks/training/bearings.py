"""What bearings are learned from: the evidence of the target's candidate at every beep, beside its true bearing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.cells.spec import Cell
from benchmarks.training.examples import numbered, walk_files
from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.whole_file import whole_file
from obstaclewatch.tracking.bearing_model import BearingModel

STATED_DEG = (0, 10, 20, 40, 90)
"""Bins of true bearings in which errors are stated."""


@dataclass(frozen=True)
class BearingExamples(Rows):
    """n candidates.

    Attributes:
        walk, reception: (n,) the walk, and the number of its reception.
        evidence: (n, NUMBERS) see `bearing_evidence`.
        true_rad: (n,) true bearings, unsigned, of the target's nearest point.
    """

    walk: Ints
    reception: Ints
    evidence: Floats
    true_rad: Floats

    def weights(self) -> Floats:
        """(n,) by which candidates count: a walk's sum grows as the square root of their number."""
        _, which, count = np.unique(self.walk, return_inverse=True, return_counts=True)
        weight: Floats = 1.0 / np.sqrt(count[which])
        return weight / weight.mean()

    def write(self, path: Path) -> None:
        """Those at the levels assumed, evidence in half precision: what a card is held against."""
        first = self[self.reception == 0]
        evidence = first.evidence.astype(np.float16)
        with whole_file(path) as partial, partial.open("wb") as file:
            np.savez_compressed(file, walk=first.walk, evidence=evidence, true_rad=first.true_rad)

    @classmethod
    def from_file(cls, path: Path) -> BearingExamples:
        """What `write` wrote."""
        with np.load(path) as stored:
            walk, evidence, true_rad = (stored[name] for name in ("walk", "evidence", "true_rad"))
        return cls(walk, np.zeros_like(walk), evidence.astype(np.float64), true_rad)


def bearings_of(parts: Sequence[Sequence[Cell]], receptions: int, jobs: int, folder: Path) -> BearingExamples:
    """Examples of walks in several parts, from the same files as `examples_of`."""
    paths = walk_files(parts, receptions, jobs, folder)
    found: dict[str, list[NDArray]] = {name: [] for name in ("reception", "evidence", "true_rad")}
    for path in paths:
        with np.load(path) as stored:
            for name, rows in found.items():
                rows.append(stored[f"bearing_{name}"])
    columns: dict[str, Any] = {name: np.concatenate(rows) for name, rows in found.items()}
    return BearingExamples(np.repeat(numbered(parts), [len(rows) for rows in found["reception"]]), **columns)


def errors(model: BearingModel, found: BearingExamples, reception: int = 0) -> dict[str, Any]:
    """Errors at a reception, degrees, median and 80 %, by true bearing, and how many are within the claim."""
    found = found[found.reception == reception]
    bearing_rad, std_rad = model.bearings(found.evidence)
    error_rad = np.abs(bearing_rad - found.true_rad)
    entry: dict[str, Any] = {"walks": len(np.unique(found.walk))}
    if len(found):
        entry["within the claim"] = round(float(np.mean(error_rad < std_rad)), 3)
    for low, high in [*pairwise(STATED_DEG), (STATED_DEG[0], STATED_DEG[-1])]:
        error_deg = np.rad2deg(error_rad[(found.true_rad >= np.deg2rad(low)) & (found.true_rad < np.deg2rad(high))])
        if len(error_deg):
            spread = {"median": np.median(error_deg), "80 %": np.quantile(error_deg, 0.8)}
            entry[f"{low}-{high} degrees"] = {"beeps": len(error_deg)} | {
                k: round(float(v), 1) for k, v in spread.items()
            }
    return entry
