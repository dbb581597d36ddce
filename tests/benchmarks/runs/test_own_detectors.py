"""What a detector of one's own may do to a run: its cell fails with the reason, and nothing else does."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.cells.compute import compute
from benchmarks.cells.detectors import detector_class, parse_detector
from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.runs.executors.work import Done, done_by

CODE = """
import sys
from dataclasses import replace

import numpy as np

from obstaclewatch import PaperDetector


class Exits(PaperDetector):
    def stream(self, recording):
        sys.exit(0)


class Forces(PaperDetector):
    def stream(self, recording):
        recording.samples.setflags(write=True)
        recording.samples[:, ::2] *= 0.5
        return super().stream(recording)


class Writes(PaperDetector):
    def stream(self, recording):
        recording.samples[:, ::2] *= 0.5
        return super().stream(recording)


class Short(PaperDetector):
    def stream(self, recording):
        return list(super().stream(recording))[:3]


class Decides(PaperDetector):
    changes = {}

    def process(self, block, time_s=None):
        found = super().process(block, time_s)
        changes = {name: change(found) for name, change in self.changes.items()}
        return replace(found, decision=replace(found.decision, alert=True, **changes))


class Single(Decides):
    changes = {"time_s": lambda found: np.float32(found.time_s), "range_m": lambda found: np.float32(2.0)}


class Far(Decides):
    changes = {"range_m": lambda found: 1e19}


class Sure(Decides):
    changes = {"collision_probability": lambda found: 7.0}


class Early(Decides):
    changes = {"time_s": lambda found: -1e6}


class Late(Decides):
    changes = {"time_s": lambda found: 1e9}
"""


@pytest.fixture
def judged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "own_for_a_test.py").write_text(CODE)
    monkeypatch.syspath_prepend(tmp_path)

    def run(name: str) -> Done:
        suite = load_suite("paper", [f"detectors=['own_for_a_test:{name}']"])
        cell = next(cell for cell in plan_cells(suite, "smoke") if cell.label == "supermarket/sign/0")
        return done_by(cell, source_fingerprint(), compute)

    return run


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("Exits", "SystemExit: 0"),
        ("Writes", "ValueError: output array is read-only"),
        ("Forces", "a detector must leave the recording as it is"),
        ("Short", "ValueError: stream must yield one Detection a beep, in order: 46, got 3"),
        ("Far", "alert_range_m: must be less than or equal to 1"),
        ("Sure", "collision_probability of a decision must be 0 to 1, got 7.0"),
        ("Early", "time_s of a decision must be within the recording's"),
        ("Late", "time_s of a decision must be within the recording's"),
    ],
)
def test_a_cell_fails_with_the_reason(judged, name: str, reason: str) -> None:
    """Causes: an exit ended the run with code 0 and nothing in it; a recording that was written into gave the next
    detector no beep; and what a run cannot store ended it, or made its folder unreadable."""
    done = judged(name)
    assert not done.ok
    assert reason in json.loads(done.record)["error"]


def test_numbers_of_single_precision_are_numbers(judged) -> None:
    done = judged("Single")
    assert done.ok
    assert json.loads(done.record)["result"]["detectors"]["Single"]["alert_range_m"] == 2.0


def test_a_module_that_cannot_be_read_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cause: its SyntaxError was said to be a defect of this program."""
    (tmp_path / "broken_for_a_test.py").write_text("def (")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ValueError, match="'broken_for_a_test' cannot be imported: SyntaxError"):
        detector_class(parse_detector("broken_for_a_test:Mine"))


@pytest.mark.parametrize(
    ("setting", "rule"),
    [
        ("tiers={'../evil': {fraction: 0.1}}", "tiers"),
        ("standing.range_m=[.inf]", "finite"),
        ("standing.gate_m=.inf", "finite"),
        (f"standing.counts={{wall: 1{'0' * 400}}}", "less than or equal to 1000000000"),
    ],
)
def test_plans_that_nothing_can_run_are_refused(setting: str, rule: str) -> None:
    with pytest.raises(ValueError, match=rule):
        load_suite("paper", [setting])
