"""A plan's cells, each computed once: what is on disk is kept, what is missing or failed is computed."""

from __future__ import annotations

import resource
import sys
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import joblib
from tqdm import tqdm

from benchmarks.cells.compute import compute
from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.cells.spec import Cell
from benchmarks.store import cell_path, cost_path, read_cell, to_json, write_atomically


def run_cells(run: Path, cells: Sequence[Cell], jobs: int = 1, progress: bool = True) -> list[dict[str, Any]]:
    """Compute what is missing and return all records in the order of the plan.

    Args:
        run: the run's folder.
        cells: the plan.
        jobs: worker processes; 1 stays in this process. The records do not depend on it.
        progress: show a bar where the output is a terminal.

    Raises:
        ValueError: `jobs` below 1.
        OSError: a file cannot be written; the cells done so far stay.
    """
    if jobs < 1:
        raise ValueError(f"jobs must be at least 1, got {jobs}")
    version = source_fingerprint()
    todo = [cell for cell in cells if not _done(run, cell.digest(version))]
    shown = tqdm(_computed(run, todo, version, jobs), total=len(todo), unit="walk", disable=not _shows(progress))
    for _ in shown:
        pass
    records = [read_cell(cell_path(run, digest), digest) for digest in (cell.digest(version) for cell in cells)]
    return [record for record in records if record is not None]


def compute_and_store(run: Path, cell: Cell, version: str) -> str:
    """Compute one cell, store it and its cost, and return its digest. A failure is stored with its traceback."""
    digest = cell.digest(version)
    record: dict[str, Any] = {"digest": digest, "label": cell.label, "cell": cell.model_dump(mode="json")}
    try:
        result = compute(cell)
    except Exception:  # whatever went wrong belongs in the record, and the other cells go on
        record |= {"status": "failed", "result": None, "error": traceback.format_exc()}
    else:
        cost = result.pop("cost") | {"peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0}
        write_atomically(cost_path(run, digest), to_json(cost))
        record |= {"status": "ok", "result": result, "error": None}
    write_atomically(cell_path(run, digest), to_json(record))
    return digest


def _done(run: Path, digest: str) -> bool:
    record = read_cell(cell_path(run, digest), digest)
    return record is not None and record["status"] == "ok"


def _computed(run: Path, cells: Sequence[Cell], version: str, jobs: int) -> Iterator[str]:
    if jobs == 1 or len(cells) < 2:
        yield from (compute_and_store(run, cell, version) for cell in cells)
        return
    with joblib.parallel_config(backend="loky", inner_max_num_threads=1):
        parallel = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
        yield from parallel(joblib.delayed(compute_and_store)(run, cell, version) for cell in cells)


def _shows(progress: bool) -> bool:
    return progress and sys.stderr.isatty()
