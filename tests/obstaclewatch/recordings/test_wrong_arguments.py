"""What is handed to detectors in place of recordings, pieces, times and phones ends in one ValueError."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch import (
    BeepDesign,
    PaperDetector,
    PhoneGeometry,
    Recording,
    StandingDetector,
    TrackingDetector,
    inspect_recording,
)
from obstaclewatch.recordings.audio import read_blocks, read_recording, write_recording
from obstaclewatch.recordings.calibration import calibrate
from obstaclewatch.recordings.live import live_pieces
from obstaclewatch.signal.matched_filter import MatchedFilter
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
    "sound_speed_m_s must be from 250 to 450 m/s, got 34300": lambda: PaperDetector(BEEP, PHONE, sound_speed_m_s=34300),
    "sound_speed_m_s must be from 250 to 450 m/s, got 1235.0": lambda: StandingDetector(
        BEEP, PHONE, sound_speed_m_s=1235.0
    ),
    "sound_speed_m_s must be from 250 to 450 m/s, got nan": lambda: TrackingDetector(
        BEEP, PHONE, sound_speed_m_s=np.nan
    ),
    "recording must be of type Recording, got 2": lambda: calibrate(2, BEEP, PHONE),
    r"sample_rate_hz must be 1 to 1e\+12 Hz, got 1e-300": lambda: Recording(ONE.samples, 1e-300),
    r"sample_rate_hz must be 1 to 1e\+12 Hz, got 1e\+300": lambda: Recording(ONE.samples, 1e300),
    "beep must be of type BeepDesign, got 3": lambda: calibrate(ONE, 3, PHONE),
    "duration_s must be a number, got '1'": lambda: live_pieces(BEEP, "1"),
    r"recording must be of type Recording or Iterable, got array\(1.\)": lambda: write_recording(
        np.array(1.0), "a.wav"
    ),
    "phone must be of type PhoneGeometry, got 3": lambda: inspect_recording(ONE, BEEP, 3),
}


@pytest.mark.parametrize("rule", WRONG)
def test_what_is_wrong_is_named_with_its_rule(rule):
    with pytest.raises(ValueError, match=rule):
        WRONG[rule]()


@pytest.mark.parametrize("detector", [PaperDetector, StandingDetector, TrackingDetector])
def test_a_block_that_is_refused_leaves_a_detector_as_it_was(detector):
    """Sums of squares overflowed: "cannot convert float NaN to integer", or 1e100 taken for one channel twice."""
    block, given = ONE.samples[:, : BEEP.period_samples].astype(np.float64), detector(BEEP, PHONE)
    for wrong, rule in ((1e11, "be re full scale"), (1e100, "be re full scale"), (np.nan, "be finite")):
        with pytest.raises(ValueError, match=f"a block must {rule}"):
            given.process(block * wrong)
    for bad in ([[1.0, 2.0], [3.0]], None, block.astype(str)):
        with pytest.raises(ValueError, match="a block must be numbers, got "):
            given.process(bad)
    for time_s in (1e17, -1e17, np.inf):
        with pytest.raises(ValueError, match="time_s must be finite and within"):
            given.process(block, time_s)
    fresh = detector(BEEP, PHONE)
    for _ in range(2):
        found, expected = given.process(block), fresh.process(block)
        assert (found.time_s, found.beep_flags) == (expected.time_s, expected.beep_flags)
        np.testing.assert_array_equal(found.range_m, expected.range_m)


@pytest.mark.parametrize("detector", [PaperDetector, StandingDetector, TrackingDetector])
def test_the_largest_samples_are_measured_like_others(detector):
    """The bound is one below which nothing overflows: ranges do not depend on the level."""
    block = ONE.samples[:, : BEEP.period_samples].astype(np.float64)
    large = block * (1e10 / np.abs(block).max())
    found, expected = (detector(BEEP, PHONE).process(each) for each in (large, block))
    assert found.beep_flags == expected.beep_flags
    np.testing.assert_allclose(found.range_m, expected.range_m, rtol=1e-9)


def test_the_samples_of_a_recording_are_not_written_through_it():
    """They could be overwritten unseen, with what no recording may hold."""
    with pytest.raises(ValueError, match="read-only"):
        ONE.samples[0, 0] = np.nan


def test_times_of_a_beep():
    """Texts and NaN came through; at infinity there was a warning for what is exactly zero."""
    assert BEEP.waveform([-np.inf, np.inf]).tolist() == [0.0, 0.0]
    for of_time in (BEEP.window, BEEP.phase_rad, BEEP.waveform):
        for wrong in (None, "1.0", np.nan, [[0.0], [0.0, 1.0]]):
            with pytest.raises(ValueError, match="time_s must be "):
                of_time(wrong)
    for wrong in (None, "x", np.nan, np.inf, -1, [[1, 2], [3]]):
        with pytest.raises(ValueError, match="duration_s must be "):
            BEEP.beeps_in(wrong)


@pytest.mark.parametrize("earlier_s", [np.nan, np.inf, 1j, "1", None, True])
def test_a_move_of_a_profile_is_a_number(earlier_s):
    """NaN made a profile of NaN."""
    with pytest.raises(ValueError, match="earlier_s must be "):
        MatchedFilter(BEEP, 0.03).compress(np.zeros((2, BEEP.period_samples)), earlier_s)
    with pytest.raises(ValueError, match="reverse must be of type bool, got 'no'"):
        MatchedFilter(BEEP, 0.03, reverse="no")
