"""Where cells are computed: in this process, or by joblib workers with one thread each."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import Any

from benchmarks.cells.attempt import attempt
from benchmarks.cells.spec import Cell

EXECUTORS = ("local", "serial")
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

Task = tuple[Cell, str]


def one_thread_each() -> None:
    """Ask numerical libraries for one thread, so that sums run in one order. Call before numpy is first imported."""
    for name in THREAD_VARIABLES:
        os.environ[name] = "1"


def computed(tasks: Sequence[Task], executor: str, jobs: int) -> Iterator[dict[str, Any]]:
    """Records of the tasks as they are finished, in any order.

    Args:
        tasks: cells and their digests.
        executor: "local" (joblib worker processes) or "serial" (this process).
        jobs: number of workers of "local".

    Raises:
        ValueError: an unknown executor, or no workers.
    """
    if executor not in EXECUTORS:
        raise ValueError(f"executor must be one of {EXECUTORS}, got {executor!r}")
    if jobs < 1:
        raise ValueError(f"jobs must be at least 1, got {jobs}")
    return _serial(tasks) if executor == "serial" else _local(tasks, jobs)


def _serial(tasks: Sequence[Task]) -> Iterator[dict[str, Any]]:
    return (attempt(cell, digest) for cell, digest in tasks)


def _local(tasks: Sequence[Task], jobs: int) -> Iterator[dict[str, Any]]:
    from joblib import Parallel, delayed, parallel_config

    # One cell a message: what a killed run loses is what was being computed, no more.
    with parallel_config(backend="loky", inner_max_num_threads=1):
        workers = Parallel(n_jobs=jobs, batch_size=1, pre_dispatch="2*n_jobs", return_as="generator_unordered")
        yield from workers(delayed(attempt)(cell, digest) for cell, digest in tasks)
