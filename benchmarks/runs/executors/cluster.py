"""A Dask cluster: cells as futures. Workers need the same source, and one thread each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from itertools import islice
from typing import Any

from benchmarks.cells.spec import Cell
from benchmarks.runs.executors.work import Done, Task, WorkersLost

CONNECT_S = 30
AHEAD = 4
"""Cells handed out per worker thread: enough to keep it busy, few enough that a million cells do not wait in memory."""


def dask_cluster(task: Task, cells: Sequence[Cell], scheduler: str | None, jobs: int) -> Iterator[Done]:
    """Spread over the workers of a scheduler, or over `jobs` processes started here where none is named.

    Dask itself computes the cells of a dead worker again, elsewhere.

    Raises:
        ValueError: Dask is not installed, or no scheduler answers at that address.
        WorkersLost: the same cell's worker died again and again, or no worker is left.
    """
    try:
        from distributed import Client, KilledWorker, LocalCluster
    except ImportError as error:
        raise ValueError(f"the executor 'dask' needs the extra obstaclewatch[cluster], got: {error}") from error
    with ExitStack() as stack:
        place: Any = scheduler
        if scheduler is None:
            place = stack.enter_context(
                LocalCluster(n_workers=jobs, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0")
            )
        try:
            client = stack.enter_context(Client(place, timeout=CONNECT_S, set_as_default=False))
        except (OSError, TimeoutError, ValueError) as error:
            raise ValueError(f"scheduler must be where a Dask scheduler answers, got '{scheduler}': {error}") from error
        try:
            yield from _as_done(client, task, cells)
        except KilledWorker as error:
            raise WorkersLost(f"workers died over the same cell: {error}") from error


def _as_done(client: Any, task: Task, cells: Sequence[Cell]) -> Iterator[Done]:
    from distributed import as_completed

    waiting = iter(cells)
    window = AHEAD * max(1, sum(client.nthreads().values()))
    under_way = as_completed(client.map(task, list(islice(waiting, window)), pure=False), loop=client.loop)
    for future in under_way:
        yield future.result()
        for cell in islice(waiting, 1):
            under_way.add(client.submit(task, cell, pure=False))
