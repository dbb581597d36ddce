"""What a detector's stream yields of a recording: one `Detection` a beep, in order, or its cell fails."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any, SupportsFloat

import numpy as np
from numpy.typing import NDArray

from obstaclewatch import BeepDesign, Detection, Flag, NoBeepError
from obstaclewatch.recording import Recording
from obstaclewatch.recordings.alignment import BeepFinder

RULE = "stream must yield one Detection a beep, in order"
ESTIMATES = {"range_m": 1e3, "bearing_rad": np.pi}
"""What is scored of a candidate, and the most that it can be."""
ROUNDED = 1e-6  # pi in single precision
ALIGNED = 0.05
"""To so much of a period emissions are known: by the direct sound's delay, and by a clock that drifts."""


def detections_of(detector: Any, beep: BeepDesign, recording: Recording) -> tuple[list[Detection], bool]:
    """All detections, and whether the detector found no beep at all: a result, not a failure of the bench.

    Scores are shares of the beeps that were yielded, so none may be left out from the first that can be found on, but
    the very last: its period is not complete for a detector that aligns a sample late. After one with the flag NO_BEEP
    a stream may go on anywhere later, or end.

    Raises:
        ValueError: the stream yields something else, or too few, too many or in another order; with both numbers. Or a
            detection states what cannot be.
    """
    try:
        found = _taken(detector.stream(recording), beep, recording)
    except NoBeepError:
        return [], True
    if left_out := _left_out(found, beep, recording):
        raise ValueError(f"{RULE}: {len(found) + left_out}, got {len(found)}")
    return found, False


def _taken(stream: Any, beep: BeepDesign, recording: Recording) -> list[Detection]:
    """Everything, up to the first thing that is wrong: the stream may be endless."""
    found: list[Detection] = []
    most, lost = beep.beeps_in(recording.duration_s), 0
    for detection in _iterable(stream):
        if not isinstance(detection, Detection):
            raise ValueError(f"{RULE}: got {_kind(detection)} as number {len(found)}")
        if not (isinstance(detection.time_s, SupportsFloat) and math.isfinite(detection.time_s)):
            raise ValueError(f"time_s of a Detection must be a finite number, got {detection.time_s!r}")
        _check_estimates(detection)
        found.append(detection)
        lost += _lost(detection)
        if len(found) > most + min(lost, most + 1):
            raise ValueError(f"{RULE}: {most}, got more")
        if found[1:] and _between(found[-2], detection, beep) < 0:
            raise ValueError(f"{RULE}: got one at {detection.time_s:.2f} s after one at {found[-2].time_s:.2f} s")
    return found


def _check_estimates(detection: Detection) -> None:
    """Refuse what would be scored as something else: bearings in degrees, columns of another length, no decision."""
    count = np.size(detection.range_m)
    for name, most in ESTIMATES.items():
        column = np.asarray(getattr(detection, name))
        if column.dtype.kind not in "fiu" or column.shape != (count,):
            raise ValueError(f"{name} of a Detection must be {count} real numbers, as range_m, got {_brief(column)}")
        if np.any((column < 0.0) | (column > most + ROUNDED)):
            raise ValueError(f"{name} of a Detection must be from 0 to {most:.3g} or NaN, got {_brief(column)}")
    alert = getattr(detection.decision, "alert", None)
    if not isinstance(alert, bool | np.bool_):
        raise ValueError(f"decision of a Detection must have an alert that is True or False, got {alert!r}")


def _brief(column: NDArray[Any]) -> str:
    return reprlib.repr(column.tolist())


def _iterable(stream: Any) -> Iterable[Any]:
    try:
        return iter(stream)
    except TypeError:
        raise ValueError(f"{RULE}: got {_kind(stream)}, not an iterator") from None


def _kind(thing: Any) -> str:
    return "None" if thing is None else f"a value of type {type(thing).__name__}"


def _lost(detection: Detection) -> bool:
    return bool(detection.beep_flags & Flag.NO_BEEP)  # a detector of one's own may state 0


def _left_out(found: Sequence[Detection], beep: BeepDesign, recording: Recording) -> int:
    """Beeps before the first, between two, and after the last detection, if they are more than the very last."""
    if not found:
        return beep.beeps_in(recording.duration_s - _first_emission_s(beep, recording))
    inside = sum(max(0, _between(one, other, beep)) for one, other in pairwise(found))
    earlier, after = _before(found[0], beep, recording) + inside, _after(found[-1], beep, recording)
    return earlier + after if earlier or after > 1 else 0


def _before(first: Detection, beep: BeepDesign, recording: Recording) -> int:
    """A detector may align by itself: half a period is no beep."""
    if round(first.time_s / beep.period_s) <= 0:
        return 0
    return max(0, round((first.time_s - _first_emission_s(beep, recording)) / beep.period_s))


def _between(one: Detection, other: Detection, beep: BeepDesign) -> int:
    """Beeps left out between two detections in a row; negative for another order."""
    apart = (other.time_s - one.time_s) / beep.period_s
    if _lost(one):
        return 0 if apart > 0.0 else -1
    return round(apart) - 1


def _after(last: Detection, beep: BeepDesign, recording: Recording) -> int:
    """Periods that are left after the last one's."""
    left = (recording.duration_s - last.time_s) / beep.period_s - 1.0
    return 0 if _lost(last) else max(0, math.floor(left + ALIGNED))


def _first_emission_s(beep: BeepDesign, recording: Recording) -> float:
    """When the first beep that can be found was emitted, but for the direct sound's delay; the end without any."""
    try:
        return BeepFinder(beep, 0.0).first_emission(recording.samples) / recording.sample_rate_hz
    except NoBeepError:
        return recording.duration_s
