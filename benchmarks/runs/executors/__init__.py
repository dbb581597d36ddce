"""Where cells are computed: in this process, in worker processes, or on a Dask cluster. The records stay the same.

Workers hand back text and never write: one process alone touches the run's folder.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from threadpoolctl import threadpool_limits

from benchmarks.cells.spec import Cell
from benchmarks.runs import EXECUTORS
from benchmarks.runs.executors.work import Done, Task, WorkersLost

__all__ = ["Done", "Executor", "Task", "WorkersLost", "choose_executor", "serial"]

Executor = Callable[[Task, Sequence[Cell]], Iterator[Done]]
"""Yields what is done in any order; raises `WorkersLost` if workers died and cells are left."""


def serial(task: Task, cells: Sequence[Cell]) -> Iterator[Done]:
    """One after the other, in this process, and as in a worker by one thread: others burn time while they wait."""
    with threadpool_limits(1, "blas"):
        yield from map(task, cells)


def choose_executor(name: str | None, jobs: int = 1, scheduler: str | None = None) -> Executor:
    """An executor by name; without one, "local" for several jobs and "serial" for one.

    Args:
        name: "serial", "local" or "dask".
        jobs: worker processes of "local", and of the cluster that "dask" starts where no scheduler is named.
        scheduler: address of a Dask scheduler, such as tcp://10.0.0.1:8786.

    Raises:
        ValueError: an unknown name, jobs below 1, or a scheduler or jobs for an executor that has none.
    """
    if jobs < 1:
        raise ValueError(f"jobs must be at least 1, got {jobs}")
    chosen = name or ("local" if jobs > 1 else "serial")
    if chosen not in EXECUTORS:
        raise ValueError(f"executor must be one of {list(EXECUTORS)}, got '{chosen}'")
    if scheduler is not None and chosen != "dask":
        raise ValueError(f"a scheduler needs the executor 'dask', got '{chosen}'")
    if chosen == "serial":
        if jobs > 1:
            raise ValueError(f"the executor 'serial' has one job, got {jobs}")
        return serial
    if chosen == "local":
        from benchmarks.runs.executors.local import worker_processes

        return partial(worker_processes, jobs=jobs)
    from benchmarks.runs.executors.cluster import dask_cluster

    return partial(dask_cluster, scheduler=scheduler, jobs=jobs)
