"""`benchmarks.run`: what it says of cells that failed, and what it refuses."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import pytest

from benchmarks import run
from benchmarks.cells.compute import compute
from benchmarks.cells.spec import Cell


def called(folder: Path, **changed: Any) -> Any:
    return run("extremes", **{"labels": "slivers", "limit": 2, "out": folder} | changed)


def test_failed_cells_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cause: the frame came without a word, and without most of its columns where every cell had failed."""

    def breaks(cell: Cell) -> dict[str, Any]:
        if len(seen | {cell.label}) > sound:
            raise RuntimeError("boom\nsecond line")
        seen.add(cell.label)
        return compute(cell)

    seen: set[str] = set()
    monkeypatch.setattr("benchmarks.cells.compute.compute", breaks)
    sound = 0
    rule = (
        r"nothing was measured of 2 cells: failed: .*slivers/\d: RuntimeError: boom; 2 cells failed; their tracebacks"
    )
    with pytest.raises(RuntimeError, match=rule):
        called(tmp_path)
    sound = 1
    rule = r"not complete, of 2 cells: failed: .*slivers/\d: RuntimeError: boom; 1 cell failed; its traceback"
    with pytest.warns(RuntimeWarning, match=rule) as told:
        frame = called(tmp_path)
    assert told[0].filename == __file__
    assert sorted(frame.status) == ["failed", "ok"]
    sound = 2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert called(tmp_path).status.tolist() == ["ok", "ok"]


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"limit": 1.5}, "limit must be a whole number, 1 or more, got 1.5"),
        ({"jobs": 1.5}, "jobs must be a whole number, 1 or more, got 1.5"),
        ({"labels": 5}, "labels must be of type str or NoneType, got 5"),
        ({"out": None}, "out must be of type str or Path, got None"),
        ({"tier": ["smoke"]}, r"tier must be of type str, got \['smoke'\]"),
    ],
)
def test_arguments_of_other_types_are_refused(tmp_path: Path, changed: dict[str, Any], said: str) -> None:
    """Cause: a TypeError from deep inside, such as that a float cannot be an index."""
    with pytest.raises(ValueError, match=said):
        called(tmp_path, **changed)
