"""Files of a run: whole or absent, and never another cell's."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.store import cell_path, read_cell, to_json, write_atomically


def test_a_cell_comes_back_as_written(tmp_path: Path) -> None:
    digest = "ab" + 62 * "0"
    path = cell_path(tmp_path, digest)
    assert path.parent.name == "ab"
    assert read_cell(path, digest) is None
    record = {"digest": digest, "status": "ok", "values": [0.1, 1e-300, 2.0 / 3.0]}
    write_atomically(path, to_json(record))
    assert read_cell(path, digest) == record


def test_numbers_that_are_not_finite_become_null() -> None:
    text = to_json({"a": [float("nan"), (float("inf"), 1.0)], "b": {"c": float("-inf")}})
    assert json.loads(text) == {"a": [None, [None, 1.0]], "b": {"c": None}}


@pytest.mark.parametrize(
    "text",
    ['{"digest": "ab', '{"digest": "cd", "status": "ok"}', '{"digest": "ab", "status": "half"}', "[]", ""],
    ids=["cut short", "another cell's", "unknown status", "no record", "empty"],
)
def test_what_is_damaged_or_another_s_is_computed_again(tmp_path: Path, text: str) -> None:
    path = tmp_path / "cell.json"
    path.write_text('{"digest": "ab", "status": "ok"}', encoding="utf-8")
    assert read_cell(path, "ab") is not None
    path.write_text(text, encoding="utf-8")
    assert read_cell(path, "ab") is None


def test_a_failed_write_leaves_the_old_file_and_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "kept.json"
    write_atomically(path, "old")

    def refuse(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr("benchmarks.store.os.replace", refuse)
    with pytest.raises(OSError, match="disk full"):
        write_atomically(path, "new")
    assert path.read_text(encoding="utf-8") == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["kept.json"]
