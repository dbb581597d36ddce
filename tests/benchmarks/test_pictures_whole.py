"""A picture or page that cannot be written leaves the one that was there, and nothing half beside it."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.echogram import Columns, draw_echogram
from obstaclewatch import BeepDesign, Detection, Flag, Recording
from obstaclewatch.detection import COLUMNS, Decision
from scenes.preview.page import write_page
from scenes.preview.pictures import preview_scene
from simulator import Scene

BEEP = BeepDesign()


def echogram(path: Path) -> None:
    """Of one beep and nothing around it."""
    none = np.empty(0)
    decision = Decision(False, 0.0, np.nan, np.nan, 0)
    one = Detection(
        **dict.fromkeys(COLUMNS, none), index=0, time_s=0.0, collides=np.empty(0, dtype=bool),
        flags=np.empty(0, int), beep_flags=Flag.NONE, decision=decision,
    )  # fmt: skip
    silence = np.zeros((2, 2 * BEEP.period_samples), dtype=np.float32)
    silence[:, : BEEP.replica().size] = BEEP.replica()
    columns = Columns([one])
    draw_echogram([Recording(silence, BEEP.sample_rate_hz)], BEEP, "nothing", columns, path)


def page(path: Path) -> None:
    write_page({"data": [], "layout": {"title": {"text": "empty"}}, "frames": []}, path)


def plan(path: Path) -> None:
    preview_scene(Scene([]), path)


@pytest.mark.parametrize(("write", "name"), [(plan, "plan.png"), (page, "page.html"), (echogram, "echogram.png")])
def test_what_was_there_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Callable[[Path], None], name: str
) -> None:
    """Cause: they were written in their place, so a full disk left half a picture where there had been a whole one."""

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    (tmp_path / name).write_bytes(b"old")
    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", full)
        with pytest.raises(OSError, match="No space"):
            write(tmp_path / name)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == {name: b"old"}
    write(tmp_path / name)
    assert (tmp_path / name).stat().st_size > 1000
