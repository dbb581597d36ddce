"""Baselines come back as they were stored, keep their history, and are refused where they cannot serve."""

from __future__ import annotations

import pytest

from benchmarks.gates.baseline import baseline_of, load_baseline, run_key, save_baseline, updated
from benchmarks.runs.results import RunData
from tests.benchmarks.gated_runs import DETECTOR, good_run, run_of


def test_a_baseline_comes_back_and_keeps_its_history(tmp_path):
    first, second = good_run(tmp_path, 1), good_run(tmp_path, 2)
    save_baseline(tmp_path / "b.json", updated(None, [first], "first"))
    save_baseline(tmp_path / "b.json", updated(load_baseline(tmp_path / "b.json"), [second], "another seed"))
    read = load_baseline(tmp_path / "b.json")
    assert [entry["reason"] for entry in read.history] == ["first", "another seed"]
    assert read.history[1]["runs"] == {run_key(second): {DETECTOR: "TP 36/40, TN 36/40"}}
    for run in (first, second):
        expected, found = baseline_of(run), read.runs[run_key(run)]
        assert found.collides == expected.collides
        assert found.right == expected.right
        for label, value in expected.values[DETECTOR]["approach"]["range_error"].items():
            assert found.values[DETECTOR]["approach"]["range_error"][label] == pytest.approx(value, rel=1e-5)
    assert (tmp_path / "b.json").stat().st_size < 60_000


def test_baselines_that_cannot_serve_are_refused(tmp_path):
    run = good_run(tmp_path)
    with pytest.raises(ValueError, match="with a reason"):
        updated(None, [run], "  ")
    with pytest.raises(ValueError, match="runs of different suite, tier, split or seed"):
        updated(None, [run, run], "both")
    part = RunData(run.folder, run.manifest, run.cells[:-1])
    with pytest.raises(ValueError, match="whole run, got 85 good cells of 86"):
        updated(None, [part], "half")
    with pytest.raises(ValueError, match="different labels"):
        updated(None, [run_of(tmp_path, [*run.cells, run.cells[0]])], "twice")
    (tmp_path / "b.json").write_text('{"format": 1, "runs": {"a": 3}, "history": []}')
    with pytest.raises(ValueError, match=r"b\.json' is damaged"):
        load_baseline(tmp_path / "b.json")


def test_a_cut_run_replaces_no_baseline_of_all_walks(tmp_path):
    """Cause: its key was that of the whole run, so that 117 walks were replaced by the one of `--limit 1`."""
    whole = good_run(tmp_path)
    cut = RunData(
        whole.folder, whole.manifest | {"argv": ["run", "paper", "--limit", "1"], "plan": ["0" * 64]}, whole.cells[:1]
    )
    both = updated(updated(None, [whole], "first"), [cut], "second")
    assert sorted(both.runs) == ["paper/smoke/test/2018", "paper/smoke/test/2018 --limit 1"]
