"""Beeps whose samples are damaged, told by noise late in their period, and none that are whole."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.signal.damaged_beeps import DamagedBeeps, noise_heights
from obstaclewatch.signal.direct_sound import direct_sound
from obstaclewatch.signal.matched_filter import MatchedFilter
from tests.obstaclewatch.synthetic import BEEP, C, Point, record

PERIOD = BEEP.period_samples
FILTER = MatchedFilter(BEEP, 2.0 * 7.0 / C + 2e-3)
GROUND = Point(1.3, gain=0.3, carried=True, bob_m=0.02)
NOISE = 0.02
WALK = record([GROUND, Point(5.0, gain=0.1)], beeps=14, speed_m_s=1.3, noise=NOISE)


def _damaged(samples):
    damage, found = DamagedBeeps(), []
    for block in np.split(samples[:, : samples.shape[1] // PERIOD * PERIOD], samples.shape[1] // PERIOD, axis=1):
        profile = FILTER.compress(block)
        found.append(damage.found(profile, direct_sound(profile)))
        if damage.was_first:
            found[-2] = True
    return np.flatnonzero(found).tolist()


def _clicked(beep, place, height=42.0):
    samples = WALK.copy()
    samples[:, beep * PERIOD + place] = height * np.abs(WALK).max()
    return samples


@pytest.mark.parametrize("place", [0, 3_000, 6_000, 7_500, 9_000, 12_000, 17_000])
def test_a_click_is_found_wherever_it_falls(place):
    assert _damaged(_clicked(9, place)) == [9]


def test_a_click_in_one_channel_is_found():
    samples = WALK.copy()
    samples[1, 9 * PERIOD + 5_000] = 42.0 * np.abs(WALK).max()
    assert _damaged(samples) == [9]


@pytest.mark.parametrize("beep", [0, 1, 2, 13])
def test_a_click_is_found_in_the_first_and_the_last_beeps(beep):
    assert _damaged(_clicked(beep, 9_000)) == [beep]


@pytest.mark.parametrize("first", [2_000, 5_000, 7_200])
def test_zeros_that_cut_a_beep_or_replace_all_after_it_are_found(first):
    samples = WALK.copy()
    samples[:, 9 * PERIOD + first : 9 * PERIOD + first + 10_000] = 0.0
    assert _damaged(samples) == [9]


def test_drops_and_a_lost_sample_are_found():
    samples = WALK.copy()
    for place in range(500, PERIOD, 1_700):
        samples[:, 9 * PERIOD + place : 9 * PERIOD + place + 200] = 0.0
    assert _damaged(samples) == [9]
    assert _damaged(np.delete(WALK, 9 * PERIOD + 4_000, axis=1)) == [9]


@pytest.mark.parametrize("noise", [0.0, 1e-4, 0.02, 1.0])
def test_whole_beeps_are_not_damaged(noise):
    near = [GROUND, Point(1.9, gain=3.0), Point(5.0, 0.8, gain=0.3)]
    assert _damaged(record(near, beeps=14, speed_m_s=1.3, noise=noise)) == []


@pytest.mark.parametrize("ahead_m", [0.3, 0.5, 1.5])
def test_what_is_suddenly_there_is_no_damage(ahead_m):
    """A wall behind a corner, a person who steps in: an echo as loud as that of a wall from one beep to the next."""
    samples, other = (record([GROUND, *more], beeps=14, noise=NOISE) for more in ([], [Point(ahead_m, gain=3.0)]))
    samples[:, 9 * PERIOD :] = other[:, 9 * PERIOD :]
    assert _damaged(samples) == []


def test_noise_that_stays_is_usual_after_five_beeps():
    loud = record([GROUND], beeps=20, noise=20.0 * NOISE, seed=1)
    samples = np.hstack([record([GROUND], beeps=9, noise=NOISE), loud, record([GROUND], beeps=9, noise=NOISE)])
    assert _damaged(samples) == [9, 10, 11, 12, 13]


def test_a_period_without_room_for_noise_is_never_damaged():
    profile = MatchedFilter(BEEP, 0.03, block_samples=round(0.05 * BEEP.sample_rate_hz)).compress(WALK[:, :9_600])
    assert noise_heights(profile).shape == (2, 3)
    short = MatchedFilter(BEEP, 0.02).compress(WALK[:, :PERIOD])
    assert noise_heights(short).shape == (2, 13)
