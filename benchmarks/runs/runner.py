"""A plan's cells, each computed once: what is on disk is kept, what is missing or failed is computed."""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tqdm import tqdm

from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.cells.spec import Cell
from benchmarks.runs.executors import Executor, Task, WorkersLost, serial
from benchmarks.runs.executors.work import Done, Work, done_by
from benchmarks.runs.progress import progress as shown_progress
from benchmarks.runs.reasons import reason
from benchmarks.runs.store import cell_path, cost_path, only_one_process, read_cell, write_cell, write_cost
from benchmarks.runs.stored import check_file
from obstaclewatch.support.words import counted

MOST_NAMED = 3
"""Cells that a remark names."""


@dataclass(frozen=True)
class Tally:
    """How a run's cells stand.

    Attributes:
        ok, failed, missing: digests of cells, in the order of the plan. Missing are those whose workers died, or that
            were not begun because an earlier one failed.
        tried_again: label and reasons of each cell that is ok now, but failed before: a detector whose result depends
            on more than the recording, or a machine that was short of something.
    """

    ok: tuple[str, ...]
    failed: tuple[str, ...]
    missing: tuple[str, ...]
    tried_again: tuple[tuple[str, tuple[str, ...]], ...] = ()

    @property
    def complete(self) -> bool:
        """Whether every cell is there and none failed."""
        return not self.failed and not self.missing

    def remarks(self) -> list[str]:
        """What is to be said of cells that are ok, in words; a few of them stand for all.

        >>> Tally(("ab12",), (), (), (("campus/wall/0", ("RuntimeError: boom",)),)).remarks()
        ['1 cell failed once and was tried again: campus/wall/0, RuntimeError: boom']
        """
        if not self.tried_again:
            return []
        count, most = len(self.tried_again), max(len(reasons) for _, reasons in self.tried_again)
        named = "; ".join(f"{label}, {reasons[0]}" for label, reasons in self.tried_again[:MOST_NAMED])
        often = "once" if most == 1 else f"up to {most} times"
        were, rest = "cell {} and was" if count == 1 else "cells {} and were", "; ..." * (count > MOST_NAMED)
        return [f"{count} {were.format(f'failed {often}')} tried again: {named}{rest}"]


def run_cells(
    run: Path,
    cells: Sequence[Cell],
    executor: Executor = serial,
    *,
    retries: int = 1,
    keep_going: bool = True,
    progress: bool = True,
    work: Work | None = None,
) -> Tally:
    """Compute what is missing, and store each cell as soon as it is done.

    Args:
        run: the run's folder.
        cells: the plan.
        executor: where they are computed; the records do not depend on it.
        retries: how often cells that failed, or whose worker died, are tried again.
        keep_going: go on with the other cells after one has failed.
        progress: show a bar on stderr, or a line now and then where that is no terminal.
        work: what is done with a cell; `benchmarks.cells.compute.compute` by default.

    Raises:
        ValueError: negative retries; another process works on the same run; a worker has another source; a folder lies
            where a cell belongs.
        OSError: a file cannot be written; the cells done so far stay.
    """
    if retries < 0:
        raise ValueError(f"retries must be at least 0, got {retries}")
    version = source_fingerprint()
    task = partial(done_by, version=version, work=_compute if work is None else work)
    digests = [cell.digest(version) for cell in cells]
    with only_one_process(run):
        state = {digest: _stored_status(run, digest) for digest in digests}
        planned = dict(zip(digests, cells, strict=True))
        failures: dict[str, list[str]] = defaultdict(list)
        stored = sum(status == "ok" for status in state.values())
        with shown_progress(len(planned), stored, "cell", progress) as bar:
            for done in _attempts(planned, state, retries, executor, task):
                _store(run, done)
                state[done.digest] = "ok" if done.ok else "failed"
                bar.update(int(done.ok))
                if not done.ok:
                    failures[done.digest].append(reason(json.loads(done.record)["error"]))
                if not (done.ok or keep_going):
                    break
    return _tally(state, planned, failures)


def shortfall(run: Path, tally: Tally, most: int) -> list[str]:
    """What keeps a run from being complete, a line each: why cells failed, how many did, how many are missing.

    Args:
        run: the run's folder.
        most: so many failures are given with their reasons.
    """
    lines = []
    for digest in tally.failed[:most]:
        record = read_cell(cell_path(run, digest), digest)
        if record is not None:
            lines.append(f"failed: {record['label']}: {reason(record['error'])}")
    if tally.failed:
        count = counted(len(tally.failed), "cell failed; its traceback is", "cells failed; their tracebacks are")
        lines.append(f"{count} in {run / 'cells'}")
    if tally.missing:
        count = counted(len(tally.missing), "cell is", "cells are")
        lines.append(f"{count} missing; the same command goes on there")
    return lines


def _attempts(
    planned: Mapping[str, Cell], state: Mapping[str, str | None], retries: int, executor: Executor, task: Task
) -> Iterator[Done]:
    """Every cell that is not ok, and again those that are not ok by then."""
    for _ in range(retries + 1):
        todo = {digest: cell for digest, cell in planned.items() if state[digest] != "ok"}
        yield from _computed(todo, executor, task)


def _computed(todo: dict[str, Cell], executor: Executor, task: Task) -> Iterator[Done]:
    """Every cell once. After workers died the rest goes again, as long as each time something gets done."""
    left = dict(todo)
    while left:
        before = len(left)
        try:
            for done in executor(task, list(left.values())):
                del left[done.digest]
                yield done
        except WorkersLost as error:
            tqdm.write(f"{error}; {len(left)} cells are left", file=sys.stderr)
            if len(left) == before:
                return


def _tally(
    state: Mapping[str, str | None], planned: Mapping[str, Cell], failures: Mapping[str, Sequence[str]]
) -> Tally:
    ok, failed, missing = (
        tuple(digest for digest, found in state.items() if found == kind) for kind in ("ok", "failed", None)
    )
    again = tuple((planned[digest].label, tuple(failures[digest])) for digest in ok if digest in failures)
    return Tally(ok, failed, missing, again)


def _compute(cell: Cell) -> dict[str, Any]:
    """The bench's work, imported where it is done."""
    from benchmarks.cells.compute import compute

    return compute(cell)


def _store(run: Path, done: Done) -> None:
    if done.cost is not None:
        write_cost(cost_path(run, done.digest), done.cost)
    write_cell(cell_path(run, done.digest), done.record)


def _stored_status(run: Path, digest: str) -> str | None:
    path = cell_path(run, digest)
    check_file(path)  # before anything is computed that could not be stored
    try:
        record = read_cell(path, digest)
    except ValueError as error:
        tqdm.write(f"{error}; it is computed again", file=sys.stderr)
        return None
    return None if record is None else str(record["status"])
