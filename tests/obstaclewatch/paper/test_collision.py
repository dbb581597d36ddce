"""Eq. 4, the vote and the dangerous distance (paper section 3.6)."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.paper.collision import CollisionVote, decide, on_collision_course, on_collision_course_printed


@pytest.mark.parametrize(
    ("miss_m", "radius_m", "collides"),
    [
        (0.0, 0.0, True),
        (0.24, 0.0, True),
        (0.26, 0.0, False),
        (0.4, 0.2, True),
        (0.46, 0.2, False),
        (0.2, np.nan, True),
    ],
)
def test_the_swept_body_decides(miss_m, radius_m, collides):
    bearing = np.arcsin(miss_m / 3.0)
    answer = on_collision_course(np.array([3.0]), np.array([bearing]), np.array([radius_m]), 0.25)
    assert answer.tolist() == [collides]


def test_behind_or_unknown_is_no_collision():
    answer = on_collision_course(np.full(2, 1.0), np.array([np.pi, np.nan]), np.zeros(2), 0.25)
    assert not answer.any()


def test_printed_rule_compares_angles():
    """Erratum `walker_width`."""
    assert on_collision_course_printed(np.array([0.1, 0.1, 0.1]), np.array([0.1, 0.05, np.nan])).tolist() == [
        True,
        False,
        False,
    ]


def _run(collisions, range_m=2.0):
    vote = CollisionVote(5, 9)
    return [
        decide(vote, 0.09 * k, np.array([range_m]), np.array([1.0]), np.array([hit]), 3.0)
        for k, hit in enumerate(collisions)
    ]


def test_five_of_nine():
    decisions = _run([True, False, True, False, True, False, True, False, True])
    assert [decision.alert for decision in decisions] == [False] * 8 + [True]
    assert decisions[-1].votes == 5
    assert not any(decision.alert for decision in _run([True, False, False] * 10))


def test_the_tenth_beep_is_forgotten():
    votes = [decision.votes for decision in _run([True] * 9 + [False] * 9)]
    assert votes == [*range(1, 10), *range(8, -1, -1)]


def test_no_alert_beyond_the_dangerous_distance():
    assert not any(decision.alert for decision in _run([True] * 9, range_m=3.1))
    assert _run([True] * 9, range_m=2.9)[-1].alert


def test_range_and_time_are_those_of_the_nearest_that_collides():
    decision = decide(
        CollisionVote(1, 1),
        0.0,
        np.array([1.0, 2.0, 2.5]),
        np.array([1.0, 1.25, 1.0]),
        np.array([False, True, True]),
        3.0,
    )
    assert decision.alert
    assert decision.range_m == 2.0
    assert decision.time_to_collision_s == pytest.approx(1.6)
    quiet = decide(CollisionVote(1, 1), 0.0, np.empty(0), np.empty(0), np.empty(0, bool), 3.0)
    assert not quiet.alert
    assert np.isnan(quiet.range_m)
