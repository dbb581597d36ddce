"""What is handed to detectors in place of recordings, pieces, times and phones ends in one ValueError."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch import BeepDesign, PaperDetector, PhoneGeometry, Recording, inspect_recording
from obstaclewatch.recordings.audio import read_blocks, read_recording, write_recording
from tests.obstaclewatch.synthetic import BEEP, PHONE, Point, record

ONE = Recording(record([Point(2.0)], beeps=3), BEEP.sample_rate_hz)
LONG = PhoneGeometry("mm", [0.0, 70.0, 0.0], [[0.0, 70.0, 0.0], [0.0, -70.0, 0.0]])

WRONG = {
    "pieces must be of type Iterable, got Recording": lambda: PaperDetector(BEEP, PHONE).stream_pieces(ONE),
    "pieces must be of type Iterable, got None": lambda: PaperDetector(BEEP, PHONE).stream_pieces(None),
    "piece must be of type Recording, got array": lambda: PaperDetector(BEEP, PHONE).stream_pieces([ONE.samples]),
    "time_s must be a number": lambda: PaperDetector(BEEP, PHONE).process(np.zeros((2, BEEP.period_samples)), [1.0]),
    "must be within 1.5 m, got 140 m: in mm": lambda: PaperDetector(BeepDesign(), LONG),
    "recording must be of type Recording, got None": lambda: inspect_recording(None, BEEP, PHONE),
    "path must be of type str or PathLike, got None": lambda: read_recording(None),
    "path must be of type str or PathLike, got 3": lambda: write_recording(ONE, 3),
    "recording must be of type Recording or Iterable, got None": lambda: write_recording(None, "a.wav"),
    "recording must be of type Recording, got 1": lambda: write_recording([1], "a.wav"),
    "block_samples must be a whole number, 1 or more, got 1.5": lambda: list(read_blocks("a.wav", 1.5)),
    "phone must be of type PhoneGeometry, got 3": lambda: inspect_recording(ONE, BEEP, 3),
}


@pytest.mark.parametrize("rule", WRONG)
def test_what_is_wrong_is_named_with_its_rule(rule):
    with pytest.raises(ValueError, match=rule):
        WRONG[rule]()
