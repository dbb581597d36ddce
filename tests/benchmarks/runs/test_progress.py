"""What a log shows of a run: a line at each tenth and each minute."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from benchmarks.runs.progress import PlainLines, progress
from benchmarks.runs.runner import run_cells
from tests.benchmarks.fake_cells import fake_plan, fake_work


def lines_of(total: int, done: int, steps: list[tuple[float, int]]) -> list[str]:
    """What is said where so many are done at such times."""
    said: list[str] = []
    times = iter([0.0, *(at_s for at_s, _ in steps)])
    told = PlainLines(total, done, "cell", said.append, lambda: next(times))
    for _, count in steps:
        told.update(count)
    return said


def test_each_tenth_has_a_line() -> None:
    said = lines_of(100, 0, [(5.0 * (k + 1), 1) for k in range(100)])
    assert len(said) == 10
    assert said[0] == "10 of 100 cells, 00:50 elapsed, about 07:30 left"
    assert said[-1] == "100 of 100 cells, 08:20 elapsed"


def test_slow_cells_have_a_line_each_minute() -> None:
    assert lines_of(100, 0, [(61.0, 1), (100.0, 1), (122.0, 0)]) == [
        "1 of 100 cells, 01:01 elapsed",
        "2 of 100 cells, 02:02 elapsed, about 1:39:38 left",
    ]


def test_compiling_within_the_first_cell_is_not_taken_for_the_pace_of_all() -> None:
    """Cause: after a first cell of 63 s a run of 140 s was said to take an hour more."""
    assert lines_of(63, 0, [(63.0, 1), (81.0, 6)]) == [
        "1 of 63 cells, 01:03 elapsed",
        "7 of 63 cells, 01:21 elapsed, about 02:48 left",
    ]


def test_quick_cells_do_not_flood_the_log() -> None:
    assert lines_of(1000, 0, [(0.001 * k, 1) for k in range(1000)]) == []


def test_what_was_done_before_says_nothing_of_what_is_left() -> None:
    assert lines_of(100, 90, [(10.0, 1), (20.0, 9)]) == ["100 of 100 cells, 00:20 elapsed"]
    assert lines_of(10, 8, [(70.0, 0)]) == ["8 of 10 cells, 01:10 elapsed"]


def test_a_run_without_a_terminal_shows_life(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Cause: nothing was printed from the first cell to the last, for minutes in a CI's log."""
    run_cells(tmp_path, fake_plan(2), work=fake_work(wait_s=0.6))
    assert "2 of 2 cells, 00:01 elapsed" in capsys.readouterr().err
    run_cells(tmp_path / "quiet", fake_plan(2), work=fake_work(wait_s=0.6), progress=False)
    assert capsys.readouterr().err == ""


def test_a_terminal_has_a_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert not isinstance(progress(2, 0, "cell"), PlainLines)
