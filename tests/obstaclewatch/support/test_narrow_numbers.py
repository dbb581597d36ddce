"""Numbers of numpy's narrow types are computed with as Python's own."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from obstaclewatch import BeepDesign, PaperDetector, PaperSettings, Recording, assumed_sound_speed, measured_walk_ratio
from obstaclewatch.support.argument_types import as_number
from scenes import Gait, GaitWalk, Pace, Route, RouteWalk
from scenes.obstacles.wall import wall
from scenes.truth.swept import Body
from simulator import Air, Fidelity, Material, Phone, StraightWalk, Transducer
from tests.obstaclewatch.synthetic import BEEP, PHONE, Point, record

START = [0.0, 0.0, 1.3]
ROUTE = Route([[0.0, 0.0], [4.0, 0.0]], np.float32(0.5))
MADE = [
    BeepDesign(np.uint16(23000), np.uint16(18000), sample_rate_hz=np.float32(192000)),
    Recording(np.zeros((2, 5)), np.int32(192000)),
    PaperSettings(far_m=np.float16(6), votes_of=np.int8(9), body_distance_m=(np.float32(0.125), np.float16(0.5))),
    Air(np.float16(20), np.float32(0.5), np.float32(1e5), np.int16(343)),
    Material("m", (15e3, 25e3), (0.5, 0.5), np.float16(0.001)),
    Fidelity(tolerance_db=np.float32(1), max_order=np.int8(2), max_range_m=np.float16(7)),
    Transducer(rear_loss_db=np.int8(12)),
    Phone.named("ideal"),
    StraightWalk(START, np.int8(1), np.float32(1.0), np.int16(200)),
    GaitWalk(START, np.int8(1), np.float16(1.0), np.int16(200), gait=Gait(np.float16(1.5))),
    Gait.at_speed(np.float16(1.5), np.float32(0.5)),
    Pace(np.float16(1.5), ramp_s=np.float32(0.5)),
    RouteWalk(ROUTE, Pace(1.3), np.int8(5), np.float16(1.5)),
    Body(np.float16(0.25)),
]


@pytest.mark.parametrize("made", MADE, ids=lambda made: type(made).__name__)
def test_what_is_held_is_pythons_own(made: Any) -> None:
    """They were held as they came: an int16 band's centre was -12.3 kHz, a float16's speed of sound NaN."""
    held = {each.name: getattr(made, each.name) for each in fields(made)}
    parts = [part for value in held.values() for part in (value if isinstance(value, tuple) else (value,))]
    assert {type(part) for part in parts if isinstance(part, (float, np.generic))} <= {float}


def test_results_are_those_of_pythons_own() -> None:
    """int16 500 x 380 overflowed: a walk ratio of 0.00546 in place of 0.00628."""
    assert measured_walk_ratio(np.int16(500), np.int16(380), np.int16(710)) == measured_walk_ratio(500, 380, 710)
    assert assumed_sound_speed(np.float16(20)) == assumed_sound_speed(20.0)
    assert Air(np.float16(20)).sound_speed_m_s == Air(20.0).sound_speed_m_s
    assert BeepDesign(np.int16(18000), np.int16(23000)).center_hz == BEEP.center_hz
    assert BeepDesign(np.uint16(23000), np.uint16(18000)).chirp_rate_hz_s == -BEEP.chirp_rate_hz_s
    there = [StraightWalk(START, heading, 1.0, 200.0).pose(100.0).position_m for heading in (np.int8(1), 1)]
    np.testing.assert_array_equal(*there)
    assert wall(np.float16(2.5)).bounds.tolist() == wall(2.5).bounds.tolist()
    recording = Recording(record([Point(2.0)], beeps=2), BEEP.sample_rate_hz)
    assert PaperDetector(BEEP, PHONE, sound_speed_m_s=np.float16(343)).run(recording)[0].time_s >= 0.0


@pytest.mark.parametrize("value", [None, "1.0", True, 1j, [1.0], [[1, 2], [3]], np.array([1.0]), np.ma.masked, 10**400])
def test_what_is_no_number_is_refused_by_name(value: Any) -> None:
    """Rows of unequal length ended in numpy's own words, and a masked value was 0."""
    with pytest.raises(ValueError, match="range_m must be a number, got "):
        as_number("range_m", value)
    with pytest.raises(ValueError, match="start_hz must be a number, got "):
        BeepDesign(start_hz=value)


def test_counts_are_bounded() -> None:
    """10**400 votes ended in an OverflowError of the detector."""
    with pytest.raises(ValueError, match="votes_of must be at most 10000, got 1000"):
        PaperSettings(votes_of=10**400)
