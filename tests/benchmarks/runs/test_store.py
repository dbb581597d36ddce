"""Files of a run: whole or absent, and never another cell's."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.runs.store import cell_path, point_to, read_cell, to_json, write_atomically, write_cell

DIGEST = "ab" + 62 * "0"


def stored(**result: object) -> dict[str, object]:
    """A record that holds no walk."""
    cell = {"kind": "numerics", "scene": "a", "category": "b", "phone": "ideal", "index": 0, "seed": 0, "range_m": None}
    return {
        "digest": DIGEST,
        "status": "ok",
        "label": "a",
        "cell": cell,
        "result": {"truth": {}, "detectors": {}} | result,
        "error": None,
    }


def test_a_cell_comes_back_as_written(tmp_path: Path) -> None:
    path = cell_path(tmp_path, DIGEST)
    assert path.parent.name == "ab"
    assert read_cell(path, DIGEST) is None
    record = stored(values=[0.1, 1e-300, 2.0 / 3.0])
    write_cell(path, to_json(record))
    assert json.loads(path.read_text(encoding="utf-8")).keys() == {"sha256", *record}
    assert read_cell(path, DIGEST) == record


def test_numbers_that_are_not_finite_become_null() -> None:
    text = to_json({"a": [float("nan"), (float("inf"), 1.0)], "b": {"c": float("-inf")}})
    assert json.loads(text) == {"a": [None, [None, 1.0]], "b": {"c": None}}


def test_a_change_of_any_character_is_found(tmp_path: Path) -> None:
    path = tmp_path / "cell.json"
    write_cell(path, to_json(stored(x=[1.5])))
    whole = path.read_text(encoding="utf-8")
    assert read_cell(path, DIGEST) is not None
    for k, character in enumerate(whole):
        path.write_text(whole[:k] + chr(ord(character) ^ 1) + whole[k + 1 :], encoding="utf-8")
        assert read_cell(path, DIGEST) is None
        path.write_text(whole[:k], encoding="utf-8")
        assert read_cell(path, DIGEST) is None


@pytest.mark.parametrize(
    "record",
    [{"digest": "cd", "status": "ok"}, {"digest": "ab", "status": "half"}, {"status": "ok"}],
    ids=["another cell's", "unknown status", "no digest"],
)
def test_what_is_another_s_is_computed_again(tmp_path: Path, record: dict[str, str]) -> None:
    path = tmp_path / "cell.json"
    write_cell(path, to_json(record))
    assert read_cell(path, DIGEST) is None


def test_a_link_points_to_the_newest(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        point_to(tmp_path / name, tmp_path / "latest")
        assert (tmp_path / "latest").resolve() == tmp_path / name
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["latest", "one", "two"]


def test_a_failed_write_leaves_the_old_file_and_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "kept.json"
    write_atomically(path, "old")

    def refuse(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr("benchmarks.runs.store.os.replace", refuse)
    with pytest.raises(OSError, match="disk full"):
        write_atomically(path, "new")
    assert path.read_text(encoding="utf-8") == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["kept.json"]
