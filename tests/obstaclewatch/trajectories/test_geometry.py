"""Compiled trajectories against points and phones in space."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch.trajectories.geometry import cone_cosine, distance_ahead, sight, steady_range
from obstaclewatch.trajectories.likelihood import Bodies, path_differences, straight_lines, weighted_sum
from obstaclewatch.walker.gait import READING_M, line_weights, reading_covariance, whitening

L = 0.141
EXACT = 2e-6
"""Single precision at 6 m, m."""


def _single(*values):
    return tuple(np.float32(value) for value in values)


def _bodies(height=0.0, radius=0.0, miss=0.0, cos_angle=1.0, stays=1.0, along=0.0, up=0.0):
    columns = np.broadcast_arrays(height, radius, miss, cos_angle, stays, along, up)
    return Bodies(*(np.atleast_1d(column).astype(np.float32) for column in columns))


@given(
    ahead=st.floats(0.3, 6.0),
    miss=st.floats(0.0, 1.5),
    height=st.floats(0.0, 1.4),
    rise=st.floats(-0.03, 0.03),
    pitch=st.floats(-0.8, 0.8),
)
@settings(max_examples=60, deadline=None)
def test_a_point_is_seen_where_it_is(ahead, miss, height, rise, pitch):
    """Range, cosine and path difference from coordinates: a body without radius, microphone 1 behind along the axis."""
    point, axis = np.array([ahead, miss, -height - rise]), np.array([np.cos(pitch), 0.0, np.sin(pitch)])
    seen = sight(*_single(ahead, height + rise, 0.0, miss, 1.0))
    near, far = np.linalg.norm(point), np.linalg.norm(point + L * axis)
    assert seen[0] == pytest.approx(near, abs=EXACT)
    cosine = cone_cosine(*seen, *_single(height + rise, np.cos(pitch), np.sin(pitch)))
    assert cosine == pytest.approx(point @ axis / near, abs=1e-6)
    line, u_m = np.array([ahead], dtype=np.float32), np.empty(1, dtype=np.float32)
    path_differences(u_m, _bodies(height, miss=miss), line, pitch, rise, L)
    assert u_m[0] == pytest.approx(far - near, abs=EXACT)


@given(ahead=st.floats(0.5, 6.0), miss=st.floats(0.0, 1.5), height=st.floats(0.0, 1.4), radius=st.floats(0.0, 0.3))
@settings(max_examples=60, deadline=None)
def test_distance_ahead_undoes_the_range(ahead, miss, height, radius):
    body = _single(height, radius, miss)
    range_m = sight(np.float32(ahead), *body, np.float32(1.0))[0]
    assert distance_ahead(range_m, *body) == pytest.approx(ahead, abs=10.0 * EXACT)


def test_what_cannot_be_seen_has_the_least_distance():
    assert distance_ahead(*_single(0.5, 1.0, 0.0, 2.0)) == np.float32(0.05)


def test_a_lift_lengthens_what_lies_below_and_a_surge_shortens_all():
    """A millimetre of each, to first order, at 45 degrees below and for a thing that is as high as the phone."""
    down = np.sqrt(0.5)
    assert steady_range(*_single(1.0, 1e-3, 0.0, down, 1.0)) == pytest.approx(1.0 - 1e-3 * down, abs=1e-7)
    surged = steady_range(*_single(2.0, 0.0, -1e-3, down, 1.0))
    assert surged == pytest.approx(2.0 - 1e-3 * np.sqrt(1.0 - (down / 2.0) ** 2), abs=3e-7)
    assert steady_range(*_single(1.0, 0.0, 0.0, 0.0, 1.0)) == 1.0
    assert steady_range(*_single(2.0, 0.0, -1e-3, 0.0, 1.0)) == pytest.approx(2.0 - 1e-3, abs=3e-7)


def test_lines_are_generalised_least_squares():
    """Against the normal equations with the inverse of the covariance, on the readings of a walk towards a point."""
    rng = np.random.default_rng(4)
    time_s = 0.09 * np.arange(-19, 1)
    covariance = reading_covariance(time_s, rng.uniform(0.001, 0.01, 20), READING_M)
    white = whitening(covariance)
    assert white @ covariance @ white.T == pytest.approx(np.eye(20), abs=1e-9)
    assert np.all(np.triu(white, 1) == 0.0)
    read_m = 1.5 - 1.2 * time_s + 0.02 * rng.standard_normal(20)
    design, precision = np.stack([np.ones(20), -time_s], axis=1), np.linalg.inv(covariance)
    expected = np.linalg.solve(design.T @ precision @ design, design.T @ precision @ read_m)
    weights = line_weights(time_s, white)
    assert [weights[0] @ read_m, weights[1] @ read_m] == pytest.approx(list(expected), abs=1e-9)
    ahead, closing = straight_lines(_bodies(), read_m[:, None].astype(np.float32), *weights)
    assert [ahead[0], closing[0]] == pytest.approx(list(expected), abs=1e-5)
    left = read_m - design @ expected
    misfit, white_error = 0.0, np.empty(1, dtype=np.float32)
    for row in range(20):
        weighted_sum(white_error, left[:, None].astype(np.float32), white[row], row + 1)
        misfit += white_error[0] ** 2
    assert misfit == pytest.approx(left @ precision @ left, rel=1e-4)
