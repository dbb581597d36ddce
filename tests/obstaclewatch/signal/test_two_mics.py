"""Paths to ranges, and the direct sound that starts the clock."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch import PhoneGeometry
from obstaclewatch.paper.body_path import nearest_body_path
from obstaclewatch.signal.direct_sound import direct_sound, measured_direct_delay_s
from obstaclewatch.signal.matched_filter import MatchedFilter
from obstaclewatch.signal.two_mics import cone_cosine, one_way_range, ranges_of_pairs
from tests.obstaclewatch.synthetic import BEEP, PHONE, C, Point, record

FILTER = MatchedFilter(BEEP, 0.043)


@given(range_m=st.floats(0.3, 100.0), baseline_m=st.floats(0.0, 0.2), angle=st.floats(0.0, np.pi))
@settings(max_examples=50, deadline=None)
def test_the_triangle_is_solved_exactly(range_m, baseline_m, angle):
    speaker_leg = np.sqrt(range_m**2 + baseline_m**2 - 2.0 * range_m * baseline_m * np.cos(angle))
    solved = one_way_range(range_m + speaker_leg, baseline_m, np.cos(angle))
    assert float(solved) == pytest.approx(range_m, rel=1e-9)


def test_without_a_baseline_it_is_half_the_path():
    assert one_way_range([2.0, 5.0], 0.0).tolist() == [1.0, 2.5]


def test_a_path_shorter_than_the_baseline_has_no_range():
    assert np.isnan(one_way_range(0.05, 0.1))


def test_direct_sound_of_both_microphones():
    direct = direct_sound(FILTER.compress(record([])))
    assert direct.found
    assert direct.delay_s == pytest.approx(PHONE.speaker_to_mic_m / C, abs=1e-7)
    assert direct.amplitude[0] / direct.amplitude[1] == pytest.approx(10.0 / 4.0, rel=1e-3)


def test_direct_sound_is_not_found_where_it_is_not():
    shifted = np.roll(record([Point(3.0)]), 3000, axis=1)
    assert not direct_sound(FILTER.compress(shifted)).found
    assert not direct_sound(FILTER.compress(np.zeros((2, BEEP.period_samples)))).found
    with pytest.raises(ValueError, match="direct sound"):
        measured_direct_delay_s(shifted, BEEP)


def test_direct_delay_can_be_measured():
    assert measured_direct_delay_s(record([]), BEEP) == pytest.approx(0.03 / C, abs=1e-7)


def test_body_path_is_the_strongest_peak_behind_the_direct_sound():
    """A body 0.3 m behind the bottom microphone, on the line of a level phone."""
    body = Point(-0.3705, gain=1.0)
    path = nearest_body_path(FILTER.compress(record([body, Point(3.0)])), 0.0, (0.31, 1.7), C, 1e-4)
    assert path == pytest.approx((0.3705 + 0.0405) + 0.3, abs=2e-3)
    assert np.isnan(nearest_body_path(FILTER.compress(record([])), 0.0, (0.5, 1.7), C, 1e-3))


@given(
    path=st.floats(0.3, 20.0),
    bearing=st.floats(0.0, np.pi),
    baseline=st.floats(0.0, 0.12),
    cosine=st.floats(-1.0, 1.0),
)
@settings(max_examples=50, deadline=None)
def test_ranges_of_pairs_are_two_rounds_of_the_two_triangles(path, bearing, baseline, cosine):
    """Against whole arrays; a path difference of NaN counts as straight ahead, a path below the baseline as none."""
    path_m, u_m = np.array([path, path, 0.01, 4.0]), np.array([0.141 * np.cos(bearing), np.nan, 0.05, 3.0])
    range_m = path_m / 2.0
    for _ in range(2):
        toward = cone_cosine(range_m, range_m + u_m, 0.141)
        toward = np.where(np.isnan(toward), 1.0, np.clip(toward, -1.0, 1.0))
        range_m = one_way_range(path_m, baseline, cosine * toward)
    found = ranges_of_pairs(path_m, u_m, 0.141, baseline, cosine)
    assert np.isfinite(found[:2]).all()
    assert found == pytest.approx(range_m, rel=1e-13, nan_ok=True)


@pytest.mark.parametrize(
    ("speaker_m", "cosine"),
    [([0.0, 0.04, 0.0], -1.0), ([0.0, 0.1, 0.0], 1.0), ([0.03, 0.07, 0.0], 0.0), ([0.0, 0.07, 0.0], 0.0),
     ([0.03, 0.03, 0.0], -0.8)],
)  # fmt: skip
def test_where_the_speaker_is(speaker_m, cosine):
    phone = PhoneGeometry("flat", speaker_m, [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
    assert phone.speaker_cosine == pytest.approx(cosine)
