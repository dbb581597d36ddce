"""Cells whose numbers are made up at once, so that a sweep's bookkeeping can be tested by itself."""

from __future__ import annotations

import time
from typing import Any

from benchmarks.cells.spec import Cell
from benchmarks.runs.executors.work import Work


def fake_plan(count: int) -> list[Cell]:
    """That many different cells, "street/thing/0" and on."""
    return [
        Cell(
            kind="approach", scene="street", category="thing", index=k, phone="none", seed=k, collision=k % 2 == 0,
            detectors=("PaperDetector",),
        )
        for k in range(count)
    ]  # fmt: skip


def fake_manifest(digests: list[str]) -> dict[str, Any]:
    """What a run of these cells says of itself."""
    return {"argv": ["run"], "suite": "street", "tier": "smoke", "split": "test", "seed": 0, "plan": digests}


def fake_work(wait_s: float = 0.0, failing: tuple[int, ...] = ()) -> Work:
    """Work that any process can be sent: numbers that follow from the seed, and a cost that does not.

    A function inside a function travels whole, so that workers need not import the tests.
    """

    def work(cell: Any) -> dict[str, Any]:
        if wait_s > 0.0:
            time.sleep(wait_s)
        if cell.index in failing:
            raise ValueError(f"no such thing as {cell.index}")
        numbers = [float((cell.seed * 7919 + k) % 1009) / 7.0 for k in range(20)]
        truth = {"collides": cell.collision}
        return {"truth": truth, "detectors": {}, "numbers": numbers, "cost": {"total_s": time.perf_counter()}}

    return work
