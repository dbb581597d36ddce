"""A sweep of made-up cells as a process of its own, to be killed: FOLDER CELLS EXECUTOR JOBS WAIT_S."""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks.runs.executors import choose_executor
from benchmarks.runs.runner import run_cells
from tests.benchmarks.fake_cells import fake_plan, fake_work

if __name__ == "__main__":
    folder, count, name, jobs, wait_s = sys.argv[1:]
    executor = choose_executor(name, int(jobs))
    run_cells(Path(folder), fake_plan(int(count)), executor, work=fake_work(float(wait_s)))
