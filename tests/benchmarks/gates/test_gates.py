"""Gates: green where nothing changed, red with the metric's name where something did, never green on nothing."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy import stats

from benchmarks.cli import cli
from benchmarks.gates.baseline import baseline_of, load_baseline, run_key, save_baseline, updated
from benchmarks.gates.claims import judge_claims
from benchmarks.gates.config import Gates, gates_path, list_gates, load_gates
from benchmarks.gates.judge import judge
from benchmarks.gates.output import junit_xml, markdown
from benchmarks.gates.physics import CHECKS, judge_physics, moving, truth
from benchmarks.gates.physics.measured import Measured
from benchmarks.gates.quantities import per_walk
from benchmarks.gates.verdict import State, Verdict, exit_code
from benchmarks.runs.results import RunData
from benchmarks.runs.store import cell_path, to_json, write_cell
from benchmarks.scoring.paired import change_of, shift_of
from benchmarks.scoring.statistics import lower_bound, needed_of, upper_quantile_bound
from simulator import Air, Paths
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

QUANTITIES = {
    "range_error": 0.005, "range_bias": 0.005, "path_difference_bias": 0.0005, "bearing_error": 0.02,
    "no_estimate": 0.02, "candidates": 0.1, "snr": 0.3, "alerts": 0.01,
}  # fmt: skip
REGRESSION = Gates.model_validate(
    {
        "title": "test",
        "regression": [{"detector": DETECTOR, "approach": QUANTITIES, "standing": {"range_error": 0.001}}],
    }
)


def states(verdicts: list[Verdict]) -> dict[str, State]:
    return {verdict.name: verdict.state for verdict in verdicts}


def red(verdicts: list[Verdict]) -> list[str]:
    return [verdict.name for verdict in verdicts if verdict.state is State.FAILED]


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

    def deaf(cell, _):
        beeps = cell["result"]["detectors"][DETECTOR]["beeps"][0]
        beeps["range_m"] = [None] * len(beeps["range_m"])

    verdicts = judge(changed(run, deaf), REGRESSION, updated(None, [run], "first"))
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


def claim(**values) -> Gates:
    return Gates.model_validate({"title": "test", "claims": [{"detector": DETECTOR, **values}]})


def test_a_point_estimate_equal_to_the_claim_does_not_pass(tmp_path):
    run = good_run(tmp_path)  # 36 of 40 in time
    (verdict,) = judge_claims(run, claim(rate="TP", at_least=0.9))
    assert verdict.state is State.FAILED
    assert "36 of 40 (90.0 %)" in verdict.message
    assert "40 of 40 needed" in verdict.message
    bound = stats.beta.ppf(0.05, 36, 5)  # Clopper and Pearson's closed form
    assert judge_claims(run, claim(rate="TP", at_least=bound - 1e-6))[0].state is State.PASSED
    assert judge_claims(run, claim(rate="TP", at_least=bound + 1e-6))[0].state is State.FAILED


def test_claims_look_at_their_own_walks_and_split(tmp_path):
    run = good_run(tmp_path)
    for verdict, n in (
        (judge_claims(run, claim(rate="TN", at_least=0.5, scene="supermarket"))[0], 40),
        (judge_claims(run, claim(rate="TN", at_least=0.5, scene="campus"))[0], 0),
    ):
        assert verdict.n == n
        assert verdict.state is (State.PASSED if n else State.UNMEASURED)
    dev = RunData(run.folder, run.manifest | {"split": "dev"}, run.cells)
    (verdict,) = judge_claims(dev, claim(rate="TN", at_least=0.5))
    assert verdict.state is State.UNMEASURED
    assert "claimed on split test, the run is dev" in verdict.message


def test_a_median_is_claimed_by_its_bound(tmp_path):
    run = good_run(tmp_path)
    values = np.sort(list(per_walk(run, DETECTOR, "approach", "range_error").values()))
    (verdict,) = judge_claims(run, claim(quantity="range_error", at_most=float(np.median(values))))
    assert verdict.state is State.FAILED
    (verdict,) = judge_claims(run, claim(quantity="range_error", at_most=float(values[47])))
    assert verdict.state is State.PASSED
    (verdict,) = judge_claims(run, claim(quantity="range_error", kind="standing", standing_range_m=3.0, at_most=1.0))
    assert verdict.state is State.UNMEASURED


@pytest.mark.parametrize("n", [1, 5, 40, 300])
@pytest.mark.parametrize("share", [0.5, 0.9, 0.946])
def test_the_count_needed_is_the_least(n, share):
    needed = needed_of(n, share)
    reach = [k for k in range(n + 1) if lower_bound(k, n) >= share]
    assert needed == (reach[0] if reach else None)


def test_an_upper_bound_of_a_median_covers_it_19_times_in_20():
    rng = np.random.default_rng(4)
    covered = [upper_quantile_bound(rng.exponential(size=25), 0.5) >= np.log(2.0) for _ in range(2000)]
    exact = stats.binom.cdf(stats.binom.ppf(0.95, 25, 0.5), 25, 0.5)
    assert exact >= 0.95
    assert np.mean(covered) == pytest.approx(exact, abs=0.015)
    assert np.isnan(upper_quantile_bound([1.0, 2.0], 0.5))


def test_change_and_shift_pair_the_same_walks():
    before, now = {"a": True, "b": True, "c": False, "x": True}, {"a": False, "b": True, "c": True, "y": False}
    found = change_of(before, now)
    assert (found.lost, found.gained, found.n, found.loss_points) == (1, 1, 3, 0.0)
    shift = shift_of({"a": 1.0, "b": 5.0, "c": np.nan}, {"a": 1.5, "b": 5.5, "c": 2.0}, np.median)
    assert (shift.value, shift.low, shift.high, shift.n, shift.before, shift.now) == (0.5, 0.5, 0.5, 2, 2, 3)


def test_the_late_channel_is_the_geometry(tmp_path):
    run = good_run(tmp_path)
    shift = shift_of(
        per_walk(run, DETECTOR, "approach", "path_difference_bias"),
        per_walk(changed(run, one_channel_late), DETECTOR, "approach", "path_difference_bias"),
        np.median,
    )
    assert shift.value == pytest.approx(LATE_M, rel=1e-9)


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


def test_nothing_is_not_green():
    assert exit_code([]) == 4
    good, bad = Verdict.of("g", "n", True, "", 1), Verdict.of("g", "n", False, "", 1)
    none = Verdict.unmeasured("g", "n", "")
    assert [exit_code(found) for found in ([good], [good, none], [none, bad], [bad])] == [0, 4, 1, 1]
    assert exit_code([good], complete=False) == 3


def test_physics_is_exact_and_a_check_without_echoes_measured_nothing(monkeypatch):
    gates = load_gates(gates_path("project"))
    quick = {
        name: at_most
        for name, at_most in gates.physics.items()
        if not any(slow in name for slow in ("deviation", "moving", "extremes"))
    }
    quick |= {"range_deviation_30db": gates.physics["range_deviation_30db"]}
    assert len(quick) == 8
    assert [v.state for v in judge_physics(quick, seed=3)] == [State.PASSED] * len(quick)
    monkeypatch.setitem(CHECKS, "motion", lambda _: Measured(float("nan"), "relative", 0))
    assert judge_physics({"motion": 1.0})[0].state is State.UNMEASURED


def _nan_late(monkeypatch, owner, name, change):
    """What `owner.name` returns, changed after its first call."""
    real, calls = getattr(owner, name), []

    def late(*arguments, **named):
        calls.append(name)
        found = real(*arguments, **named)
        return change(found) if len(calls) > 2 else found

    monkeypatch.setattr(owner, name, late)


@pytest.mark.parametrize(
    ("check", "owner", "name", "change"),
    [
        ("reciprocity", Paths, "transfer_function", lambda found: np.nan * found),
        ("translation", Paths, "transfer_function", lambda found: np.nan * found),
        ("motion", moving, "to_rate", lambda found: np.nan * found),
        ("truth", truth, "ground_truth", lambda found: replace(found, range_m=np.nan * found.range_m)),
    ],
)
def test_physics_that_is_no_number_is_not_green(monkeypatch, check, owner, name, change):
    """Cause: max(worst, NaN) is `worst`, so that a check with a NaN after its first comparison passed."""
    _nan_late(monkeypatch, owner, name, change)
    assert judge_physics({check: 1.0})[0].state is State.UNMEASURED


def test_a_rate_that_cannot_fall_for_certain_is_not_green(tmp_path):
    """Cause: with 6 walks right in the baseline all of them could be lost at McNemar's p of 0.03, and 0.01 is red."""
    few = changed(good_run(tmp_path), lambda cell, k: k > 11 and _alert(cell, False))
    verdicts = states(judge(few, REGRESSION, updated(None, [few], "first")))
    assert verdicts["PaperDetector TP"] is State.UNMEASURED
    assert verdicts["PaperDetector TN"] is State.PASSED


def _alert(cell, alert):
    if cell["cell"]["kind"] == "approach":
        outcomes = {(True, True): "TP", (True, False): "FN", (False, True): "FP", (False, False): "TN"}
        found = outcomes[cell["result"]["truth"]["collides"], alert]
        cell["result"]["detectors"][DETECTOR] |= {"alert": alert, "outcome": found, "alert_distance_m": None}


def test_a_cut_run_replaces_no_baseline_of_all_walks(tmp_path):
    """Cause: its key was that of the whole run, so that 117 walks were replaced by the one of `--limit 1`."""
    whole = good_run(tmp_path)
    cut = RunData(
        whole.folder, whole.manifest | {"argv": ["run", "paper", "--limit", "1"], "plan": ["0" * 64]}, whole.cells[:1]
    )
    both = updated(updated(None, [whole], "first"), [cut], "second")
    assert sorted(both.runs) == ["paper/smoke/test/2018", "paper/smoke/test/2018 --limit 1"]


def test_claims_count_a_walk_of_a_sweep_once(tmp_path):
    """Cause: one walk at 60 points of a sweep counted as 60 walks."""
    cells = list(good_run(tmp_path).cells)
    swept = [{**cell, "cell": cell["cell"] | {"variant": {"name": name}}} for name in ("one", "two") for cell in cells]
    assert judge_claims(run_of(tmp_path, swept), claim(rate="TP", at_least=0.5))[0].n == 40


def test_wrong_physics_is_red(monkeypatch):
    """Absorption off by a hundredth is 0.006 dB/m."""
    real = Air.absorption_db_m
    monkeypatch.setattr(Air, "absorption_db_m", lambda air, f: 1.01 * real(air, f))
    (verdict,) = judge_physics({"air_absorption": 1e-3})
    assert verdict.state is State.FAILED
    assert "air_absorption: worst" in verdict.message


def test_outputs_say_the_same(tmp_path):
    verdicts = [
        Verdict.of("regression", "D <TN>", False, 'lost "half" & more', 40),
        Verdict.of("claim", "D TP", True, "fine", 9),
        Verdict.unmeasured("physics", "wall", "no echo"),
    ]
    root = ElementTree.fromstring(junit_xml("title", verdicts).partition("\n")[2])
    assert (root.get("tests"), root.get("failures"), root.get("errors")) == ("3", "1", "1")
    assert root.findall("testcase")[0].find("failure").get("message") == 'lost "half" & more'
    text = markdown("title", verdicts, 1)
    assert text.index("**RED**") < text.index("| green |")
    assert text.count("\n| ") == 5 - 1


MEDIAN = "title: x\nclaims: [{detector: D"


@pytest.mark.parametrize("name", list_gates())
def test_shipped_gates_are_valid(name):
    assert load_gates(gates_path(name)).title


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("title: x\n", "must hold claims, regression or physics"),
        ("title: x\nphysics: {gravity: 1}\n", "physics checks must be among .*gravity"),
        ("title: x\nclaims: [{rate: TP, at_least: 0.9}]\n", "must name its detector"),
        ("title: x\nclaims: [{detector: D, rate: TP, at_least: 94.6}]\n", "at_least"),
        ("title: x\nregression: [{detector: D, approach: {speed: 1}}]\n", "a quantity must be one of .*'speed'"),
        ("title: [x\n", "must be YAML"),
        (
            f"{MEDIAN}, quantity: range_eror, at_most: 1}}]",
            r"claims\[0\].quantity: a quantity must be one of .*range_eror",
        ),
        (f"{MEDIAN}, quantity: snr, at_most: -1}}]", r"claims\[0\].at_most: must be greater than 0, got -1"),
        (
            f"{MEDIAN}, quantity: snr, at_most: 1, clear_cut: yes}}]",
            r"clear_cut: is not a field here; there are \['at_mo",
        ),
        (f"{MEDIAN}, at_most: 1}}]", r"claims\[0\].quantity: is missing$"),
        (f"{MEDIAN}}}]", r"claims\[0\]: must be a mapping with a rate or a quantity, got"),
        ("title: x\nclaims: [5]", r"claims\[0\]: must be a mapping with a rate or a quantity, got 5"),
        (
            f"{MEDIAN}, quantity: snr, at_most: 1, standing_range_m: 3}}]",
            "standing_range_m must be of kind 'standing', got 3",
        ),
        (f"{MEDIAN}, rate: TX, at_least: 0.9}}]", r"claims\[0\].rate: must be 'TP' or 'TN', got 'TX'"),
        (f"{MEDIAN}, rate: TN, at_least: 0.9, left_m: 0.5}}]", r"must not be given for TN, .* got \{'left_m': 0.5\}"),
        (f"{MEDIAN}, rate: TN, at_least: 0.9, at_tnr: 0.9}}]", r"must not be given for TN, .* got \{'at_tnr': 0.9\}"),
        (
            f"{MEDIAN}, rate: TP, at_least: 0.9, least_index_db: .nan}}]",
            "least_index_db: must be a finite number, got nan",
        ),
        (
            "title: x\nregression: [{detector: D, rates: []}]",
            "a regression must watch rates or quantities, got none for D",
        ),
    ],
)
def test_gates_files_that_cannot_be_are_refused(tmp_path, text, says):
    (tmp_path / "gates.yaml").write_text(text)
    with pytest.raises(ValueError, match=says):
        load_gates(tmp_path / "gates.yaml")


def stored(run: RunData, folder: Path) -> Path:
    """The run as files, as `obstaclewatch run` leaves it."""
    folder.mkdir()
    (folder / "manifest.json").write_text(to_json(run.manifest))
    for digest, cell in zip(run.manifest["plan"], run.cells, strict=False):
        write_cell(cell_path(folder, digest), to_json(cell | {"digest": digest}))
    return folder


def test_the_command_line_from_baseline_to_red(tmp_path):
    gates = tmp_path / "gates.yaml"
    gates.write_text(to_json(REGRESSION.model_dump(mode="json") | {"baseline": "kept/b.json"}))
    run = good_run(tmp_path)
    good, bad = stored(run, tmp_path / "good"), stored(changed(run, one_channel_late), tmp_path / "bad")
    empty = stored(run_of(tmp_path, []), tmp_path / "empty")
    (empty / "manifest.json").write_text(to_json(run.manifest))

    def call(*arguments: str):
        return CliRunner().invoke(cli, [*arguments, "--gates", str(gates)], catch_exceptions=False)

    assert call("baseline", "update", str(good), "--reason", "first").exit_code == 0
    assert "first" in call("baseline", "history").output
    assert call("gate", str(good)).exit_code == 0
    failed = call("gate", str(bad))
    assert failed.exit_code == 1
    assert "RED" in failed.output
    assert "path_difference_bias" in failed.output
    assert json.loads((bad / "gate.json").read_text())["exit_code"] == 1
    assert "path_difference_bias" in (bad / "junit.xml").read_text()
    assert "path_difference_bias" in (bad / "gate.md").read_text()
    nothing = call("gate", str(empty))
    assert nothing.exit_code == 4
    assert "the run holds no measured cell" in nothing.stderr
    (tmp_path / "kept" / "b.json").write_text('{"format": 0}')
    old = call("gate", str(good))
    assert old.exit_code == 4
    assert "must have format 1, got 0" in old.stderr


def test_an_incomplete_run_is_neither_green_nor_red(tmp_path):
    gates = tmp_path / "gates.yaml"
    gates.write_text(to_json({"title": "one", "physics": {"air_absorption": 0.001}}))
    run = good_run(tmp_path)
    part = stored(RunData(run.folder, run.manifest, run.cells[:40]), tmp_path / "part")
    done = CliRunner().invoke(cli, ["gate", str(part), "--gates", str(gates)])
    assert done.exit_code == 3
    assert "incomplete: 40 good cells of 86" in done.stderr


def test_status_counts_and_says_how_to_go_on(tmp_path):
    run = good_run(tmp_path)
    whole = stored(run, tmp_path / "whole")
    part = stored(RunData(run.folder, run.manifest, run.cells[:40]), tmp_path / "part")
    done = CliRunner().invoke(cli, ["status", str(whole)], catch_exceptions=False)
    assert (done.exit_code, done.output) == (0, "86 planned, 86 ok, 0 failed, 0 missing\n")
    half = CliRunner().invoke(cli, ["status", str(part), "--json"], catch_exceptions=False)
    assert half.exit_code == 3
    assert json.loads(half.output)["missing"] == 46
    text = CliRunner().invoke(cli, ["status", str(part)], catch_exceptions=False).output
    assert "run paper --tier smoke --set scoring.gate_m=0.4" in text
