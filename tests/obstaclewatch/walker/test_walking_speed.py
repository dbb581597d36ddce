"""A walker's speed by their steps, and a walk ratio of one's own."""

import numpy as np
import pytest

from obstaclewatch import BeepDesign, TrackingDetector, measured_walk_ratio
from obstaclewatch.walker.walking_speed import ANYONE, CADENCE_SPREAD, USUAL, walk_ratio, walking_speed
from tests.obstaclewatch.synthetic import PHONE


def test_steps_say_the_walking_speed():
    """0.646 m per 100 steps a minute: 1.67 steps a second are 1.08 m/s, drawn towards what is usual."""
    slow = walking_speed(100.0 / 60.0)
    assert 0.646 * 100.0 / 60.0 < slow.mean_m_s < USUAL.mean_m_s
    assert slow.std_m_s < USUAL.std_m_s
    assert walking_speed(2.2).mean_m_s > USUAL.mean_m_s
    assert walking_speed(0.0) == USUAL


def test_bayes_rule_on_a_grid():
    """The product of two bells, integrated."""
    speed, by_steps = np.linspace(0.0, 3.0, 30001), ANYONE.m_min * 110.0**2 / 60.0
    spread = np.hypot(0.12, 2.0 * CADENCE_SPREAD)  # the cadence counts twice
    density = np.exp(-0.5 * ((speed - 1.25) / 0.2) ** 2 - 0.5 * ((speed - by_steps) / (spread * by_steps)) ** 2)
    mean = speed @ density / density.sum()
    found = walking_speed(110.0 / 60.0)
    assert found.mean_m_s == pytest.approx(mean, abs=1e-9)
    assert found.std_m_s == pytest.approx(np.sqrt((speed - mean) ** 2 @ density / density.sum()), abs=1e-9)


@pytest.mark.parametrize("speed_m_s", [0.9, 1.25, 1.7])
@pytest.mark.parametrize("own", [0.0052, 0.0065, 0.0078])
def test_one_s_own_ratio_gives_one_s_own_speed(speed_m_s, own):
    """Whatever the steps, within its deviation, where anyone's ratio is up to 0.25 m/s off."""
    step_hz = np.sqrt(speed_m_s * 60.0 / own) / 60.0
    found = walking_speed(step_hz, walk_ratio(own))
    assert abs(found.mean_m_s - speed_m_s) < found.std_m_s
    assert found.std_m_s < 0.05 * speed_m_s


def test_a_ratio_is_measured_on_one_walk():
    """60 m in 48 s are 1.25 m/s; 86 steps are 0.698 m each and 107.5 a minute."""
    ratio = measured_walk_ratio(60.0, 48.0, 86)
    assert ratio == pytest.approx(60.0 / 86 / (60.0 * 86 / 48.0))
    assert walking_speed(86 / 48.0, walk_ratio(ratio)).mean_m_s == pytest.approx(1.25, abs=1e-12)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((60.0, 48.0, 43), r"by the steps of both feet, got 0\.02596"),
        ((60.0, 48.0, 0), "steps must be positive and finite, got 0"),
        ((-60.0, 48.0, 86), r"distance_m must be positive and finite, got -60\.0"),
        ((60.0, np.nan, 86), "duration_s must be positive and finite, got nan"),
    ],
)
def test_a_walk_that_says_nothing_is_refused(given, message):
    """One foot's steps alone, none at all, a distance backwards, a time that is none."""
    with pytest.raises(ValueError, match=message):
        measured_walk_ratio(*given)


@pytest.mark.parametrize("value", [0.0, 0.02, np.nan, np.inf])
def test_a_detector_refuses_a_ratio_that_no_person_has(value):
    """By name, as it is made."""
    with pytest.raises(ValueError, match=r"walk_ratio_m_min must be from 0\.003 to 0\.012"):
        TrackingDetector(BeepDesign(), PHONE, walk_ratio_m_min=value)
