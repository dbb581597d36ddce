"""Two runs on the same walks."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.gates.comparison import compare_runs, comparison_lines, left_out
from tests.benchmarks.gated_runs import DETECTOR, LATE_M, changed, good_run, one_channel_late, run_of, votes_too_few
from tests.benchmarks.gates.verdicts import stored
from tests.benchmarks.synthetic_run import failed, walk


def test_a_run_differs_not_from_itself(tmp_path):
    run = good_run(tmp_path)
    (found,) = compare_runs(run, run)
    assert {rate: (change.lost, change.gained, change.n) for rate, change in found.rates.items()} == {
        "TP": (0, 0, 40),
        "TN": (0, 0, 40),
    }
    assert len(found.shifts) == 20
    assert all((shift.value, shift.low, shift.high) == (0.0, 0.0, 0.0) for shift in found.shifts.values())


def test_what_differs_is_found_and_starred(tmp_path):
    run = good_run(tmp_path)
    second = changed(changed(run, one_channel_late), votes_too_few)
    (found,) = compare_runs(run, second)
    assert (found.rates["TN"].lost, found.rates["TN"].gained) == (16, 0)
    assert found.shifts["approach", "path_difference_bias", "m"].value == pytest.approx(LATE_M, rel=1e-6)
    starred = [line.split(",")[0].strip() for line in comparison_lines(found) if line.endswith("*")]
    assert set(starred) == {"path_difference_bias", "range2_error", "alerts"}


def test_two_detectors_of_one_run(tmp_path):
    cells = [walk(index=k, alert_distance_m=2.0, detectors=("A", "B(x=1)")) for k in range(6)]
    for cell in cells:
        entries = cell["result"]["detectors"]
        entries["B(x=1)"] = entries["A"] | {"alert": False, "outcome": "FN"}
    run = stored(run_of(tmp_path, cells), tmp_path / "run")
    call = ["compare", str(run), str(run), "--json", "--detector", "A=B(x=1)"]
    (found,) = json.loads(CliRunner().invoke(cli, call, catch_exceptions=False).output)
    assert (found["first"], found["second"]) == ("A", "B(x=1)")
    assert found["outcome_differs"] == 0
    assert found["rates"]["TP"]["lost"] == 6
    assert found["rates"]["TP"]["points"] == -100.0


def test_runs_without_anything_in_common_are_refused(tmp_path):
    run = good_run(tmp_path)
    other = run_of(tmp_path, [walk(scene="campus", index=k, detectors=("B",)) for k in range(3)])
    with pytest.raises(ValueError, match=r"a detector in common, got \['PaperDetector'\] and \['B'\]"):
        compare_runs(run, other)
    with pytest.raises(ValueError, match="walks in common"):
        compare_runs(run, other, [(DETECTOR, "B")])
    with pytest.raises(ValueError, match=r"must be one of \['B'\], got \['C'\]"):
        compare_runs(run, other, [(DETECTOR, "C")])


def test_walks_of_another_seed_are_others_whatever_they_are_called(tmp_path):
    """Runs of two seeds were paired by label alone, and McNemar's test was made of walks that are not the same."""
    run = good_run(tmp_path)
    other = changed(run, lambda cell, k: cell["cell"].update(seed=10_000 + k))
    with pytest.raises(ValueError, match="walks in common, got none; same suite, split and seed"):
        compare_runs(run, other)
    half = changed(run, lambda cell, k: cell["cell"].update(seed=cell["cell"]["seed"] + 10_000 * (k % 4 < 2)))
    (found,) = compare_runs(run, half)
    assert {rate: change.n for rate, change in found.rates.items()} == {"TP": 20, "TN": 20}


def test_one_detector_against_several_and_no_minus_zero(tmp_path):
    """Of two pairs with the same first name only the last was compared, without a word."""
    run = good_run(tmp_path)
    both = [(DETECTOR, DETECTOR)] * 2
    assert len(compare_runs(run, run, both)) == 2
    assert not any("-0.0" in line for found in compare_runs(run, run, both) for line in comparison_lines(found))


def test_people_read_centimetres_and_degrees_and_machines_si(tmp_path):
    """The table gave ranges in m and bearings in rad, the report beside it cm and degrees."""
    run = good_run(tmp_path)
    (found,) = compare_runs(run, changed(run, one_channel_late))
    (line,) = [line for line in comparison_lines(found) if "path_difference_bias, approach" in line]
    assert f"{100.0 * LATE_M:+.3g} cm" in line
    assert not any(" rad " in line for line in comparison_lines(found))
    assert ("approach", "bearing_error", "rad") in found.shifts


def test_four_walks_are_starred_in_nothing(tmp_path):
    """Cause: of one walk the interval had no width, so that every difference was starred."""
    for walks, starred in ((4, False), (12, True)):
        run = good_run(tmp_path, walks=walks)
        (found,) = compare_runs(run, changed(run, one_channel_late))
        lines = [line for line in comparison_lines(found) if ", approach" in line]
        assert any(line.endswith("*") for line in lines) == starred


def test_few_walks_have_no_interval(tmp_path):
    """Cause: one walk had the interval "-0.286 to -0.286", as if nothing were surer."""
    for walks, said in ((1, "over 1 walk, too few"), (4, "over 4 walks, too few"), (5, " to +0 over 5 walks")):
        run = run_of(tmp_path, [walk(index=k, detectors=(DETECTOR,)) for k in range(walks)])
        (found,) = compare_runs(run, run)
        shown = [line for line in comparison_lines(found) if ", approach" in line]
        assert shown
        assert all(said in line for line in shown)


def test_walks_that_collide_in_one_run_only_are_left_out_of_quantities_too(tmp_path):
    run = good_run(tmp_path)
    second = changed(run, lambda cell, k: cell["result"]["truth"].update(collides=k != 0 and k < 40))
    (found,) = compare_runs(run, second)
    assert found.outcome_differs > 0
    assert found.shifts["approach", "candidates", ""].n == 80 - found.outcome_differs


def test_what_the_runs_do_not_share_is_said(tmp_path):
    """Cause: cells, detectors and points of one run alone were dropped without a word."""
    walks = [walk(index=k, detectors=("A", "B")) for k in range(6)]
    others = [walk(index=k, detectors=("A", "C")) for k in range(5)]
    first = stored(run_of(tmp_path, walks), tmp_path / "first")
    second = stored(run_of(tmp_path, [*others[:3], failed(others[3]), failed(others[4])]), tmp_path / "second")
    call = ["compare", str(first), str(second)]
    told = CliRunner().invoke(cli, call, catch_exceptions=False).output.splitlines()
    assert told[-2:] == [
        "left out of the first run: 3 cells that the other has not measured, the detectors B",
        "left out of the second run: 2 cells that failed, the detectors C",
    ]
    (found,) = json.loads(CliRunner().invoke(cli, [*call, "--json", "--detector", "B=C"]).output)
    assert found["left_out"]["first"] == {"cells": 3, "failed": 0, "detectors": [], "points": 0}
    alone = CliRunner().invoke(cli, ["compare", str(first), str(first)]).output
    assert "left out" not in alone
    hot = {"air.temperature_c": 40.0}
    swept = [{**one, "cell": {**one["cell"], "variant": v}} for one in walks for v in ({}, hot)]
    assert left_out(run_of(tmp_path, swept), run_of(tmp_path, walks)).points == 1
