"""Regression against a baseline: green where nothing changed, red with the name of what did."""

from __future__ import annotations

import re

import numpy as np
import pytest

from benchmarks.gates.baseline import load_baseline, save_baseline, updated
from benchmarks.gates.judge import judge
from benchmarks.gates.quantities import per_walk, walk_tables
from benchmarks.gates.verdict import State, exit_code
from benchmarks.scoring.paired import change_of, shift_of
from tests.benchmarks.gated_runs import (
    DETECTOR,
    LATE_M,
    changed,
    good_run,
    one_channel_late,
    run_of,
    threshold_too_high,
    votes_too_few,
)
from tests.benchmarks.gates.verdicts import QUANTITIES, REGRESSION, red, states


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_untouched_is_green(tmp_path, seed):
    run = good_run(tmp_path, seed)
    save_baseline(tmp_path / "b.json", updated(None, [run], "first"))
    verdicts = judge(run, REGRESSION, load_baseline(tmp_path / "b.json"))
    assert len(verdicts) == 2 + len(QUANTITIES) + 1
    assert set(states(verdicts).values()) == {State.PASSED}
    assert exit_code(verdicts) == 0


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    ("mistake", "metrics"),
    [
        (one_channel_late, {"PaperDetector path_difference_bias, approach"}),
        (threshold_too_high, {"PaperDetector candidates, approach", "PaperDetector no_estimate, approach"}),
        (votes_too_few, {"PaperDetector TN", "PaperDetector alerts, approach"}),
    ],
)
def test_a_mistake_turns_its_own_metric_red(tmp_path, seed, mistake, metrics):
    run = good_run(tmp_path, seed)
    verdicts = judge(changed(run, mistake), REGRESSION, updated(None, [run], "first"))
    assert set(red(verdicts)) == metrics
    assert exit_code(verdicts) == 1
    assert all(verdict.name in verdict.message for verdict in verdicts)


def test_what_gets_better_is_no_loss(tmp_path):
    run = good_run(tmp_path)

    def nearer(cell, _):
        beeps = cell["result"]["detectors"][DETECTOR]["beeps"][0]
        beeps["bearing_rad"] = beeps["true_bearing_rad"]

    assert red(judge(changed(run, nearer), REGRESSION, updated(None, [run], "first"))) == []


def test_lost_estimates_are_red_even_without_a_pair(tmp_path):
    run = good_run(tmp_path)
    deaf = changed(run, lambda cell, _: _without_estimates(cell))
    verdicts = judge(deaf, REGRESSION, updated(None, [run], "first"))
    (text,) = [v.message for v in verdicts if v.name == "PaperDetector range_error, approach"]
    assert "PaperDetector range_error, approach" in red(verdicts)
    assert "80 walks had an estimate, now none has" in text


@pytest.mark.parametrize(
    ("baseline_run", "run", "says"),
    [
        (good_run, None, "no baseline was given"),
        (
            lambda folder: good_run(folder, seed=7),
            good_run,
            r"holds \['paper/smoke/test/7'\], not the run's",
        ),
        (
            good_run,
            lambda folder: run_of(folder, list(good_run(folder).cells)[5:]),
            "5 walks of the baseline are not in",
        ),
        (good_run, lambda folder: changed(good_run(folder), _turn_truth), "40 walks collide here and not in"),
    ],
    ids=["none", "another seed", "a part", "other truth"],
)
def test_what_cannot_be_compared_measured_nothing(tmp_path, baseline_run, run, says):
    before = None if run is None else updated(None, [baseline_run(tmp_path)], "first")
    verdicts = judge((run or good_run)(tmp_path), REGRESSION, before)
    assert [verdict.state for verdict in verdicts] == [State.UNMEASURED]
    assert exit_code(verdicts) == 4
    assert re.search(says, verdicts[0].message)


def _turn_truth(cell, k):
    if cell["cell"]["kind"] == "approach" and k % 2 == 1:
        cell["result"]["truth"]["collides"] = True


def test_change_and_shift_pair_the_same_walks():
    before, now = {"a": True, "b": True, "c": False, "x": True}, {"a": False, "b": True, "c": True, "y": False}
    found = change_of(before, now)
    assert (found.lost, found.gained, found.n, found.loss_points) == (1, 1, 3, 0.0)
    shift = shift_of({"a": 1.0, "b": 5.0, "c": np.nan}, {"a": 1.5, "b": 5.5, "c": 2.0}, np.median)
    assert (shift.value, shift.low, shift.high, shift.n, shift.before, shift.now) == (0.5, 0.5, 0.5, 2, 2, 3)


def test_the_late_channel_is_the_geometry(tmp_path):
    run = good_run(tmp_path)
    shift = shift_of(
        per_walk(walk_tables(run, DETECTOR, "approach"), "path_difference_bias"),
        per_walk(walk_tables(changed(run, one_channel_late), DETECTOR, "approach"), "path_difference_bias"),
        np.median,
    )
    assert shift.value == pytest.approx(LATE_M, rel=1e-9)


def test_a_rate_that_cannot_fall_for_certain_is_not_green(tmp_path):
    """Cause: with 6 walks right in the baseline all of them could be lost at McNemar's p of 0.03, and 0.01 is red."""
    few = changed(good_run(tmp_path), lambda cell, k: k > 11 and _alert(cell, False))
    verdicts = states(judge(few, REGRESSION, updated(None, [few], "first")))
    assert verdicts["PaperDetector TP"] is State.UNMEASURED
    assert verdicts["PaperDetector TN"] is State.PASSED


@pytest.mark.parametrize(("walks", "state"), [(1, State.UNMEASURED), (2, State.FAILED)])
def test_one_walk_certifies_no_shift(tmp_path, walks, state):
    """Cause: the interval of one walk has no width, so that a shift was certain from one difference."""
    few = changed(good_run(tmp_path), lambda cell, k: k >= walks and _without_estimates(cell))
    verdicts = states(judge(changed(few, one_channel_late), REGRESSION, updated(None, [few], "first")))
    assert verdicts["PaperDetector path_difference_bias, approach"] is state


def test_estimates_lost_on_all_but_a_few_walks_are_red(tmp_path):
    """Cause: with a pair on 3 of 80 walks left the gate was green, if those three had not moved."""
    run = good_run(tmp_path)
    almost_deaf = changed(run, lambda cell, k: k >= 3 and _without_estimates(cell))
    verdicts = judge(almost_deaf, REGRESSION, updated(None, [run], "first"))
    (text,) = [v.message for v in verdicts if v.name == "PaperDetector range_error, approach"]
    assert "PaperDetector range_error, approach" in red(verdicts)
    assert "80 walks had an estimate, now only 3" in text


def _without_estimates(cell):
    beeps = cell["result"]["detectors"][DETECTOR]["beeps"][0]
    beeps["range_m"] = [None] * len(beeps["range_m"])


def _alert(cell, alert):
    if cell["cell"]["kind"] == "approach":
        outcomes = {(True, True): "TP", (True, False): "FN", (False, True): "FP", (False, False): "TN"}
        found = outcomes[cell["result"]["truth"]["collides"], alert]
        cell["result"]["detectors"][DETECTOR] |= {"alert": alert, "outcome": found, "alert_distance_m": None}
