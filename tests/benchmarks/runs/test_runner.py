"""Sweeps: the same results whatever the executor, and nothing lost to failures, dead workers or a full disk."""

from __future__ import annotations

import errno
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.plan.label_filter import label_filter
from benchmarks.runs.executors import WorkersLost, choose_executor, serial
from benchmarks.runs.results import load_run
from benchmarks.runs.runner import run_cells
from benchmarks.runs.store import cell_path, only_one_process, read_cell, to_json
from tests.benchmarks.fake_cells import fake_manifest, fake_plan, fake_work

ROOT = Path(__file__).resolve().parents[3]
FINGERPRINT = source_fingerprint()


def contents(run: Path) -> dict[str, bytes]:
    """Every cell's file."""
    return {path.name: path.read_bytes() for path in sorted((run / "cells").rglob("*.json"))}


def paths(run: Path, cells) -> list[Path]:
    return [cell_path(run, cell.digest(FINGERPRINT)) for cell in cells]


@pytest.mark.parametrize(("name", "jobs"), [("local", 1), ("local", 3), ("dask", 2)])
def test_results_do_not_depend_on_the_executor(tmp_path, name, jobs):
    cells = fake_plan(40)
    assert run_cells(tmp_path / "serial", cells, work=fake_work()).complete
    assert run_cells(tmp_path / "other", cells, choose_executor(name, jobs), work=fake_work()).complete
    assert len(contents(tmp_path / "serial")) == 40
    assert contents(tmp_path / "serial") == contents(tmp_path / "other")


def test_one_job_has_one_thread():
    """Threads that waited for products of a thousand paths doubled the processor time of rendering."""

    def threads(_cell):
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    with threadpool_limits(2, "blas"):
        assert list(serial(threads, fake_plan(1))) == [{1}]


def test_a_folder_in_place_of_a_cell_is_refused_before_anything_is_computed(tmp_path):
    """Cause: the end was an IsADirectoryError, of reading or of the rename after all was computed."""
    cells = fake_plan(3)
    path = paths(tmp_path, cells)[1]
    path.mkdir(parents=True)
    for attempt in (lambda: run_cells(tmp_path, cells, work=fake_work()), lambda: read_cell(path, path.stem)):
        with pytest.raises(ValueError, match=rf"'{path}' must be a file, got a folder"):
            attempt()
    assert list(tmp_path.glob("cells/*/*")) == [path]


@pytest.mark.parametrize("damage", ["cut short", "one digit", "another's", "empty", "not text"])
def test_a_damaged_cell_is_found_and_computed_again(tmp_path, damage):
    cells = fake_plan(3)
    run_cells(tmp_path, cells, work=fake_work())
    whole, (path, other, _) = contents(tmp_path), paths(tmp_path, cells)
    text = path.read_bytes()
    changed = text.replace(b'"seed": 0', b'"seed": 9')
    assert changed != text
    damaged = {
        "cut short": text[: len(text) // 2], "one digit": changed, "another's": other.read_bytes(), "empty": b"",
        "not text": b"\xff\xfe\x00" + text,
    }  # fmt: skip
    path.write_bytes(damaged[damage])
    (tmp_path / "manifest.json").write_text(to_json(fake_manifest([cell.digest(FINGERPRINT) for cell in cells])))
    assert len(load_run(tmp_path).cells) == 2
    done = []
    run_cells(tmp_path, cells, work=lambda cell: done.append(cell.index) or fake_work()(cell))
    assert done == [0]
    assert contents(tmp_path) == whole


def test_a_failing_cell_is_recorded_and_the_others_go_on(tmp_path):
    cells = fake_plan(4)
    tally = run_cells(tmp_path, cells, retries=0, work=fake_work(failing=(1,)))
    digests = [cell.digest(FINGERPRINT) for cell in cells]
    assert (tally.ok, tally.failed, tally.missing) == ((digests[0], *digests[2:]), (digests[1],), ())
    record = read_cell(cell_path(tmp_path, digests[1]), digests[1])
    assert record is not None
    assert "ValueError: no such thing as 1" in record["error"]
    assert run_cells(tmp_path, cells, work=fake_work()).complete  # the same plan, once the cause is gone


def test_fail_fast_begins_no_further_cell(tmp_path):
    tally = run_cells(tmp_path, fake_plan(5), retries=0, keep_going=False, work=fake_work(failing=(2,)))
    assert [len(kind) for kind in (tally.ok, tally.failed, tally.missing)] == [2, 1, 2]


@pytest.mark.parametrize(("retries", "left"), [(0, 1), (1, 1), (2, 0)])
def test_failed_cells_are_tried_again_so_often(tmp_path, retries, left):
    calls = {k: 0 for k in range(3)}

    def at_the_third_try(cell):
        calls[cell.index] += 1
        return fake_work(failing=(1,) if calls[1] < 3 else ())(cell)

    tally = run_cells(tmp_path, fake_plan(3), retries=retries, work=at_the_third_try)
    assert len(tally.failed) == left
    assert calls == {0: 1, 1: retries + 1, 2: 1}
    said = "1 cell failed up to 2 times and was tried again: street/thing/1, ValueError: no such thing as 1"
    assert tally.remarks() == ([] if left else [said])


def test_cells_that_were_tried_again_are_counted_and_a_few_named(tmp_path):
    """Cause: a detector that fails every other time ended as "0 failed"."""
    calls: list[str] = []

    def at_the_second_try(cell):
        calls.append(cell.label)
        return fake_work(failing=() if calls.count(cell.label) > 1 else tuple(range(4)))(cell)

    tally = run_cells(tmp_path, fake_plan(4), work=at_the_second_try)
    assert tally.complete
    (said,) = tally.remarks()
    assert said.startswith("4 cells failed once and were tried again: street/thing/0, ValueError: no such thing as 0; ")
    assert said.endswith("street/thing/2, ValueError: no such thing as 2; ...")
    assert run_cells(tmp_path, fake_plan(4), work=fake_work()).remarks() == []


def dies_once(flag: str):
    """Work that kills its process at cell 3, the first time."""

    def work(cell):
        if cell.index == 3 and not os.path.exists(flag):
            open(flag, "w").close()
            os.kill(os.getpid(), signal.SIGKILL)
        return {"truth": {}, "detectors": {}, "numbers": [cell.seed], "cost": {}}

    return work


@pytest.mark.parametrize("name", ["local", "dask"])
def test_a_killed_worker_changes_nothing(tmp_path, name):
    flag = str(tmp_path / "killed")
    tally = run_cells(tmp_path / "run", fake_plan(8), choose_executor(name, 2), work=dies_once(flag))
    assert Path(flag).exists()
    assert tally.complete
    run_cells(tmp_path / "calm", fake_plan(8), work=dies_once(flag))
    assert contents(tmp_path / "run") == contents(tmp_path / "calm")


def test_a_cell_that_always_kills_its_worker_is_missing_and_the_rest_is_done(tmp_path, capsys):
    def lost(task, cells):
        for cell in cells:
            if cell.index == 1:
                raise WorkersLost("a worker process died")
            yield task(cell)

    tally = run_cells(tmp_path, fake_plan(1) + fake_plan(3)[2:] + fake_plan(2)[1:], lost, work=fake_work())
    assert [len(kind) for kind in (tally.ok, tally.failed, tally.missing)] == [2, 0, 1]
    assert "1 cells are left" in capsys.readouterr().err


def test_workers_of_another_version_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.runs.runner.source_fingerprint", lambda: "0" * 64)
    with pytest.raises(ValueError, match="workers must have the plan's source 000000000000"):
        run_cells(tmp_path, fake_plan(2), work=fake_work())
    assert not list(tmp_path.rglob("*.json"))


def test_a_full_disk_is_one_error_and_loses_nothing_done(tmp_path, monkeypatch):
    cells, written = fake_plan(6), []

    def almost_full(partial, path):
        if len(written) == 7:  # three cells with their costs, and the cost of the fourth
            raise OSError(errno.ENOSPC, "No space left on device", str(path))
        written.append(path)
        replace(partial, path)

    replace = os.replace
    with monkeypatch.context() as patch:
        patch.setattr("benchmarks.runs.store.os.replace", almost_full)
        with pytest.raises(OSError, match="No space left on device"):
            run_cells(tmp_path, cells, work=fake_work())
    assert len(contents(tmp_path)) == 3
    begun = []
    assert run_cells(tmp_path, cells, work=lambda cell: begun.append(cell.index) or fake_work()(cell)).complete
    assert begun == [3, 4, 5]


def test_two_processes_do_not_share_a_run_and_leftovers_are_cleared(tmp_path):
    leftover = tmp_path / "cells" / "ab" / ".abc.json.17.partial"
    leftover.parent.mkdir(parents=True)
    leftover.write_text("half")
    with only_one_process(tmp_path):
        assert not leftover.exists()
        with pytest.raises(ValueError, match="one process at a time"):
            run_cells(tmp_path, fake_plan(1), work=fake_work())
    assert run_cells(tmp_path, fake_plan(1), work=fake_work()).complete


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("serial", 2), "the executor 'serial' has one job, got 2"),
        (("slurm", 2), r"executor must be one of .* got 'slurm'"),
        ((None, 0), "jobs must be at least 1, got 0"),
        (("local", 2, "tcp://127.0.0.1:1"), "a scheduler needs the executor 'dask', got 'local'"),
    ],
)
def test_executors_that_cannot_be_are_refused(arguments, says):
    with pytest.raises(ValueError, match=says):
        choose_executor(*arguments)
    assert choose_executor(None) is serial


@pytest.mark.parametrize(
    ("expression", "kept"),
    [
        ("wall", {"a/wall/1", "b/wall/2"}),
        ("not wall", {"a/car/3"}),
        ("wall and b", {"b/wall/2"}),
        ("car or b/", {"a/car/3", "b/wall/2"}),
        ("not (car or b/)", {"a/wall/1"}),
        ("a/ and not not wall", {"a/wall/1"}),
    ],
)
def test_filter_of_labels(expression, kept):
    fits = label_filter(expression)
    assert {label for label in ("a/wall/1", "b/wall/2", "a/car/3") if fits(label)} == kept


@pytest.mark.parametrize(
    "expression", ["", "wall and", "or wall", "(wall", "wall)", "wall car", "not", "wall (car)", "()"]
)
def test_filters_that_cannot_be_read_are_refused(expression):
    with pytest.raises(ValueError, match="-k must join words by and, or, not"):
        label_filter(expression)


def test_a_disk_that_is_really_full(tmp_path):
    """256 kB of memory as a disk: the sweep stops with one error, goes on elsewhere, and has lost nothing."""
    small = tmp_path / "small"
    small.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(small)]
    if os.geteuid() != 0 or subprocess.run(mount, check=False, capture_output=True).returncode != 0:
        pytest.skip("mounting a small disk takes root and leave to mount")
    cells = fake_plan(200)
    try:
        with pytest.raises(OSError, match="No space left on device"):
            run_cells(small / "run", cells, work=fake_work())
        shutil.copytree(small / "run", tmp_path / "run")
    finally:
        subprocess.run(["umount", str(small)], check=True)
    kept = contents(tmp_path / "run")
    assert 10 < len(kept) < 200
    begun = []
    assert run_cells(tmp_path / "run", cells, work=lambda cell: begun.append(1) or fake_work()(cell)).complete
    assert len(begun) == 200 - len(kept)
    assert run_cells(tmp_path / "calm", cells, work=fake_work()).complete
    assert contents(tmp_path / "calm") == contents(tmp_path / "run")


def test_bookkeeping_loads_no_library_of_cells():
    """Each process of a run took 4 s of processor time to start, whatever it computed."""
    code = "import sys, benchmarks.runs.runner, benchmarks.runs.executors.local; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, text=True)
    assert not {"numba", "scipy", "trimesh", "shapely", "matplotlib", "pandas"} & set(done.stdout.split())
