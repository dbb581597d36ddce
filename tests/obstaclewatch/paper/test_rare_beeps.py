"""Beeps that come too rarely for the paper's memory.

Cause: candidates vote only where three earlier beeps, 0.25 to 0.75 s old, say that they come nearer. With a beep every
0.2 s two are that old, so that nothing was ever judged: every candidate was UNCONFIRMED, and no walk had an alert.
"""

from __future__ import annotations

import pytest

from obstaclewatch import (
    BeepDesign,
    DistanceOnlyDetector,
    Flag,
    PaperDetector,
    PaperSettings,
    PaperStandingDetector,
    StandingDetector,
)
from tests.obstaclewatch.synthetic import PHONE, Point, recording


@pytest.mark.parametrize("detector", [PaperDetector, DistanceOnlyDetector])
@pytest.mark.parametrize("gap_s", [0.15, 0.2, 0.45])
def test_beeps_too_rare_to_judge_motion_are_refused(detector, gap_s):
    rule = f"history_s must hold 3 earlier beeps .* one beep in {0.05 + gap_s:g} s"
    with pytest.raises(ValueError, match=rule):
        detector(BeepDesign(gap_s=gap_s), PHONE)


@pytest.mark.parametrize("gap_s", [0.0, 0.04, 0.1, 0.13])
def test_as_many_beeps_as_are_accepted_judge_motion(gap_s):
    beep = BeepDesign(gap_s=gap_s)
    wall = recording([Point(4.0)], beeps=int(2.2 / beep.period_s), speed_m_s=1.3, noise=0.02, beep=beep)
    found = list(DistanceOnlyDetector(beep, PHONE).stream(wall))
    later = [Flag(int(flags)) for each in found if each.time_s > 1.0 for flags in each.flags]
    assert later
    assert not any(Flag.UNCONFIRMED in flags for flags in later)
    assert any(each.collides.any() for each in found)


def test_a_longer_memory_takes_rarer_beeps():
    beep = BeepDesign(gap_s=0.2)
    wall = recording([Point(6.0)], beeps=14, speed_m_s=1.3, noise=0.02, beep=beep)
    found = DistanceOnlyDetector(beep, PHONE, PaperSettings(history_s=1.5)).run(wall)
    assert any(each.alert for each in found)


@pytest.mark.parametrize("detector", [PaperStandingDetector, StandingDetector])
def test_at_rest_beeps_may_be_rare(detector):
    beep = BeepDesign(gap_s=0.5)
    found = detector(beep, PHONE).stream(recording([Point(2.0)], beeps=3, noise=0.001, beep=beep))
    assert all(pytest.approx(each.range_m[-1], abs=0.01) == 2.0 - 0.0705 for each in found)
