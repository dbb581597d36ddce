"""Compiled courses against points and phones in space."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch.course_geometry import as_seen, distances_ahead, path_differences, steady_ranges

L = 0.141
ONE, NONE = np.ones(1), np.zeros(1)


@given(
    ahead=st.floats(0.3, 6.0),
    miss=st.floats(0.0, 1.5),
    height=st.floats(0.0, 1.4),
    lift=st.floats(-0.03, 0.03),
    pitch=st.floats(-0.8, 0.8),
)
@settings(max_examples=60, deadline=None)
def test_a_point_is_seen_where_it_is(ahead, miss, height, lift, pitch):
    """Range, cosine and path difference from coordinates: a body without radius, microphone 1 behind along the axis."""
    point, axis = np.array([ahead, miss, -height - lift]), np.array([np.cos(pitch), 0.0, np.sin(pitch)])
    range_m, cosine = as_seen(
        np.array([[ahead]]), np.array([pitch]), np.array([lift]), np.array([height]), NONE, np.array([miss]), ONE, ONE
    )
    near, far = np.linalg.norm(point), np.linalg.norm(point + L * axis)
    assert range_m[0, 0] == pytest.approx(near, rel=1e-12)
    assert cosine[0, 0] == pytest.approx(point @ axis / near, abs=1e-12)
    assert path_differences(range_m, cosine, L)[0, 0] == pytest.approx(far - near, abs=1e-12)


@given(ahead=st.floats(0.5, 6.0), miss=st.floats(0.0, 1.5), height=st.floats(0.0, 1.4), radius=st.floats(0.0, 0.3))
@settings(max_examples=60, deadline=None)
def test_distance_ahead_undoes_the_range(ahead, miss, height, radius):
    body = np.array([height]), np.array([radius]), np.array([miss])
    range_m, _ = as_seen(np.array([[ahead]]), NONE, NONE, *body, ONE, NONE)
    assert distances_ahead(range_m, *body)[0, 0] == pytest.approx(ahead, rel=1e-9)


def test_what_cannot_be_seen_has_the_least_distance():
    assert distances_ahead(np.array([[0.5]]), np.array([1.0]), NONE, np.array([2.0]))[0, 0] == 0.05


def test_a_lift_lengthens_what_lies_below_and_a_surge_shortens_all():
    """A millimetre of each, to first order, at 45 degrees below and for a thing that is as high as the phone."""
    range_m, height_m = np.array([1.0, 2.0]), np.array([np.sqrt(0.5), 0.0])
    swing = np.array([1e-3, 0.0]), np.array([0.0, -1e-3])
    steady = steady_ranges(range_m, *swing, height_m, np.ones(2), np.array([1.0, 0.0]))
    down = np.sqrt(0.5)
    assert steady[0] == pytest.approx([1.0 - 1e-3 * down, 2.0 - 1e-3 * np.sqrt(1.0 - (down / 2.0) ** 2)], abs=1e-12)
    assert steady[1] == pytest.approx([1.0, 2.0 - 1e-3], abs=1e-12)
