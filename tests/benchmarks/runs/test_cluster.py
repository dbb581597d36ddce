"""A Dask cluster of two worker processes on this machine's loopback, one of them killed midway."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.runs.executors import choose_executor
from benchmarks.runs.executors.cluster import dask_cluster
from benchmarks.runs.runner import run_cells
from tests.benchmarks.fake_cells import fake_plan, fake_work

ROOT = Path(__file__).resolve().parents[3]
DASK = [sys.executable, "-m", "dask"]


class Cluster:
    """A scheduler and two workers, as on a cluster's nodes; `address` is where the scheduler answers."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.file = folder, folder / "scheduler.json"
        self.processes = [self._start("scheduler", "--host", "127.0.0.1", "--port", "0")]
        self._wait(self.file.exists)
        self.workers = [self._start("worker", "--nthreads", "1", "--no-nanny") for _ in range(2)]
        self.processes += self.workers
        self.address = json.loads(self.file.read_text())["address"]

    def _start(self, what: str, *options: str) -> subprocess.Popen[bytes]:
        arguments = [*DASK, what, "--scheduler-file", str(self.file), "--no-dashboard", *options]
        environment = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
        with (self.folder / "log.txt").open("ab") as log:
            return subprocess.Popen(arguments, cwd=self.folder, env=environment, stdout=log, stderr=log)

    def _wait(self, condition, seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, (self.folder / "log.txt").read_text()
            time.sleep(0.05)

    def stop(self) -> None:
        """End all of it."""
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path) -> Iterator[Cluster]:
    place = Cluster(tmp_path)
    yield place
    place.stop()


def cells_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("cells/*/*.json")}


def killing(executor, cluster: Cluster, after: int):
    """The same executor, with one worker killed after so many cells."""

    def run(task, cells):
        for count, done in enumerate(executor(task, cells)):
            if count == after:
                cluster.workers[0].kill()
            yield done

    return run


def test_two_workers_one_killed_midway_change_nothing(tmp_path, cluster):
    cells = fake_plan(80)
    remote = choose_executor("dask", scheduler=cluster.address)
    tally = run_cells(tmp_path / "remote", cells, killing(remote, cluster, 20), work=fake_work(0.02))
    assert tally.complete
    assert cluster.workers[0].poll() is not None
    assert run_cells(tmp_path / "here", cells, work=fake_work()).complete
    assert len(cells_of(tmp_path / "here")) == 80
    assert cells_of(tmp_path / "remote") == cells_of(tmp_path / "here")


def test_a_scheduler_that_is_not_there_is_one_clear_error(monkeypatch):
    monkeypatch.setattr("benchmarks.runs.executors.cluster.CONNECT_S", 1)
    with pytest.raises(ValueError, match=r"scheduler must be where a Dask scheduler answers, got 'tcp://127.0.0.1:9'"):
        list(dask_cluster(fake_work, fake_plan(1), "tcp://127.0.0.1:9", 1))


@pytest.mark.slow
def test_the_paper_suite_is_the_same_on_a_cluster(tmp_path, cluster, monkeypatch):
    common = ["run", "paper", "--tier", "smoke", "--limit", "12", "--walks", "0"]
    here = [*common, "-j", "2", "-o", str(tmp_path / "here")]
    assert CliRunner().invoke(cli, here, catch_exceptions=False).exit_code == 0
    monkeypatch.setattr(
        "benchmarks.runs.executors.cluster.dask_cluster", partial(_killing_first, cluster, dask_cluster)
    )
    there = [*common, "--executor", "dask", "--scheduler", cluster.address, "-o", str(tmp_path / "there")]
    assert CliRunner().invoke(cli, there, catch_exceptions=False).exit_code == 0
    assert cluster.workers[0].poll() is not None
    found = [cells_of(tmp_path / name / "paper" / "latest") for name in ("here", "there")]
    assert len(found[0]) == 12
    assert found[0] == found[1]


def _killing_first(cluster, executor, task, cells, **options):
    return killing(partial(executor, **options), cluster, 3)(task, cells)
