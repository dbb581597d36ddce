"""Runs of several commits become one table, and a picture of those that walked the same walks."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.history import history, history_figures
from benchmarks.runs.store import to_json, write_atomically
from benchmarks.runs.variants import variants
from benchmarks.scoring.frames import write_frames
from benchmarks.scoring.scores import summary
from tests.benchmarks.synthetic_run import made_up_run, standing, walk


def stored(results: Path, name: str, started: str, alerts: int, walks: int = 4, **manifest) -> None:
    """A run of so many collisions, `alerts` of them in time, with what `run` leaves of it."""
    cells = [walk(index=k, alert_distance_m=2.0 if k < alerts else None) for k in range(walks)]
    run = made_up_run(results / "paper" / name, cells, **({"git_dirty": False} | manifest))
    told = run.manifest | {"plan": [], "started": started, "source_sha256": "f00d" * 16}
    write_atomically(run.folder / "manifest.json", to_json(told))
    write_atomically(run.folder / "summary.json", to_json(summary(run, variants(run))))
    write_frames(run)


@pytest.fixture
def results(tmp_path: Path) -> Path:
    stored(tmp_path, "late", "2026-03-01T00:00:00", alerts=3, git_revision="bbbbbbbbbbbbbbbb", git_dirty=True)
    stored(tmp_path, "early", "2026-01-01T00:00:00", alerts=1, git_revision="aaaaaaaaaaaaaaaa")
    stored(tmp_path, "cut", "2026-02-01T00:00:00", alerts=1, walks=1, git_revision=None)
    (tmp_path / "paper" / "latest").symlink_to("late", target_is_directory=True)
    return tmp_path


def test_rows_are_in_the_order_of_time(results):
    frame, silent = history(results)
    told = frame[frame.detector == "PaperDetector"]
    assert told.revision.tolist() == ["aaaaaaaaaa", "source f00", "bbbbbbbbbb+"]
    assert told.tp_before_contact.tolist() == [0.25, 1.0, 0.75]
    assert told.detect_cpu_s_per_beep.tolist() == pytest.approx([0.001] * 3)
    assert told.range_error_median_m.tolist() == pytest.approx([0.004] * 3)
    assert silent == []


def test_runs_without_walks_have_no_rates_in_words(tmp_path):
    """Cause: "TP nan to nan %, TN nan to nan %." of two runs of the suite `ranging`."""
    for name, started in (("one", "2026-01-01T00:00:00"), ("two", "2026-02-01T00:00:00")):
        stored(tmp_path, name, started, alerts=0, walks=0)
        run = made_up_run(tmp_path / "paper" / name, [standing(1.5, k) for k in range(2)])
        write_atomically(run.folder / "summary.json", to_json(summary(run, variants(run))))
        write_frames(run)
    (figure,) = history_figures(history(tmp_path)[0])
    assert figure.reading == "No walks."


def test_a_walk_that_waited_for_a_compiler_is_no_change_of_cost(results):
    """Cause: all costs were added up, so that a run that compiled had eight times the report's cost of a beep."""
    path = results / "paper" / "late" / "costs.parquet"
    costs = pd.read_parquet(path)
    costs.loc[0, "detect_cpu_s"] = 60.0
    costs.to_parquet(path)
    frame, _ = history(results)
    assert frame.detect_cpu_s_per_beep.tolist() == pytest.approx([0.001] * len(frame))
    path.unlink()
    frame, _ = history(results)
    assert frame.detect_cpu_s_per_beep.isna().tolist() == [run == "late" for run in frame.run]


def test_runs_of_other_walks_are_not_compared(results):
    """A run cut by --limit would look like a jump in accuracy."""
    (figure,) = history_figures(history(results)[0])
    line = figure.panels[0].lines[0]
    assert line.y.tolist() == [25.0, 75.0]
    assert "PaperDetector: TP 25.0 to 75.0 %" in figure.reading


def test_a_run_that_says_nothing_is_named(results):
    (results / "paper" / "early" / "summary.json").unlink()
    frame, silent = history(results)
    assert [folder.name for folder in silent] == ["early"]
    assert set(frame.run) == {"late", "cut"}


@pytest.mark.parametrize(
    ("file", "changed"),
    [
        ("summary.json", {"detectors": ["PaperDetector"]}),
        ("summary.json", {"cells": "4"}),
        ("manifest.json", {"started": 2026}),
        ("manifest.json", {"git_revision": 17}),
    ],
)
def test_a_strangers_run_of_other_types_says_nothing(results, file, changed):
    """Cause: the summary's types were taken on trust, and a list of detectors ended in a traceback."""
    path = results / "paper" / "early" / file
    path.write_text(json.dumps(json.loads(path.read_text()) | changed))
    assert [folder.name for folder in history(results)[1]] == ["early"]


def test_costs_that_are_no_numbers_say_nothing(results):
    path = results / "paper" / "early" / "costs.parquet"
    costs = pd.read_parquet(path)
    costs.assign(beeps=[["many"]] * len(costs)).to_parquet(path)
    assert [folder.name for folder in history(results)[1]] == ["early"]


def test_the_command_leaves_table_and_picture(results):
    done = CliRunner().invoke(cli, ["history", str(results)], catch_exceptions=False)
    assert done.exit_code == 0
    assert "bbbbbbbbbb+" in done.output
    assert len(pd.read_csv(results / "history.csv")) == 6
    assert (results / "figures" / "history-paper-smoke-test-2018-4.png").stat().st_size > 10_000


def test_no_runs_is_an_error(tmp_path):
    with pytest.raises(ValueError, match="must be a folder with runs"):
        history(tmp_path)
