"""Worker processes on this machine."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence

import joblib
from joblib.externals.loky.process_executor import TerminatedWorkerError

from benchmarks.cells.spec import Cell
from benchmarks.runs.executors.work import Done, Task, WorkersLost


def worker_processes(task: Task, cells: Sequence[Cell], jobs: int) -> Iterator[Done]:
    """Spread over `jobs` processes of one thread each.

    Raises:
        WorkersLost: a process died; all that was under way is lost, what was yielded is not.
    """
    with warnings.catch_warnings(), joblib.parallel_config(backend="loky", inner_max_num_threads=1):
        # Where psutil is installed, workers that grew by 300 MB are replaced, as by compilation; no cell is lost by it.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given", UserWarning)
        parallel = joblib.Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
        try:
            yield from parallel(joblib.delayed(task)(cell) for cell in cells)
        except TerminatedWorkerError as error:
            raise WorkersLost("a worker process died: killed, or out of memory") from error
