"""A few cases of every axis of the suite `extremes`: enough to see a reference left, in seconds."""

from __future__ import annotations

from functools import cache

import numpy as np

from benchmarks.cells.probes.extremes import CHECKS
from benchmarks.cells.probes.extremes.verdict import judged
from benchmarks.cells.spec import Cell
from benchmarks.gates.physics.measured import Measured
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite

CASES = 4
"""Of an axis, evenly from its first value to its last."""
MOST_TRIANGLES = 10_000
MISSING = 1e9
"""The share of a limit that a missing echo stands for: infinite would read as unmeasured."""
GROUPS = tuple(dict.fromkeys(check.__module__.rpartition(".")[2] for check in CHECKS.values()))
"""Modules of checks: walls, triangulations, ..."""


def extremes_share(seed: int, group: str) -> Measured:
    """Greatest error of a group's cases as a share of its limit. The cases have no seed to change."""
    del seed
    shares = [judged(CHECKS[cell.category], cell.probe)["worst"] for cell in _few_cells(group)]
    return Measured(min(max(shares, default=np.nan), MISSING), "of the limit", len(shares))


@cache
def _few_cells(group: str) -> tuple[Cell, ...]:
    chosen: list[Cell] = []
    for axis, check in CHECKS.items():
        if check.__module__.rpartition(".")[2] == group:
            cells = [c for c in _all_cells() if c.category == axis and c.probe.get("count", 0) <= MOST_TRIANGLES]
            chosen += [cells[k] for k in np.unique(np.linspace(0, len(cells) - 1, CASES).round().astype(int))]
    return tuple(chosen)


@cache
def _all_cells() -> tuple[Cell, ...]:
    return tuple(plan_cells(load_suite("extremes"), "ci"))
