"""Damage in a run's files is one named error, never a traceback in a figure."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from benchmarks.cells.association import BEEP_COLUMNS
from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.gates.baseline import load_baseline
from benchmarks.runs.results import load_run
from benchmarks.runs.runner import run_cells
from benchmarks.runs.store import cell_path, cost_path, read_cell, to_json, write_cell
from tests.benchmarks.fake_cells import fake_plan, fake_work
from tests.benchmarks.synthetic_run import walk

DIGEST = "ab" + 62 * "0"
MANIFEST = {"argv": ["run"], "suite": "a", "tier": "b", "split": "test", "seed": 0, "plan": [DIGEST]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"plan": [1]}, r"plan\[0\]: must be a text, got 1"),
        ({"plan": ["../../../etc/passwd"]}, r"plan\[0\]: must be 64 hexadecimal digits"),
        ({"seed": "x"}, r"seed: must be a valid integer"),
        ({"argv": None}, r"argv: must be a list"),
        ({"versions": 3}, r"versions: must be a table of keys"),
    ],
)
def test_a_manifest_of_other_types_is_refused_by_field(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    """Cause: `"plan": [1]` was joined to a path: a TypeError and exit code 1."""
    (tmp_path / "manifest.json").write_text(json.dumps(MANIFEST | change))
    with pytest.raises(ValueError, match=rf"must be the manifest of a run: {message}"):
        load_run(tmp_path)


@pytest.mark.parametrize("text", ["[1]", "[" * 100_000, '{"a": ' * 100_000, "{", "9" * 5000, ""])
def test_what_is_no_json_object_is_refused(tmp_path: Path, text: str) -> None:
    """Cause: json.loads recurses over depth, and reads lists and numbers too."""
    for name in ("manifest.json", "baseline.json"):
        (tmp_path / name).write_text(text)
    for load in (lambda: load_run(tmp_path), lambda: load_baseline(tmp_path / "baseline.json")):
        with pytest.raises(ValueError, match=r"must be (a )?JSON"):
            load()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"result": None}, "a cell must have a result or an error"),
        ({"result": {"truth": {}, "detectors": {"PaperDetector": {"alert": "yes"}}}}, r"PaperDetector\.alert: must be"),
        ({"result": {"truth": {}, "detectors": [1]}}, r"result\.detectors: must be a table of keys"),
        ({"label": 3}, "label: must be a text, got 3"),
        ({"cell": {"kind": "approach"}}, r"cell\.scene: is missing"),
        ({"status": "failed"}, "a cell must have a result or an error"),
    ],
)
def test_a_sealed_cell_of_other_types_is_refused_by_field(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    """Cause: it counted as missing, so that a report of an older version's run said that nothing was measured."""
    path = cell_path(tmp_path, DIGEST)
    _hold(tmp_path, walk() | change)
    for read in (lambda: read_cell(path, DIGEST), lambda: load_run(tmp_path)):
        with pytest.raises(ValueError, match=rf"{path}' must be a cell as this version stores it: .*{message}"):
            read()


def _hold(run: Path, record: dict[str, Any]) -> None:
    write_cell(cell_path(run, DIGEST), to_json(record | {"digest": DIGEST}))
    (run / "manifest.json").write_text(json.dumps(MANIFEST))


@pytest.mark.parametrize("name", BEEP_COLUMNS)
def test_a_missing_column_is_refused_by_file_and_name(tmp_path: Path, name: str) -> None:
    """Cause: a cell without `radius_m` ended in a KeyError in the tables."""
    record = walk()
    _hold(tmp_path, record)
    assert len(load_run(tmp_path).cells) == 1
    del record["result"]["detectors"]["PaperDetector"]["beeps"][0][name]
    _hold(tmp_path, record)
    with pytest.raises(ValueError, match=rf"{DIGEST}\.json' .*columns over beeps must hold '{name}'"):
        load_run(tmp_path)


def _shortened(entry: dict[str, Any]) -> None:
    entry["beeps"][0]["snr_db"].pop()


def _half_a_beep(entry: dict[str, Any]) -> None:
    entry["beeps"][0]["beep"][1] = 0.5


def _no_count(entry: dict[str, Any]) -> None:
    entry["beeps"][0]["candidates"][0] = None


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_shortened, r"columns over beeps must be equally long, got \[3, 4\]"),
        (_half_a_beep, "column 'beep' must hold whole numbers, got 0.5"),
        (_no_count, "column 'candidates' must hold whole numbers, got None"),
        (lambda entry: entry["beeps"].pop(), "beeps of 'PaperDetector' must be told of 1 targets, got 0"),
    ],
)
def test_columns_that_cannot_be_are_refused(
    tmp_path: Path, spoil: Callable[[dict[str, Any]], object], message: str
) -> None:
    record = walk(detectors=("PaperDetector",))
    spoil(record["result"]["detectors"]["PaperDetector"])
    _hold(tmp_path, record)
    with pytest.raises(ValueError, match=message):
        load_run(tmp_path)


@pytest.mark.parametrize("name", ["targets", "radius_m", "collides"])
def test_a_truth_that_lacks_a_number_is_refused(tmp_path: Path, name: str) -> None:
    record = walk()
    del record["result"]["truth"][name]
    _hold(tmp_path, record)
    with pytest.raises(ValueError, match=rf"truth\.{name}: is missing"):
        load_run(tmp_path)


def test_a_sealed_cell_of_other_types_is_computed_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (cell,) = cells = fake_plan(1)
    assert run_cells(tmp_path, cells, work=fake_work()).complete
    digest = cell.digest(source_fingerprint())
    path = cell_path(tmp_path, digest)
    whole = path.read_bytes()
    write_cell(path, to_json({"digest": digest, "status": "ok"}))
    assert run_cells(tmp_path, cells, work=fake_work()).complete
    assert path.read_bytes() == whole
    assert "label: is missing; it is computed again" in capsys.readouterr().err


@pytest.mark.parametrize("cost", ["[1]", '{"total_s": "long"}', '{"detect_s": [1]}', "["])
def test_a_damaged_cost_is_unknown(tmp_path: Path, cost: str) -> None:
    (tmp_path / "manifest.json").write_text(json.dumps(MANIFEST))
    write_cell(cell_path(tmp_path, DIGEST), to_json(walk() | {"digest": DIGEST}))
    path = cost_path(tmp_path, DIGEST)
    path.parent.mkdir(parents=True)
    path.write_text(cost)
    assert load_run(tmp_path).costs == ({},)


@pytest.mark.parametrize(
    ("run", "message"),
    [
        ({"walks": [1]}, r"walks\[0\]: must be a text"),
        ({"collides": "10"}, r"columns must have a value for each of 1 labels"),
        ({"collides": "x"}, r"collides: must be 0 and 1 only"),
        ({"values": {"D": {"approach": {"labels": ["a"], "columns": {"snr": []}}}}}, r"must have a value for each"),
        ({"right": {"D": 1}}, r"right\.D: must be a text"),
    ],
)
def test_a_damaged_baseline_is_refused_by_field(tmp_path: Path, run: dict[str, Any], message: str) -> None:
    whole = {"source": "0", "walks": ["a"], "collides": "1", "right": {"D": "1"}, "values": {}}
    path = tmp_path / "baseline.json"
    path.write_text(json.dumps({"format": 1, "history": [], "runs": {"a/b/test/0": whole}}))
    assert load_baseline(path).runs["a/b/test/0"].right == {"D": {"a": True}}
    path.write_text(json.dumps({"format": 1, "history": [], "runs": {"a/b/test/0": whole | run}}))
    with pytest.raises(ValueError, match=rf"baseline\.json' is damaged: .*{message}"):
        load_baseline(path)
