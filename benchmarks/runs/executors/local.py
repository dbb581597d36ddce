"""Worker processes on this machine."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence

import joblib
from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.process_executor import TerminatedWorkerError

from benchmarks.cells.memory import return_freed_memory
from benchmarks.cells.spec import Cell
from benchmarks.runs.executors.work import Done, Task, WorkersLost


def worker_processes(task: Task, cells: Sequence[Cell], jobs: int) -> Iterator[Done]:
    """Spread over `jobs` processes of one thread each.

    Raises:
        WorkersLost: a process died; all that was under way is lost, what was yielded is not.
    """
    with warnings.catch_warnings(), joblib.parallel_config(backend="loky", inner_max_num_threads=1):
        # As what is compiled takes memory, workers may be replaced all the same; no cell is lost by it.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given", UserWarning)
        parallel = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
        try:
            yield from parallel(joblib.delayed(_done_and_freed)(task, cell) for cell in cells)
        except TerminatedWorkerError as error:
            raise WorkersLost("a worker process died: killed, or out of memory") from error


def end_workers() -> None:
    """Kill the worker processes of this process, whatever they compute: it ends, and nobody waits for that.

    >>> end_workers()
    """
    # What is cancelled is known: joblib would say so once more.
    warnings.filterwarnings("ignore", r"\d+ tasks (have been|which were)", UserWarning)
    get_reusable_executor(max_workers=1, reuse=False, kill_workers=True)


def _done_and_freed(task: Task, cell: Cell) -> Done:
    """One cell, so that the worker is kept for the next (`return_freed_memory`)."""
    done = task(cell)
    return_freed_memory()
    return done
