"""A stream that leaves beeps out is no result: every score would be a share of what it chose to yield."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.cells.stream_contract import detections_of
from obstaclewatch import BeepDesign, Detection, Flag, NoBeepError, PaperDetector, PhoneGeometry, Recording

BEEP = BeepDesign(sample_rate_hz=48_000.0)
PHONE = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
BEEPS, LATE_S = 12, 0.03


def beeps(start_s: float = 0.0, silent: slice = slice(0, 0)) -> Recording:
    """Twelve periods with the direct sound alone, from some instant on, of which some samples are zeros."""
    time_s = np.arange(BEEPS * BEEP.period_samples) / BEEP.sample_rate_hz - start_s
    sound = np.where(time_s >= 0.0, 0.1 * BEEP.waveform(np.mod(time_s, BEEP.period_s)), 0.0)
    sound[silent] = 0.0
    return Recording(np.stack([sound, sound]), BEEP.sample_rate_hz)


RECORDING = beeps()
FOUND = list(PaperDetector(BEEP, PHONE).stream(RECORDING))


def judged(stream: Callable[[Recording], Any], recording: Recording = RECORDING) -> tuple[list[Detection], bool]:
    return detections_of(SimpleNamespace(stream=stream), BEEP, recording)


def lost(detection: Detection) -> Detection:
    return replace(detection, beep_flags=Flag.NO_BEEP)


def shifted(found: Iterable[Detection], periods: int) -> list[Detection]:
    return [replace(each, time_s=each.time_s + periods * BEEP.period_s) for each in found]


def _stated(range_m: list[Any], bearing_rad: list[Any]) -> Detection:
    return replace(FOUND[0], range_m=np.array(range_m), bearing_rad=np.array(bearing_rad))


@pytest.mark.parametrize(
    ("yielded", "reason"),
    [
        ([], ": 12, got 0$"),
        (FOUND[:3], ": 12, got 3$"),
        (FOUND[:-2], ": 12, got 10$"),
        (FOUND[1:], ": 12, got 11$"),
        (FOUND[::2], ": 12, got 6$"),
        ([*FOUND, *shifted(FOUND, BEEPS)], ": 12, got more$"),
        ([*FOUND[:2], *FOUND[:2], *FOUND[4:]], ": got one at 0.00 s after one at 0.09 s$"),
        (FOUND[::-1], ": got one at 0.90 s after one at 0.99 s$"),
        (itertools.repeat(lost(FOUND[0])), ": got one at 0.00 s after one at 0.00 s$"),
        (None, ": got None, not an iterator$"),
        (7, ": got a value of type int, not an iterator$"),
        ([*FOUND[:2], None], ": got None as number 2$"),
        ([each.decision for each in FOUND], ": got a value of type Decision as number 0$"),
        ([replace(FOUND[0], time_s=float("nan"))], "time_s of a Detection must be a finite number, got nan"),
        ([replace(FOUND[0], time_s=None)], "time_s of a Detection must be a finite number, got None"),
        ([_stated([2.0], [30.0])], r"bearing_rad of a Detection must be from 0 to 3.14 or NaN, got \[30.0\]"),
        ([_stated([2.0], [-0.1])], "bearing_rad of a Detection must be from 0 to 3.14 or NaN, got"),
        ([_stated([np.inf], [0.1])], "range_m of a Detection must be from 0 to .* or NaN, got"),
        ([_stated([-2.0], [0.1])], "range_m of a Detection must be from 0 to .* or NaN, got"),
        ([_stated([2.0], [0.1, 0.2])], "bearing_rad of a Detection must be 1 real numbers, as range_m, got"),
        ([_stated([2j], [0.1])], "range_m of a Detection must be 1 real numbers, as range_m, got"),
        ([replace(FOUND[0], decision=None)], "decision of a Detection must have an alert that is True or False"),
    ],
    ids=[
        "nothing", "the first three", "not the last two", "not the first", "every other", "twice", "again", "backwards",
        "endless", "None", "a number", "one None", "decisions", "no time", "None as time",
        "degrees", "a negative bearing", "an infinite range", "a negative range", "two bearings", "complex",
        "no decision",
    ],
)  # fmt: skip
def test_what_is_not_one_detection_a_beep_is_refused(yielded: Any, reason: str) -> None:
    """Cause: whatever was yielded was scored as if it were all, on a smaller denominator; nothing had a TN of 100 %.
    None was "not iterable"."""
    with pytest.raises(ValueError, match=reason):
        judged(lambda _: yielded)


def test_an_endless_stream_is_cut_off() -> None:
    """Cause: it was read until memory ran out."""
    taken = []

    def endless(_: Recording) -> Iterable[Detection]:
        for k in itertools.count():
            taken.append(k)
            yield replace(FOUND[0], time_s=k * BEEP.period_s)

    with pytest.raises(ValueError, match=r"^stream must yield one Detection a beep, in order: 12, got more$"):
        judged(endless)
    assert len(taken) == BEEPS + 1


def test_no_beep_is_a_result() -> None:
    def without(_: Recording) -> Iterable[Detection]:
        raise NoBeepError

    assert judged(without) == ([], True)
    assert judged(lambda _: [*FOUND[:3], lost(FOUND[3])])[0] == [*FOUND[:3], lost(FOUND[3])]


def test_a_detector_may_align_by_itself() -> None:
    """By the sample, to a millisecond, or not at all: it begins where the recording does. A detector of the project
    that begins a sample late has no complete period at the end, though it may state the emission a sample earlier."""
    late = beeps(LATE_S)
    aligned = list(PaperDetector(BEEP, PHONE).stream(late))
    assert len(aligned) == BEEPS - 1
    rounded = [replace(each, time_s=round(each.time_s, 3)) for each in aligned]
    plain = [replace(each, beep_flags=0) for each in FOUND]
    for yielded in (FOUND, FOUND[:-1], aligned, rounded, plain):
        assert judged(lambda _, yielded=yielded: yielded, late)[0] == yielded


@pytest.mark.parametrize(
    "recording",
    [
        beeps(LATE_S),
        beeps(4.5 * BEEP.period_s),
        beeps(BEEPS * BEEP.period_s),
        beeps(silent=slice(0, 4000)),
        beeps(silent=slice(20_000, 30_000)),
        beeps(silent=slice(30_000, None)),
        Recording(RECORDING.samples[:, :100], BEEP.sample_rate_hz),
        Recording(np.delete(RECORDING.samples, slice(20_000, 21_000), axis=1), BEEP.sample_rate_hz),
    ],
    ids=["late", "silence first", "silence", "begins later", "gap", "ends early", "short", "dropped samples"],
)  # fmt: skip
def test_the_project_s_detectors_keep_to_it_on_recordings_that_lack_beeps(recording: Recording) -> None:
    detector = PaperDetector(BEEP, PHONE)
    found, no_beep = detections_of(detector, BEEP, recording)
    assert no_beep or len(found) == len(list(detector.stream(recording)))
