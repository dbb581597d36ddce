"""A damaged beep changes nothing but itself, whichever detector runs on it."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch import DistanceOnlyDetector, Flag, PaperDetector, StandingDetector
from obstaclewatch.detection import COLUMNS
from tests.obstaclewatch.synthetic import BEEP, PHONE, Point, record

GROUND = Point(1.3, gain=0.3, carried=True, bob_m=0.02)
PERIOD = BEEP.period_samples


def _clicked(blocks, beep):
    blocks = blocks.copy()
    blocks[beep, :, 9_000] = 42.0 * np.abs(blocks).max()
    return blocks


def _processed(detector, blocks, passed_over=-1):
    detector.reset()
    times = np.arange(len(blocks)) * BEEP.period_s
    return [detector.process(blocks[k], times[k]) for k in range(len(blocks)) if k != passed_over]


def _columns(found):
    return [[detection.columns()[name].tolist() for name in COLUMNS] for detection in found]


@pytest.mark.parametrize("beep", [0, 12, 20])
@pytest.mark.parametrize("kind", [PaperDetector, DistanceOnlyDetector])
def test_a_click_is_a_missing_beep_for_the_papers_detectors(kind, beep):
    """Peaks of the click were remembered for 0.7 s."""
    samples = record([GROUND, Point(4.5, gain=0.1)], beeps=26, speed_m_s=1.3, noise=0.02)
    blocks = np.stack(np.split(samples, 26, axis=1))
    silent = blocks.copy()
    silent[beep] = 0.0
    clicked, missing = (_processed(kind(BEEP, PHONE), each) for each in (_clicked(blocks, beep), silent))
    del clicked[beep], missing[beep]
    assert any(detection.decision.alert for detection in clicked)
    assert repr(_columns(clicked)) == repr(_columns(missing))  # NaN is NaN
    if beep > 0:  # the vote of the first one was cast before anything could be known of it
        assert repr([each.decision for each in clicked]) == repr([each.decision for each in missing])


@pytest.mark.parametrize("beep", [0, 1, 6, 11])
def test_a_click_does_not_end_the_mean_of_beeps(beep):
    """The mean began anew with the click, and anew after it: noise was 12 dB higher again."""
    samples = record([GROUND, Point(3.0, 0.4, gain=0.1)], beeps=12, noise=0.1)
    blocks = np.stack(np.split(samples, 12, axis=1))
    detector = StandingDetector(BEEP, PHONE)
    clicked = _processed(detector, _clicked(blocks, beep))
    without = _processed(detector, blocks, passed_over=beep)
    if beep > 0:
        assert [Flag.DAMAGED in each.beep_flags for each in clicked] == [k == beep for k in range(12)]
    del clicked[beep]
    assert any(len(each) for each in clicked)
    assert repr(_columns(clicked)) == repr(_columns(without))


@pytest.mark.parametrize("beep", [0, 1, 6])
def test_a_silent_beep_does_not_end_the_mean_of_beeps(beep):
    """Silence went into the mean, which began anew with it, and anew after it."""
    samples = record([Point(3.0, 0.4, gain=0.1)], beeps=12, noise=0.1)
    blocks = np.stack(np.split(samples, 12, axis=1))
    detector = StandingDetector(BEEP, PHONE)
    without = _processed(detector, blocks, passed_over=beep)
    blocks[beep] = 0.0
    silent = _processed(detector, blocks)
    assert [Flag.NO_BEEP in each.beep_flags for each in silent] == [k == beep for k in range(12)]
    del silent[beep]
    assert any(len(each) for each in silent)
    assert repr(_columns(silent)) == repr(_columns(without))
