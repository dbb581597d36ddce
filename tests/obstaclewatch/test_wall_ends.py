"""Walls that are still heard: limits, and a count of walls drawn at random."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.wall_ends import LEAST_HEARD, ends_of_passed, of_those_heard

ENDS_M = ends_of_passed(0.25)


def _heard(aside, ahead_m, collision=0.5):
    """Shares and probabilities of a collision of a wall and of something else, as likely as each other before."""
    rows = np.array([0.5, 0.5]), np.array([collision, collision]), np.array([aside, np.inf])
    return of_those_heard(*rows, np.array([ahead_m, 1.0], dtype=np.float32), ENDS_M)


def test_what_is_no_wall_keeps_its_probability():
    share, hit = _heard(0.5, 1.0)
    assert hit[1] == 0.5
    assert share.sum() == pytest.approx(1.0)


def test_a_foot_beyond_all_ends_says_nothing():
    share, hit = _heard(0.9, 3.0)
    np.testing.assert_allclose((*share, *hit), 0.5)


def test_a_foot_before_the_walker_is_of_a_wall_that_is_hit():
    _, hit = _heard(0.1, 1.5)
    assert hit[0] == pytest.approx(1.0 / (1.0 + LEAST_HEARD))


def test_a_wall_that_is_still_heard_is_likelier_hit_the_nearer_it_is():
    hits = [_heard(np.sin(np.radians(35.0)), ahead_m)[1][0] for ahead_m in (2.5, 1.6, 1.3, 1.0, 0.7)]
    assert (np.diff(hits) > 0.0).sum() >= 3
    assert sorted(hits) == hits


@pytest.mark.parametrize("angle_deg", [20.0, 30.0, 40.0])
def test_as_counted_on_walls_drawn_at_random(angle_deg):
    """Walls from their end outwards, half of them across the line: of those whose foot is on them, the share hit."""
    rng, aside, ahead_m = np.random.default_rng(1), np.sin(np.radians(angle_deg)), 1.4
    hits = rng.random(400_000) < 0.5
    end_m = np.where(hits, -1.0, rng.uniform(*ENDS_M, len(hits)))
    counted = hits[aside * ahead_m > end_m].mean()
    assert 0.5 < counted < 1.0
    assert _heard(aside, ahead_m)[1][0] == pytest.approx(counted, abs=0.004)
