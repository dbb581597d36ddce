"""Degrees for radians and kHz for Hz are refused, not run."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.cells.spec import WalkChange
from obstaclewatch import BeepDesign
from scenes import GaitWalk
from simulator import StraightWalk, held_rotation


@pytest.mark.parametrize("make", [
    lambda: held_rotation(90.0),
    lambda: held_rotation(0.0, pitch_rad=30.0),
    lambda: held_rotation(0.0, roll_rad=[0.0, np.nan]),
    lambda: StraightWalk([0, 0, 1.3], 0.0, 1.3, 4.0, pitch_rad=30.0),
    lambda: GaitWalk([0, 0, 1.3], heading_rad=180.0),
    lambda: GaitWalk([0, 0, 1.3], pitch_rad=30.0),
])  # fmt: skip
def test_degrees_are_refused(make):
    with pytest.raises(ValueError, match="must be in radians, finite and within"):
        make()


def test_a_heading_may_wind_up():
    held_rotation(np.linspace(0.0, 7.9 * np.pi, 5))


def test_kilohertz_are_refused():
    with pytest.raises(ValueError, match="in Hz, 1000 or more, got 18 and 23"):
        BeepDesign(18, 23)


@pytest.mark.parametrize("change", [{"duration_s": 50.0}, {"gap_s": 40.0}, {"sample_rate_hz": 192e6}])
def test_milliseconds_are_refused(change):
    """No time of a beep was too long: samples of 1e7 ms filled the memory."""
    name = next(iter(change))
    with pytest.raises(ValueError, match=f"{name} must be at most"):
        BeepDesign(**change)


@pytest.mark.parametrize("change", [{"pitch_rad": 30.0}, {"speed_m_s": 130.0}])
def test_suites_refuse_other_units(change):
    with pytest.raises(ValueError, match="less than or equal"):
        WalkChange(**change)
