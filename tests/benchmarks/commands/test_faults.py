"""What goes wrong around a run (the clock, the disk, the home, the locale) costs at most the run, never its results."""

from __future__ import annotations

import errno
import itertools
import os
import subprocess
import sys
import time
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from benchmarks.cells.compute import compute
from benchmarks.cells.spec import Cell
from benchmarks.cli import cli
from benchmarks.runs import manifest, store

RUN = ["run", "extremes", "-k", "slivers", "--limit", "2", "--walks", "0", "--set", "figures=[extremes_table]", "-o"]
ROOT = Path(__file__).resolve().parents[3]


def folder_of(out: Path) -> Path:
    return (out / "extremes" / "latest").resolve()


def contents(out: Path) -> dict[str, bytes]:
    """Everything of a run but what it cost and how it was called."""
    names = ("manifest.json", "costs.parquet", "report.html", "report.md", ".lock")
    found = {str(path.relative_to(folder_of(out))): path for path in folder_of(out).rglob("*") if path.is_file()}
    return {
        name: path.read_bytes()
        for name, path in found.items() if name not in names and not name.startswith("costs/")
    }  # fmt: skip


def called(out: Path) -> Result:
    return CliRunner().invoke(cli, [*RUN, str(out)])


@pytest.fixture(scope="module")
def calm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same run with nothing wrong."""
    out = tmp_path_factory.mktemp("calm")
    assert called(out).exit_code == 0
    return out


@pytest.mark.parametrize("step_s", [3600.0, -3600.0], ids=["forwards", "backwards"])
def test_a_clock_that_jumps_while_a_run_is_computed_changes_nothing(
    tmp_path: Path, calm: Path, monkeypatch: pytest.MonkeyPatch, step_s: float
) -> None:
    """Every look at the clock is an hour off the one before; then a cell is lost, and computed again a year off."""
    looks, now = itertools.count(), time.time

    class Jumping(datetime):
        @classmethod
        def now(cls, tz=None):
            return super().now(tz) + timedelta(seconds=step_s * next(looks))

    monkeypatch.setattr(time, "time", lambda: now() + step_s * next(looks))
    monkeypatch.setattr(manifest, "datetime", Jumping)
    assert called(tmp_path).exit_code == 0
    assert contents(tmp_path) == contents(calm)
    (lost, kept), asked = sorted(folder_of(tmp_path).glob("cells/*/*.json")), folder_of(tmp_path) / "manifest.json"
    began, stored = asked.read_bytes(), kept.stat().st_mtime_ns
    lost.unlink()
    os.utime(folder_of(tmp_path), (0.0, now() + 1e3 * step_s))
    looks = itertools.count(8760)
    assert called(tmp_path).exit_code == 0
    assert contents(tmp_path) == contents(calm)
    assert (asked.read_bytes(), kept.stat().st_mtime_ns) == (began, stored)


@pytest.mark.parametrize("fault", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()], ids=repr)
def test_any_write_of_a_run_may_fail(
    tmp_path: Path, calm: Path, monkeypatch: pytest.MonkeyPatch, fault: BaseException
) -> None:
    """The first write, the second, ...: each file stays as it was or is the new one, and nothing half lies about."""
    expected, replaced, reports = contents(calm), os.replace, ("report.html", "report.md")
    assert called(tmp_path).exit_code == 0
    for at in itertools.count():
        (folder_of(tmp_path) / "manifest.json").unlink(missing_ok=True)
        for name in (*reports, *(each for each in expected if not each.startswith("cells/"))):
            (folder_of(tmp_path) / name).write_bytes(b"old")
        for cell in list(folder_of(tmp_path).glob("cells/*/*.json"))[:1]:
            cell.unlink()
        writes = itertools.count()

        def failing(old, new, at=at, writes=writes) -> None:
            if next(writes) == at:
                raise fault
            replaced(old, new)

        with monkeypatch.context() as patch:
            patch.setattr(store.os, "replace", failing)
            done = called(tmp_path)
        if done.exit_code == 0:
            break
        told = done.exit_code == 3 if isinstance(fault, OSError) else isinstance(done.exception, SystemExit)
        assert told or done.exception is fault
        assert all(data in (b"old", expected[name]) for name, data in contents(tmp_path).items())
        for name, end in zip(reports, (b"</html>", b"`"), strict=True):
            text = (folder_of(tmp_path) / name).read_bytes().strip()
            assert text == b"old" or text.endswith(end)
        assert not list(tmp_path.rglob("*.partial"))
    assert at > len(expected)
    assert contents(tmp_path) == expected


def test_no_home_and_a_locale_without_unicode_are_no_hindrance(tmp_path: Path, calm: Path) -> None:
    """Compiled functions lie beside the source, Matplotlib and joblib keep theirs in the folder for temporary files.

    Cause of the other: the manifest holds the words of the call, which are no UTF-8 in such a locale; the folders had
    been made by then.
    """
    home, out = tmp_path / "home", tmp_path / "\u0142\u00fc"
    home.write_text("a file, so that nothing can be made in it, by root neither")
    left_out = ("XDG_", "MPL", "NUMBA_", "LC_", "LANG", "PYTHONUTF8")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(left_out)}
    plain = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.cli", *RUN, str(out), "-j", "2"],
        cwd=ROOT, env=kept | plain | {"HOME": str(home), "PYTHONPATH": str(ROOT)}, capture_output=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert contents(out) == contents(calm)


def test_a_run_of_which_every_cell_fails_is_incomplete(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cause: it ended with 4, which is for gates that measure nothing of a complete run, and so did its gate."""

    def broken(_: Cell) -> None:
        raise RuntimeError("boom\nsecond line")

    monkeypatch.setattr("benchmarks.cells.compute.compute", broken)
    done = called(tmp_path)
    assert done.exit_code == 3
    assert "slivers/0: RuntimeError: boom\n" in done.stderr
    assert "2 cells failed; their tracebacks are in" in done.stderr
    shown = CliRunner().invoke(cli, ["status", str(folder_of(tmp_path))])
    assert shown.exit_code == 3
    assert "slivers/0: RuntimeError: boom\n" in shown.output
    gates = tmp_path / "gates.yaml"
    gates.write_text("title: one\nphysics: {air_absorption: 0.001}\n")
    assert CliRunner().invoke(cli, ["gate", str(folder_of(tmp_path)), "--gates", str(gates)]).exit_code == 3


def test_a_cell_that_is_tried_again_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cause: its first failure was overwritten without a word."""
    calls = itertools.count()

    def broken_once(cell: Cell) -> dict[str, Any]:
        if next(calls) == 0:
            raise RuntimeError("boom")
        return compute(cell)

    monkeypatch.setattr("benchmarks.cells.compute.compute", broken_once)
    done = called(tmp_path)
    assert done.exit_code == 0
    assert "1 cell failed once and was tried again: " in done.stderr
