"""Sums along walked paths: against plain loops, on echoes too weak for any one beep, and where something stands."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.tracking.approach_sums import (
    AHEAD_M,
    LEAST_BEEPS,
    MEMORY_BEEPS,
    NO_SUMS,
    NOTHING,
    ApproachMemory,
    _best_sums,
)
from obstaclewatch.walker.pitch_oscillation import STEADY
from obstaclewatch.walker.walking_speed import WALKER_M_S

CELL_M, FIRST_M, CELLS, GROUND_M, AHEAD_S, PERIOD_S, SPEED_M_S = 0.0143, 0.3, 460, 1.3, 0.205, 0.09, 1.25


def _sums(miss_m, height_m=0.0, power=4.0, standing=0.0, beeps=24, seed=3, end_m=0.8, speed_m_s=SPEED_M_S):
    """After a walk that ends with a point so far ahead, in noise of power 1."""
    rng, memory = np.random.default_rng(seed), ApproachMemory(CELLS, 2 * CELLS)
    time_s = PERIOD_S * np.arange(beeps)
    for now_s in time_s:
        received = (rng.standard_normal(2 * CELLS) + 1j * rng.standard_normal(2 * CELLS)) / np.sqrt(2.0)
        along_m = end_m + speed_m_s * (time_s[-1] - now_s - AHEAD_S)
        at = round(2.0 * (np.sqrt(along_m**2 + miss_m**2 + height_m**2) - FIRST_M) / CELL_M)
        if 2 <= at < 2 * CELLS - 2:
            received[at - 2 : at + 2] += np.sqrt(power) * np.exp(2j * np.pi * rng.random())
        received[100:110] += np.sqrt(standing) * np.exp(2j * np.pi * rng.random())
        memory.add(now_s, np.array([received, received]))
    return memory.sums(time_s[-1], FIRST_M, CELL_M, GROUND_M, STEADY, WALKER_M_S, AHEAD_S)


@pytest.mark.parametrize("height_m", [0.0, 0.5, 1.3])
def test_a_weak_collision_adds_up_at_its_place(height_m):
    found = np.array([_sums(0.0, height_m, seed=seed) for seed in range(6)])
    assert np.median(found[:, 0]) > 12.0
    assert np.median(np.abs(found[:, 4] - 0.8)) < 0.16


def test_a_collision_and_a_miss_differ():
    hits = [_sums(0.0, seed=seed) for seed in range(8)]
    misses = [_sums(1.0, seed=seed) for seed in range(8)]
    assert np.median([s.hit - s.passing for s in hits]) > 4.0
    assert np.median([s.hit - s.passing for s in misses]) < -4.0


def test_who_comes_the_other_way_is_another_sum():
    coming = [_sums(0.0, seed=seed, speed_m_s=2.0 * SPEED_M_S, end_m=1.6) for seed in range(8)]
    assert np.median([s.oncoming - max(s.hit, s.oncoming_passing) for s in coming]) > 4.0


def test_noise_alone_and_what_stands_there_add_up_to_little():
    quiet = np.median([_sums(0.0, power=0.0, seed=seed).hit for seed in range(8)])
    beside = np.median([_sums(0.0, power=0.0, standing=400.0, seed=seed).hit for seed in range(8)])
    assert quiet < 9.0
    assert beside < quiet + 3.0


def test_few_beeps_and_a_cleared_memory_say_nothing():
    memory = ApproachMemory(CELLS, 2 * CELLS)
    for beep in range(LEAST_BEEPS):
        memory.add(PERIOD_S * beep, np.ones((2, 2 * CELLS)))
    place = FIRST_M, CELL_M, GROUND_M, STEADY, WALKER_M_S, AHEAD_S
    assert memory.sums(1.0, *place) is NO_SUMS
    for beep in range(LEAST_BEEPS, 2 * LEAST_BEEPS):
        memory.add(PERIOD_S * beep, np.ones((2, 2 * CELLS)))
    assert memory.sums(1.0, *place).hit > NOTHING
    memory.clear()
    assert memory.sums(1.0, *place) is NO_SUMS


def test_best_sums_are_those_of_plain_loops():
    rng = np.random.default_rng(0)
    ratio, age_s, waves = rng.normal(size=(12, 200)), PERIOD_S * np.arange(12), 0.01 * rng.normal(size=(3, 12))
    heights_m, misses_m, speeds = np.array([0.0, 0.4]), np.array([0.0, 0.9]), np.linspace(0.8, 1.2, 7)
    best = {}
    for miss_m in misses_m:
        for height_m in heights_m:
            for ahead_m in AHEAD_M:
                for speed in speeds:
                    along_m = ahead_m * max(speed, 1.0) + speed * SPEED_M_S * age_s
                    range_m = np.sqrt(along_m**2 + miss_m**2 + height_m**2)
                    read_m = range_m + (height_m * waves[1] - along_m * waves[2]) / range_m
                    cell = np.floor((read_m - FIRST_M) / CELL_M + 0.5).astype(int)
                    inside = (cell >= 0) & (cell < 200)
                    total = np.cumsum(np.where(inside, ratio[np.arange(12), np.clip(cell, 0, 199)], 0.0))
                    best[miss_m] = max(best.get(miss_m, NOTHING), total[LEAST_BEEPS - 1 :].max())
    found = _best_sums(ratio, age_s, waves, SPEED_M_S, FIRST_M, CELL_M, AHEAD_M, heights_m, misses_m, speeds)
    assert found[:4] == pytest.approx((best[0.0], best[0.9], NOTHING, NOTHING))


def test_the_last_beeps_come_newest_first_over_their_usual_size():
    memory, rng = ApproachMemory(CELLS, 2 * CELLS), np.random.default_rng(1)
    given = [rng.normal(size=(2, 2 * CELLS)) * [[1.0], [0.1]] for _ in range(MEMORY_BEEPS + 7)]
    for beep, moved in enumerate(given):
        memory.add(PERIOD_S * beep, moved)
    found = memory.recent(FIRST_M, CELL_M)
    assert found.time_s == pytest.approx(PERIOD_S * np.arange(MEMORY_BEEPS + 6, 6, -1))
    assert np.median(np.abs(found.envelope), axis=2) == pytest.approx(np.ones((MEMORY_BEEPS, 2)))
    usual = np.median(np.abs(given[-1]), axis=1, keepdims=True)
    assert found.envelope[0] == pytest.approx(given[-1] / usual, rel=1e-6)
    assert found.ratio.shape == (MEMORY_BEEPS, CELLS)


def test_beeps_without_noise_stay_finite():
    memory, echo = ApproachMemory(CELLS, 2 * CELLS), np.zeros((2, 2 * CELLS))
    for beep in range(LEAST_BEEPS):
        memory.add(PERIOD_S * beep, echo)
    echo[:, 40] = 1e-3
    memory.add(PERIOD_S * LEAST_BEEPS, echo)
    assert np.isfinite(memory.recent(FIRST_M, CELL_M).envelope).all()
