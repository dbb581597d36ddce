"""Damage in a run's files is one named error, or a cell that counts as missing; never a traceback in a figure."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.gates.baseline import load_baseline
from benchmarks.runs.results import load_run
from benchmarks.runs.store import cell_path, cost_path, read_cell, to_json, write_cell
from tests.benchmarks.synthetic_run import walk

DIGEST = "ab" + 62 * "0"
MANIFEST = {"argv": ["run"], "suite": "a", "tier": "b", "split": "test", "seed": 0, "plan": [DIGEST]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"plan": [1]}, r"plan\.0: Input should be a valid string, got 1"),
        ({"plan": ["../../../etc/passwd"]}, r"plan\.0: String should match pattern"),
        ({"seed": "x"}, r"seed: Input should be a valid integer"),
        ({"argv": None}, r"argv: Input should be a valid list"),
        ({"versions": 3}, r"versions: Input should be a valid dict"),
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
    "change",
    [
        {"result": None},
        {"result": {"detectors": {"PaperDetector": {"alert": "yes"}}}},
        {"result": {"detectors": [1]}},
        {"label": 3},
        {"cell": {"kind": "approach"}},
        {"status": "failed"},
    ],
)
def test_a_sealed_cell_of_other_types_counts_as_missing(tmp_path: Path, change: dict[str, Any]) -> None:
    record = walk() | {"digest": DIGEST}
    path = cell_path(tmp_path, DIGEST)
    write_cell(path, to_json(record))
    assert read_cell(path, DIGEST) is not None
    write_cell(path, to_json(record | change))
    assert read_cell(path, DIGEST) is None
    (tmp_path / "manifest.json").write_text(json.dumps(MANIFEST))
    assert load_run(tmp_path).cells == ()


def test_columns_of_uneven_length_are_damage(tmp_path: Path) -> None:
    record = walk() | {"digest": DIGEST}
    record["result"]["detectors"]["PaperDetector"]["beeps"][0]["snr_db"].pop()
    write_cell(cell_path(tmp_path, DIGEST), to_json(record))
    assert read_cell(cell_path(tmp_path, DIGEST), DIGEST) is None


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
        ({"walks": [1]}, r"walks\.0: Input should be a valid string"),
        ({"collides": "10"}, r"columns must have a value for each of 1 labels"),
        ({"collides": "x"}, r"collides: String should match pattern"),
        ({"values": {"D": {"approach": {"labels": ["a"], "columns": {"snr": []}}}}}, r"must have a value for each"),
        ({"right": {"D": 1}}, r"right\.D: Input should be a valid string"),
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
