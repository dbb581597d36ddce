"""Phones whose microphones are not on the middle line of one face.

Cause: bearings are angles to the line between the microphones, and detectors took it for the phone's long edge. A
microphone 8 mm deeper in the phone tilts that line by 3.3 degrees, and the pitch that was given is the edge's. With
microphones in the other order, or one beside the other, all bearings were from another direction, without an error.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from obstaclewatch import (
    DistanceOnlyDetector,
    PaperDetector,
    PaperStandingDetector,
    PhoneGeometry,
    StandingDetector,
    TrackingDetector,
)
from tests.obstaclewatch.synthetic import BEEP, C, beep_train

DETECTORS = [PaperDetector, DistanceOnlyDetector, PaperStandingDetector, StandingDetector, TrackingDetector]
SPEAKER_M, TOP_M, BOTTOM_M = [0.0, 0.04, 0.0], [0.0, 0.07, 0.0], [0.0, -0.07, 0.0]
NOISE = 1e-5


def _deep(depth_m):
    return PhoneGeometry("deep", SPEAKER_M, [[0.0, 0.07, -depth_m], BOTTOM_M])


def _block(phone, pitch_rad, bearing_rad, range_m=2.0):
    """One beep, and the echo of a point at microphone 0's height; coordinates are right, ahead, up."""
    cos, sin = np.cos(pitch_rad), np.sin(pitch_rad)
    pitched = np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]])
    speaker, *mics = (pitched @ place for place in (phone.speaker_m, *phone.mics_m))
    point = mics[0] + range_m * np.array([np.sin(bearing_rad), np.cos(bearing_rad), 0.0])
    time = np.arange(BEEP.period_samples) / BEEP.sample_rate_hz
    block = NOISE * np.random.default_rng(0).standard_normal((2, len(time)))
    for mic, place in enumerate(mics):
        path_m = np.linalg.norm(point - speaker) + np.linalg.norm(point - place)
        block[mic] += 0.5 * beep_train(time - phone.speaker_to_mic_m[mic] / C) + 0.01 * beep_train(time - path_m / C)
    return block


@pytest.mark.parametrize("detector", [PaperStandingDetector, StandingDetector])
@pytest.mark.parametrize("pitch_deg", [0.0, 29.0, 57.0])
@pytest.mark.parametrize("depth_m", [0.0, 0.008, -0.008])
def test_a_microphone_deeper_in_the_phone_leaves_the_bearing(detector, pitch_deg, depth_m):
    """Where a point is 20 degrees aside noise leaves less than 0.1 degrees; a tilt of 3.3 degrees cost 5 to 20."""
    pitch_rad, bearing_rad = np.radians(pitch_deg), np.radians(20.0)
    phone = _deep(depth_m)
    found = detector(BEEP, phone, pitch_rad=pitch_rad).process(_block(phone, pitch_rad, bearing_rad))
    assert len(found) == 1
    assert found.bearing_rad[0] == pytest.approx(bearing_rad, abs=np.radians(0.5))


def test_on_the_middle_line_the_pitch_is_as_given_bit_for_bit():
    phone = PhoneGeometry("flat", SPEAKER_M, [TOP_M, BOTTOM_M])
    assert [phone.line_pitch_rad(pitch) for pitch in (-0.3, 0.1, 0.5)] == [-0.3, 0.1, 0.5]


def test_a_line_askew_of_the_long_edge_rises_less_than_it():
    phone = PhoneGeometry("askew", SPEAKER_M, [[0.07, 0.07, 0.0], [-0.07, -0.07, 0.0]])
    assert math.sin(phone.line_pitch_rad(0.5)) == pytest.approx(math.sin(0.5) / math.sqrt(2.0), rel=1e-12)


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize(("mics_m", "degrees"), [
    ([BOTTOM_M, TOP_M], 180),
    ([[0.07, 0.0, 0.0], [-0.07, 0.0, 0.0]], 90),
    ([[0.0, 0.0, 0.01], [0.0, 0.0, 0.0]], 90),
])  # fmt: skip
def test_microphones_that_are_no_top_and_bottom_are_refused(detector, mics_m, degrees):
    with pytest.raises(ValueError, match=rf"microphone 0 must lie towards .* got {degrees} degrees"):
        detector(BEEP, PhoneGeometry("wrong", SPEAKER_M, mics_m))


@pytest.mark.parametrize("detector", DETECTORS)
def test_a_line_that_a_pitch_makes_upright_is_refused(detector):
    with pytest.raises(ValueError, match="must leave the microphones' line within"):
        detector(BEEP, _deep(-0.03), pitch_rad=1.5)
