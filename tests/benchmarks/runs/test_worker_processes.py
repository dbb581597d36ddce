"""Worker processes stay: each new one loads libraries and compiled functions, and prepares meshes anew."""

from __future__ import annotations

import os
import sys
import time

import numpy as np
import pytest

from benchmarks.cells.spec import Cell
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.runs.executors.local import worker_processes
from benchmarks.runs.executors.work import Done
from obstaclewatch.support.arrays import Floats

BLOCK, BLOCKS = 12_000, 4_500  # 430 MB of what comes from the heap, not from the system one by one
CHECKED_S = 1.1  # joblib looks at a worker's memory at most once a second
KEPT: list[Floats] = []


def _fills_the_heap(cell: Cell) -> Done:
    """Say which process this is; after its first cell leave a heap with little in it, but at its end."""
    blocks = [np.ones(BLOCK) for _ in range(BLOCKS if KEPT else 1)]
    KEPT.append(blocks[-1])
    del blocks
    time.sleep(CHECKED_S)
    return Done(cell.label, True, str(os.getpid()), None)


@pytest.mark.skipif(sys.platform != "linux", reason="needs a C library whose heap can be trimmed")
def test_freed_memory_does_not_get_workers_replaced() -> None:
    """Cause: arrays freed in the middle of the heap counted as a leak, so that workers were replaced every 90 s."""
    pytest.importorskip("psutil", reason="joblib looks at the memory of workers only with psutil")
    cells = plan_cells(load_suite("paper"), "smoke")[:8]
    done = worker_processes(_fills_the_heap, cells, 2)
    assert len({entry.record for entry in done}) <= 2
