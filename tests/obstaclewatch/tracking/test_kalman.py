"""The filter written out for two numbers, against the matrices it stands for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch.tracking.kalman import begun, expected_reading, predicted, updated

AHEAD_S = 0.205


def _state(seed):
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((2, 2))
    return rng.uniform(0.5, 5.0, 2), root @ root.T + 0.01 * np.eye(2)


@given(seed=st.integers(0, 999), step=st.floats(0.0, 0.5), acceleration=st.floats(0.0, 2.0))
@settings(max_examples=50, deadline=None)
def test_prediction_is_the_matrix_product(seed, step, acceleration):
    state, covariance = _state(seed)
    move, jolt = np.array([[1.0, -step], [0.0, 1.0]]), acceleration * np.array([0.5 * step**2, -step])
    moved, spread = predicted(state, covariance, step, acceleration)
    assert moved == pytest.approx(move @ state, rel=1e-12, abs=1e-12)
    assert spread == pytest.approx(move @ covariance @ move.T + np.outer(jolt, jolt), rel=1e-12, abs=1e-12)


@given(seed=st.integers(0, 999), read_m=st.floats(0.3, 7.0), variance=st.floats(1e-4, 1.0))
@settings(max_examples=50, deadline=None)
def test_update_is_the_posterior_of_prior_and_reading(seed, read_m, variance):
    """In information form, which shares no step with the gain's."""
    state, covariance = _state(seed)
    look = np.array([1.0, -AHEAD_S])
    assert expected_reading(state, covariance, AHEAD_S) == pytest.approx((look @ state, look @ covariance @ look))
    information = np.linalg.inv(covariance)
    posterior = np.linalg.inv(information + np.outer(look, look) / variance)
    better, spread = updated(state, covariance, read_m, variance, AHEAD_S)
    assert better == pytest.approx(posterior @ (information @ state + look * read_m / variance), rel=1e-7, abs=1e-7)
    assert spread == pytest.approx(posterior, rel=1e-7, abs=1e-9)


def test_a_state_begins_as_the_least_squares_line():
    rng = np.random.default_rng(2)
    age, read_m = np.sort(rng.uniform(0.0, 1.1, 9))[::-1].copy(), rng.uniform(1.0, 3.0, 9)
    look = np.stack([np.ones(9), age - AHEAD_S], axis=1)  # what a state now read at each age
    state, covariance = begun(age, read_m, 0.02, AHEAD_S)
    assert state == pytest.approx(np.linalg.lstsq(look, read_m, rcond=None)[0], rel=1e-10)
    assert covariance == pytest.approx(0.02 * np.linalg.inv(look.T @ look), rel=1e-10)
