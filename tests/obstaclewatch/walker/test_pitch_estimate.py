"""The pitch measured in the ground's echo: exact images, limits, and what must not be taken for the ground."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch import PaperSettings, TrackingDetector
from obstaclewatch.tracking.moving_peaks import PeakFinder
from tests.obstaclewatch.pitched import by_ground, recorded, way_m
from tests.obstaclewatch.synthetic import BEEP, PHONE, C

BOB_M, STEP_HZ = 0.02, 1.8
"""What stands still altogether is no walker's ground."""


def _walked(pitch_rad, height_m=1.35, gain=(0.5, 0.4), beeps=16):
    """Blocks of a phone that bobs above the ground."""
    for beep in range(beeps):
        bobbed_m = height_m + BOB_M * np.sin(2.0 * np.pi * STEP_HZ * BEEP.period_s * beep)
        yield recorded([(way_m(by_ground, pitch_rad, bobbed_m), gain)], beeps=1, seed=beep).samples


def _received(blocks, pitch_rad=None):
    """A finder that has read blocks."""
    finder = PeakFinder(BEEP, PHONE, PaperSettings(), C, pitch_rad)
    for block in blocks:
        finder.find(block)
    return finder


@pytest.mark.parametrize("pitch_deg", [5.0, 15.0, 30.0, 45.0, 60.0])
@pytest.mark.parametrize("height_m", [1.2, 1.4])
def test_the_lift_of_an_exact_image_is_heard(pitch_deg, height_m):
    """Speaker and microphone 0 are not at the same place, and a step of the pitch is 1.5 degrees: 3 degrees."""
    finder = _received(_walked(np.radians(pitch_deg), height_m))
    assert finder.ground_m == pytest.approx(height_m, abs=0.03)
    assert np.degrees(finder.pitch_rad) == pytest.approx(pitch_deg, abs=3.0)


def test_a_lift_that_is_told_stays():
    assert _received(_walked(0.5), pitch_rad=0.3).pitch_rad == 0.3


@pytest.mark.parametrize("gain", [(0.0, 0.0), (0.5, 0.0)])
def test_without_the_ground_at_microphone_1_a_phone_is_taken_for_level(gain):
    assert _received(_walked(0.5, gain=gain)).pitch_rad == 0.0


def test_what_is_forgotten_is_heard_anew():
    finder = _received(_walked(0.5))
    assert finder.pitch_rad > 0.4
    finder.reset()
    assert finder.pitch_rad == 0.0


def test_the_detector_judges_by_the_lift_that_it_hears():
    """And once it is reset it receives the same again."""
    detector, blocks = TrackingDetector(BEEP, PHONE), list(_walked(0.5))
    received = []
    for _ in range(2):
        assert detector._pitch_rad == 0.0
        for block in blocks:
            detector.process(block)
        received.append(detector._pitch_rad)
        detector.reset()
    assert received[0] == received[1] == pytest.approx(0.5, abs=0.05)
