"""A defect of this program has an exit code of its own, one line, and its trace in a file."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from benchmarks import cli


def crash() -> None:
    raise RecursionError("maximum\ndepth")


@pytest.fixture
def crashing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cli, "cli", lambda **_: crash())


def test_a_crash_is_code_70_and_never_that_of_a_red_gate(
    crashing: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Cause: Python ends with 1 after a traceback, which says of `gate` that a gate is red."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 70
    line = capsys.readouterr().err
    assert line.count("\n") == 1
    assert "a defect of this program: RecursionError: maximum depth; its trace is in " in line
    trace = Path(line.rstrip().rpartition(" in ")[2])
    assert trace.parent == tmp_path
    assert "in crash" in trace.read_text(encoding="utf-8")


def test_without_a_place_for_the_trace_its_end_is_said(
    crashing: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("tempfile.tempdir", "/nowhere/at/all")
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 70
    assert "test_crash.py:" in capsys.readouterr().err


def test_letters_that_the_terminal_lacks_do_not_end_a_command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Cause: an error that named a path was itself a UnicodeEncodeError in a locale without the letter."""
    with (tmp_path / "out").open("w", encoding="latin-1") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setattr(sys, "argv", ["obstaclewatch", "status", "\u0142\u00fc"])
        with pytest.raises(SystemExit) as ended:
            cli.main()
    assert ended.value.code == 2
    assert "\\u0142\u00fc" in (tmp_path / "out").read_text(encoding="latin-1")
