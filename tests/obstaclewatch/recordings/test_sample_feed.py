"""Recordings in pieces: the same detections bit for bit, in constant memory."""

from __future__ import annotations

import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch import PaperDetector, Recording, TrackingDetector
from obstaclewatch.recordings.sample_feed import SampleFeed
from tests.obstaclewatch.synthetic import BEEP, PHONE, Point, recording

WALK = recording([Point(1.3, gain=0.3, carried=True, bob_m=0.02), Point(4.0, 0.2)], beeps=12, speed_m_s=1.3, noise=0.05)
DAMAGED = Recording(np.delete(WALK.samples, np.s_[60_000:60_900], axis=1)[:, 4_000:], WALK.sample_rate_hz)


def pieces_of(whole, lengths):
    """The recording cut into pieces of the given lengths, over and over."""
    begin, turn = 0, 0
    while begin < whole.samples.shape[1]:
        length = lengths[turn % len(lengths)]
        yield Recording(whole.samples[:, begin : begin + length], whole.sample_rate_hz)
        begin, turn = begin + length, turn + 1


@pytest.mark.parametrize("detector", [PaperDetector, TrackingDetector])
@pytest.mark.parametrize("whole", [WALK, DAMAGED], ids=["whole", "damaged"])
@pytest.mark.parametrize("lengths", [(17_280,), (5_000, 70_000, 1), (1 << 20,)], ids=str)
def test_pieces_of_any_length_say_the_same(detector, whole, lengths):
    at_once = [repr(found) for found in detector(BEEP, PHONE).stream(whole)]
    in_pieces = [repr(found) for found in detector(BEEP, PHONE).stream_pieces(pieces_of(whole, lengths))]
    assert len(at_once) >= 9
    assert in_pieces == at_once


@pytest.mark.parametrize("detector", [PaperDetector, TrackingDetector])
def test_blocks_that_are_handed_over_say_the_same(detector):
    """From the first emission on: bit for bit, times included, which differed by rounding from the fifth beep on."""
    at_once, one_by_one = list(detector(BEEP, PHONE).stream(WALK)), detector(BEEP, PHONE)
    assert len(at_once) == 12
    for begin, found in zip(range(0, 12 * BEEP.period_samples, BEEP.period_samples), at_once, strict=True):
        again = one_by_one.process(WALK.samples[:, begin : begin + BEEP.period_samples])
        assert again.time_s == found.time_s
        assert repr(again.decision) == repr(found.decision)
        for name, column in found.columns().items():
            np.testing.assert_array_equal(getattr(again, name), column, err_msg=name)


@given(lengths=st.lists(st.integers(1, 40), min_size=1, max_size=5), begin=st.integers(0, 90), count=st.integers(0, 40))
@settings(max_examples=50, deadline=None)
def test_samples_come_as_they_are(lengths, begin, count):
    samples = np.arange(200, dtype=np.float32).reshape(2, 100)
    feed = SampleFeed(pieces_of(Recording(samples, 1.0), lengths), 1.0)
    feed.forget(begin // 2)
    feed.take(begin // 2, begin)
    feed.forget(begin)
    assert np.array_equal(feed.take(begin, begin + count), samples[:, begin : begin + count])


def test_what_is_forgotten_is_gone_and_rates_must_agree():
    feed = SampleFeed(pieces_of(WALK, (1_000,)), WALK.sample_rate_hz)
    feed.take(0, 5_000)
    feed.forget(3_000)
    with pytest.raises(ValueError, match="samples before 3000 are forgotten, got 2999"):
        feed.take(2_999, 4_000)
    mixed = iter([WALK, Recording(WALK.samples, 48_000.0)])
    with pytest.raises(ValueError, match=r"192000.0 Hz, got 48000.0 Hz"):
        list(PaperDetector(BEEP, PHONE).stream_pieces(mixed))


def endless(periods):
    """One period of a standing scene, over and over, every one a new array."""
    period = recording([Point(2.0)], noise=0.02).samples
    for _ in range(periods):
        yield Recording(period.copy(), BEEP.sample_rate_hz)


def test_memory_does_not_grow():
    """Peak of what Python and numpy hold: 80 beeps and 320 beeps take the same."""
    peaks = []
    for periods in (80, 320):
        tracemalloc.start()
        assert sum(1 for _ in PaperDetector(BEEP, PHONE).stream_pieces(endless(periods))) == periods
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.02 * peaks[0]
    assert peaks[1] < 10e6


HOUR = """
import resource
from tests.obstaclewatch.recordings.test_sample_feed import BEEP, PHONE, PaperDetector, endless
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for count, _ in enumerate(PaperDetector(BEEP, PHONE).stream_pieces(endless({beeps}))):
    if count == 1000:
        before = peak()
print(before, peak())
"""


@pytest.mark.slow
def test_an_hour_takes_no_more_memory_than_two_minutes():
    """Resident set, kB. By design nothing grows: eight hours are eight times this."""
    done = subprocess.run(
        [sys.executable, "-c", HOUR.format(beeps=40_000)],
        cwd=Path(__file__).parents[3], capture_output=True, check=True, text=True,
    )  # fmt: skip
    before, after = (int(part) for part in done.stdout.split())
    assert after - before < 2_000
