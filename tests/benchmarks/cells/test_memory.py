"""A walk that memory does not hold is refused before it is rendered, and an interrupted write leaves the old file."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from benchmarks.cells import memory
from benchmarks.cli import cli
from benchmarks.figures import FIGURES, DrawnFigure, write_figures
from benchmarks.runs.store import write_atomically, write_bytes_atomically
from tests.benchmarks.synthetic_run import made_up_run


def test_a_walk_too_long_for_memory_is_refused_with_both_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cause: a suite over a walk of an hour ended in MemoryError or the system's killer."""
    monkeypatch.setattr(memory, "free_bytes", lambda: 1e9)
    memory.check_memory(120.0, 192_000.0)
    with pytest.raises(ValueError, match=r"a walk of 600 s at 192000 Hz takes 2\.8 GB to render, 1\.0 GB are free"):
        memory.check_memory(600.0, 192_000.0)


def test_a_run_says_what_it_takes_and_refuses_more_than_there_is(tmp_path: Path, monkeypatch) -> None:
    """Cause: eight workers on a small machine were killed one after the other, without a word why."""
    monkeypatch.setattr(memory, "free_bytes", lambda: 5e9)
    call = ["run", "paper", "--tier", "smoke", "-n", "-o", str(tmp_path)]
    done = CliRunner().invoke(cli, [*call, "-j", "3"], catch_exceptions=False)
    assert done.exit_code == 0
    assert "3 processes take about 4.7 GB of memory, 5.0 GB are free" in done.output
    with pytest.raises(ValueError, match=r"8 processes take about 12\.6 GB of memory, 5\.0 GB are free: -j 3 fits"):
        CliRunner().invoke(cli, [*call, "-j", "8"], catch_exceptions=False, standalone_mode=False)


@pytest.mark.parametrize(
    "more",
    [
        ["tolerance"],
        ["paper", "--set", "fidelity.level=reference"],
        ["paper", "--set", "fidelity={level: auto, tolerance_db: 0.1}"],
    ],
)
def test_fine_facets_take_more(tmp_path: Path, monkeypatch, more: list[str]) -> None:
    """Cause: two workers beside cars took 5.2 GB, and the run had said 3.1."""
    monkeypatch.setattr(memory, "free_bytes", lambda: 9e9)
    call = ["run", *more, "--tier", "smoke", "-n", "-o", str(tmp_path), "-j", "2"]
    assert "2 processes take about 6.1 GB of memory" in CliRunner().invoke(cli, call, catch_exceptions=False).output


def test_a_longer_walk_takes_more(monkeypatch) -> None:
    monkeypatch.setattr(memory, "free_bytes", lambda: 2e9)
    with pytest.raises(ValueError, match=r"1 process takes about 4\.3 GB .* or shorter walks, fits"):
        memory.check_workers(1, 600.0, 192_000.0)


@pytest.mark.parametrize(
    ("duration_s", "says"),
    [
        ("3000", r"a\.wav' will have 3\.5 GB, its disk has 2\.0 GB free"),
        ("7200", r"a\.wav' will have 8\.3 GB, a WAV holds 4\.3 GB: use \.flac"),
    ],
)
def test_a_file_that_cannot_be_held_is_refused_before_it_is_rendered(tmp_path, monkeypatch, duration_s, says) -> None:
    monkeypatch.setattr(memory.shutil, "disk_usage", lambda _: SimpleNamespace(free=2e9))
    memory.check_file(tmp_path / "a.flac", 7200.0, 192_000.0)
    monkeypatch.setattr("obstaclewatch.write_recording", lambda *_: pytest.fail("rendered"))
    call = ["simulate", "supermarket", "--duration", duration_s, "-o", str(tmp_path / "a.wav")]
    with pytest.raises(ValueError, match=says):
        CliRunner().invoke(cli, call, catch_exceptions=False, standalone_mode=False)


def test_this_machine_says_what_is_free() -> None:
    assert 1e6 < memory.free_bytes() < 1e15


@pytest.mark.parametrize("write", [lambda p: write_bytes_atomically(p, b"new"), lambda p: write_atomically(p, "new")])
def test_a_full_disk_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write) -> None:
    """Cause: pictures were written in place, so that an interruption left half of one."""
    path = tmp_path / "a.png"
    write(path)
    path.write_bytes(b"old")

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="No space left"):
        write(path)
    assert path.read_bytes() == b"old"
    assert [each.name for each in tmp_path.iterdir()] == ["a.png"]


def test_figures_are_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = DrawnFigure(FIGURES["miss_distance"](made_up_run(tmp_path)))

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="No space left"):
        write_figures(tmp_path, [drawn])
    assert list((tmp_path / "figures").iterdir()) == []
