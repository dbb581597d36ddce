"""What a sweep costs beside its cells: plan, digests, files and reading back, for COUNT made-up cells in FOLDER.

    python -m tests.benchmarks.sweep_cost FOLDER 10000 100000

Prints microseconds of processor time a cell and the greatest memory; docs/slurm.md quotes it.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.plan.cells import plan_digest
from benchmarks.runs.executors.work import done_by
from benchmarks.runs.results import load_run
from benchmarks.runs.runner import run_cells
from benchmarks.runs.store import to_json, write_atomically
from tests.benchmarks.fake_cells import fake_manifest, fake_plan, fake_work


def timed(function: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of processor time, and what it gave: a busy machine changes them little."""
    begin = time.process_time()
    found = function()
    return time.process_time() - begin, found


def costs(folder: Path, count: int) -> dict[str, float]:
    """Seconds of each step for that many cells."""
    version, work = source_fingerprint(), fake_work()
    plan_s, cells = timed(lambda: fake_plan(count))
    digest_s, digests = timed(lambda: [cell.digest(version) for cell in cells])
    hash_s, _ = timed(lambda: plan_digest(cells, version))
    manifest_s, _ = timed(lambda: write_atomically(folder / "manifest.json", to_json(fake_manifest(digests))))
    work_s, _ = timed(lambda: [done_by(cell, version, work) for cell in cells[:2000]])
    run_s, tally = timed(lambda: run_cells(folder, cells, progress=False, work=work))
    resume_s, _ = timed(lambda: run_cells(folder, cells, progress=False, work=work))
    load_s, run = timed(lambda: load_run(folder))
    assert len(run.ok) == len(tally.ok) == count
    compute_s = work_s * count / min(count, 2000)
    return {
        "plan": plan_s, "digests": digest_s, "plan's hash": hash_s, "manifest": manifest_s,
        "store": run_s - compute_s, "resume": resume_s, "load": load_s,
    }  # fmt: skip


if __name__ == "__main__":
    for text in sys.argv[2:]:
        count = int(text)
        steps = costs(Path(sys.argv[1]) / text, count)
        shown = ", ".join(f"{name} {1e6 * seconds / count:.0f}" for name, seconds in steps.items())
        peak_gb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
        print(f"{count} cells, us a cell: {shown}; {peak_gb:.2f} GB", flush=True)
