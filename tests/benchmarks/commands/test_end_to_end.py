"""The whole chain on one walk of every category, and on files, as a user calls it."""

from __future__ import annotations

import math

import numpy as np
import pytest
import soundfile
from click.testing import CliRunner

from benchmarks.cells.compute import compute
from benchmarks.cells.spec import Cell
from benchmarks.cli import cli, main
from benchmarks.plan.suite import load_suite
from benchmarks.runs.executors import choose_executor
from benchmarks.runs.runner import run_cells
from benchmarks.runs.store import cell_path, read_cell
from tests.benchmarks.simulated_file import assert_detected

CATEGORIES = ("wall", "dustbin", "car", "sign", "pedestrian")


def _cell(category: str, collision: bool = True, index: int = 3) -> Cell:
    suite = load_suite("paper")
    return Cell(
        kind="approach", scene="supermarket", category=category, index=index, phone="galaxy-s8-plus", seed=41,
        collision=collision, beep=suite.beep, fidelity=suite.fidelity, detectors=suite.detectors, scoring=suite.scoring,
    )  # fmt: skip


@pytest.mark.parametrize("category", CATEGORIES)
def test_one_walk_of_every_category_from_scene_to_score(category):
    result = compute(_cell(category))
    assert result["truth"]["collides"] is True
    assert math.isfinite(result["truth"]["contact_time_s"])
    for name in ("PaperDetector", "DistanceOnlyDetector"):
        entry = result["detectors"][name]
        assert entry["outcome"] in ("TP", "FN")
        beeps = entry["beeps"][0]
        assert len(beeps["beep"]) > 10
        true = np.array(beeps["true_range_m"])
        assert true[0] > true[-1]  # the walker closes in
        found = np.array(beeps["range_m"], dtype=float)
        error = np.abs(found - true)[np.isfinite(found)]
        assert (error <= 0.5).all()  # the association's gate


def test_a_wall_that_faces_the_walker_is_heard_in_most_beeps():
    beeps = compute(_cell("wall", index=2))["detectors"]["PaperDetector"]["beeps"][0]
    found = np.array([np.nan if value is None else value for value in beeps["range_m"]], dtype=float)
    heard = np.isfinite(found)
    assert heard.mean() > 0.4
    bias = np.median(found[heard] - np.array(beeps["true_range_m"])[heard])
    assert -0.45 < bias < 0.05  # range-Doppler coupling: 0.205 s times a closing speed of 0-1.6 m/s


def test_real_cells_do_not_depend_on_the_number_of_workers(tmp_path):
    cells = [_cell("dustbin"), _cell("wall", collision=False)]
    for jobs in (1, 2):
        assert run_cells(tmp_path / str(jobs), cells, choose_executor(None, jobs)).complete
    alone, together = ({p.name: p.read_bytes() for p in (tmp_path / name / "cells").rglob("*.json")} for name in "12")
    assert len(alone) == 2
    assert alone == together


def test_an_unknown_phone_is_a_failed_cell(tmp_path):
    bad = _cell("wall").model_copy(update={"phone": "nokia"})
    (digest,) = run_cells(tmp_path, [bad], retries=0).failed
    record = read_cell(cell_path(tmp_path, digest), digest)
    assert record is not None
    assert "nokia" in record["error"]


def test_simulate_then_detect(tmp_path):
    """To a WAV file; to a FLAC file as the README's commands do, `tests/docs/test_readme.py`."""
    audio, paths = tmp_path / "walk.wav", tmp_path / "paths.json"
    arguments = ["simulate", "supermarket", "--category", "wall", "--phone", "galaxy-s8-plus", "-o", str(audio)]
    done = CliRunner().invoke(cli, [*arguments, "--paths", str(paths)], catch_exceptions=False)
    assert done.exit_code == 0
    assert_detected(audio, paths)


def _complaint(monkeypatch, capsys, arguments: list[str]) -> str:
    """One line on stderr and exit code 2, as a shell would see it."""
    monkeypatch.setattr("sys.argv", ["obstaclewatch", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    return capsys.readouterr().err.strip()


def _mono(folder):
    soundfile.write(folder / "mono.wav", np.zeros(192_000), 192_000)
    return folder / "mono.wav"


def _slow(folder):
    soundfile.write(folder / "slow.wav", np.random.default_rng(0).normal(0, 0.01, (48_000, 2)), 48_000)
    return folder / "slow.wav"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["detect", "nothing.wav"], "nothing.wav"),
        (["simulate", "atlantis", "-o", "x.wav"], "atlantis"),
        (["simulate", "supermarket", "--phone", "nokia", "-o", "x.wav"], "nokia"),
        (["simulate", "supermarket", "--speed", "-1", "-o", "x.wav"], "-1.0"),
        (["simulate", "supermarket", "-o", "x.mp3"], "x.mp3"),
        (["run", "nosuite"], "nosuite"),
        (["run", "paper", "--tier", "huge"], "huge"),
        (["run", "paper", "-j", "0"], "jobs"),
        (["report", "nowhere"], "nowhere"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(monkeypatch, capsys, tmp_path, arguments, says):
    monkeypatch.chdir(tmp_path)
    line = _complaint(monkeypatch, capsys, arguments)
    assert says in line
    assert "\n" not in line
    assert list(tmp_path.iterdir()) == []


def test_mono_and_what_holds_no_beep_are_refused(monkeypatch, capsys, tmp_path):
    """Any rate is accepted that holds the beep; noise at 48 kHz holds none."""
    assert "mono.wav" in _complaint(monkeypatch, capsys, ["detect", str(_mono(tmp_path))])
    assert "no beep" in _complaint(monkeypatch, capsys, ["detect", str(_slow(tmp_path))])


def test_a_mesh_with_nan_vertices_is_refused(monkeypatch, capsys, tmp_path):
    (tmp_path / "bad.obj").write_text("v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n")
    scene = tmp_path / "scene.yaml"
    scene.write_text("name: mine\nobstacles:\n  - {name: thing, mesh: bad.obj, units: m, material: concrete}\n")
    line = _complaint(monkeypatch, capsys, ["simulate", str(scene), "-o", str(tmp_path / "x.wav")])
    assert "thing" in line or "bad.obj" in line
    assert not (tmp_path / "x.wav").exists()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["run", "paper", "--set", "detectors=[Paper"], "'detectors=[Paper':1: a value must be YAML"),
        (["run", "paper", "--tier", "smoke", "--retries", "-1"], "'--retries': -1"),
        (["run", "paper", "--tier", "smoke", "--walks", "-1"], "'--walks': -1"),
        (["run", "paper", "--tier", "smoke", "--limit", "1", "-o", "file"], "file"),
        (["baseline", "update", "run", "--reason", "x", "--baseline", "file/b.json"], "run"),
        (["gate", "run", "--seed", "-1"], "'--seed': -1"),
        (["scene", "check", "supermarket", "--seed", "-1"], "'--seed': -1"),
        (["baseline", "update", "run"], "obstaclewatch baseline update: Missing option '--reason'"),
        (["status", "run"], "must be a JSON object, got list"),
    ],
)
def test_what_cannot_be_written_read_or_meant_is_one_line_too(monkeypatch, capsys, tmp_path, arguments, says):
    """Broken YAML of --set, a folder that is a file and a manifest without a plan ended in a traceback; negative
    retries left a run folder behind, and negative walks were refused only after all cells had been computed.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "manifest.json").write_text("[]")
    line = _complaint(monkeypatch, capsys, arguments)
    assert says in line
    assert "\n" not in line
    assert {path.name for path in tmp_path.rglob("*")} == {"file", "run", "manifest.json"}
