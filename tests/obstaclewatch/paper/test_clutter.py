"""Static and closing peaks over successive beeps (paper section 3.4)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch.paper.clutter import SPEED_STEP_M_S, PeakHistory, judge_motion
from obstaclewatch.paper.settings import PaperSettings

PERIOD_S = 0.09
DEFAULTS = PaperSettings()


def _judge(tracks, beeps=9):
    """Motion of the last beep's peaks; a track is a function of time that gives a range, NaN where not received."""
    history = PeakHistory(DEFAULTS.history_s)
    for index in range(beeps):
        time = index * PERIOD_S
        ranges = np.array([track(time) for track in tracks])
        ages, past = history.before(time)
        motion = judge_motion(
            ranges,
            ages,
            past,
            DEFAULTS.static_tolerance_m,
            DEFAULTS.static_age_s,
            DEFAULTS.closing_speed_m_s,
            DEFAULTS.closing_tolerance_m,
        )
        history.add(time, ranges)
    return motion


@settings(max_examples=30, deadline=None)
@given(speed=st.floats(0.5, 3.4), start_m=st.floats(2.6, 7.0))
def test_a_constant_approach_closes_in_at_its_speed(speed, start_m):
    motion = _judge([lambda time: start_m - speed * time])
    assert motion.judged
    assert motion.closing.all()
    assert not motion.static.any()
    assert motion.closing_speed_m_s[0] == pytest.approx(speed, abs=1e-6)


@settings(max_examples=30, deadline=None)
@given(phase=st.floats(0.0, 2.0 * np.pi), swing_m=st.floats(0.0, 0.07))
def test_what_stays_is_static_even_under_a_gait(phase, swing_m):
    """+-7 cm twice a second: 2.5 cm of bobbing as the chirp reads it."""
    motion = _judge([lambda time: 1.3 + swing_m * np.sin(4.0 * np.pi * time + phase)])
    assert motion.judged
    assert motion.static.all()
    assert np.isnan(motion.closing_speed_m_s).all()


def test_both_at_once_are_told_apart():
    motion = _judge([lambda time: 1.3, lambda time: 4.0 - 1.4 * time, lambda time: 2.2])
    assert motion.static.tolist() == [True, False, True]
    assert motion.closing.tolist() == [False, True, False]


def test_a_row_of_obstacles_that_meet_each_others_places_is_not_static():
    """Obstacles 36 cm apart at 1 m/s: each finds a neighbour where it was four beeps ago."""
    motion = _judge([lambda time, k=k: 2.0 + 0.36 * k - 1.0 * time for k in range(8)])
    assert not motion.static.any()
    assert motion.closing[:5].all()


def test_what_recedes_or_jumps_does_not_close_in():
    rng = np.random.default_rng(5)
    motion = _judge([lambda time: 2.0 + 1.3 * time, lambda time: rng.uniform(5.0, 7.0)])
    assert motion.judged
    assert not motion.static.any()
    assert not motion.closing.any()


def test_an_echo_heard_in_two_beeps_of_three_still_closes_in():
    motion = _judge([lambda time: 4.0 - 1.3 * time if round(time / PERIOD_S) % 3 != 1 else np.nan], beeps=9)
    assert motion.closing.all()


def test_nothing_is_said_before_enough_beeps():
    motion = _judge([lambda time: 1.3], beeps=4)
    assert not motion.judged
    assert not motion.static.any()


def test_history_forgets_and_pads():
    history = PeakHistory(0.5)
    history.add(0.0, np.array([1.0]))
    history.add(0.3, np.array([1.0, 2.0]))
    history.add(0.4, np.array([]))
    ages, past = history.before(0.6)
    assert ages == pytest.approx([0.3, 0.2])
    assert past[0].tolist() == [1.0, 2.0]
    assert np.isnan(past[1]).all()
    history.clear()
    assert len(history.before(0.6)[0]) == 0


def _slowly(range_m, age_s, past_m):
    """(static, closing, speed) of one peak, each beep's nearest peak found by whole arrays."""

    def off(speed):
        apart = past_m - (range_m + speed * age_s)[:, None]
        return np.array(
            [row[np.argmin(np.abs(row))] if len(row) else np.inf for row in (r[~np.isnan(r)] for r in apart)]
        )

    speeds = np.arange(DEFAULTS.closing_speed_m_s[0], DEFAULTS.closing_speed_m_s[1] + 1e-9, SPEED_STEP_M_S)
    lines = [(np.sum(np.abs(off(speed)) <= DEFAULTS.closing_tolerance_m), speed) for speed in speeds]
    most = max(lines)[0]
    stays = np.abs(off(0.0)) <= DEFAULTS.static_tolerance_m
    old = age_s >= DEFAULTS.static_age_s
    static = stays[old].sum() >= 0.5 * old.sum() and stays.sum() >= most
    best = min((speed for many, speed in lines if many == most), key=lambda v: np.minimum(np.abs(off(v)), 1.0).sum())
    near = np.abs(off(best)) <= DEFAULTS.closing_tolerance_m
    through = best + (age_s[near] @ off(best)[near]) / (age_s[near] @ age_s[near]) if near.any() else np.nan
    closing = not static and most >= max(0.5 * len(age_s), 3)
    return static, closing, through if closing else np.nan


def test_agrees_with_whole_arrays():
    """Compiled loops against a reference that shares nothing with them, on peaks that stay, close in and jump."""
    rng, told = np.random.default_rng(8), np.zeros(2)
    for _ in range(40):
        age_s = PERIOD_S * np.arange(rng.integers(6, 9), 0, -1)
        past_m = np.sort(rng.uniform(0.3, 7.0, (len(age_s), 4)))
        past_m[:, 0], past_m[:, 1] = 1.3 + rng.normal(0.0, 0.04, len(age_s)), 3.0 + 1.3 * age_s
        past_m[rng.uniform(size=past_m.shape) < 0.2] = np.nan
        range_m = np.array([1.3, 3.0, *rng.uniform(0.3, 7.0, 3)])
        motion = judge_motion(range_m, age_s, past_m, 0.12, 0.25, DEFAULTS.closing_speed_m_s, 0.08)
        static, closing, speed = zip(*(_slowly(one, age_s, past_m) for one in range_m), strict=True)
        assert (motion.static.tolist(), motion.closing.tolist()) == (list(static), list(closing))
        assert motion.closing_speed_m_s == pytest.approx(speed, rel=1e-12, nan_ok=True)
        told += motion.static.sum(), motion.closing.sum()
    assert (told > 20).all()
