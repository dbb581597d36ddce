"""Walls that are still received: limits, and a count of walls drawn at random."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.trajectories.passed_walls import LEAST_RECEIVED, ends_of_passed, still_received

ENDS_M = ends_of_passed(0.25)


def test_what_is_no_wall_is_heard():
    assert still_received(np.inf, ENDS_M) == 1.0


def test_a_foot_beyond_all_ends_says_nothing():
    assert still_received(ENDS_M[1] + 0.01, ENDS_M) == 1.0


def test_a_foot_before_the_walker_is_hardly_of_a_wall_that_is_passed():
    assert still_received(0.15, ENDS_M) == LEAST_RECEIVED


def test_the_nearer_the_foot_the_fewer_are_heard():
    received = [still_received(ahead_m * np.sin(np.radians(35.0)), ENDS_M) for ahead_m in (2.5, 1.6, 1.3, 1.0, 0.7)]
    assert (np.diff(received) < 0.0).sum() >= 3
    assert sorted(received, reverse=True) == received


@pytest.mark.parametrize("angle_deg", [20.0, 30.0, 40.0])
def test_as_counted_on_walls_drawn_at_random(angle_deg):
    """Walls from their end outwards, half of them across the line: of those whose foot is on them, the share hit."""
    rng, foot_m = np.random.default_rng(1), 1.4 * np.sin(np.radians(angle_deg))
    hits = rng.random(400_000) < 0.5
    end_m = np.where(hits, -1.0, rng.uniform(*ENDS_M, len(hits)))
    counted = hits[foot_m > end_m].mean()
    assert 0.5 < counted < 1.0
    assert 1.0 / (1.0 + still_received(foot_m, ENDS_M)) == pytest.approx(counted, abs=0.004)
