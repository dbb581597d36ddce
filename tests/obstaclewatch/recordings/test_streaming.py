"""A detector follows one recording at a time."""

from __future__ import annotations

import pytest

from obstaclewatch import PaperDetector, StandingDetector, TrackingDetector
from tests.obstaclewatch.synthetic import BEEP, PHONE, Point, recording


@pytest.mark.parametrize("kind", [PaperDetector, StandingDetector, TrackingDetector])
def test_another_stream_ends_the_one_before(kind):
    """Cause: both went on with one state, each with the other's beeps in it."""
    walk, detector = recording([Point(3.0)], beeps=6, noise=0.02), kind(BEEP, PHONE)
    first = detector.stream(walk)
    next(first)
    second = [next(detector.stream(walk))]
    with pytest.raises(RuntimeError, match=r"this stream ended when .*Detector\(test, 18-23 kHz\) began another"):
        next(first)
    assert second[0].index == 0
    assert [found.index for found in detector.stream(walk)] == list(range(6))
