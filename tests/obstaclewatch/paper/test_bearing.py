"""Law of cosines, pitch, and the detour by way of the walker's body."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch.paper.bearing import bearing_std, body_distance, deducted_difference, path_difference, walking_angle
from obstaclewatch.signal.two_mics import cone_cosine

L = 0.141


@given(range_m=st.floats(0.3, 10.0), bearing=st.floats(0.0, np.pi))
@settings(max_examples=50, deadline=None)
def test_law_of_cosines_is_inverted_exactly(range_m, bearing):
    """Eq. 2, corrected, on a triangle built from its angle; arccos loses half the digits near 0 and pi."""
    range2 = np.sqrt(range_m**2 + L**2 + 2.0 * range_m * L * np.cos(bearing))
    angle, _ = walking_angle(cone_cosine([range_m], [range2], L))
    assert angle[0] == pytest.approx(bearing, abs=1e-6)


def test_equals_equation_2_as_printed_where_that_has_a_value():
    d1, d2 = 3.0, 3.1
    printed = np.pi - np.arccos((d1**2 + L**2 - d2**2) / (2.0 * d1 * L))
    angle, clamped = walking_angle(cone_cosine([d1], [d2], L))
    assert angle[0] == pytest.approx(printed, abs=1e-12)
    assert not clamped[0]


def test_outside_the_domain_it_is_clamped_and_flagged():
    """Erratum `clamped_angle`: 5 mm too much of u leaves arccos's domain."""
    cosine = cone_cosine([3.0, 3.0], [3.0 + L + 0.005, 3.0 - L - 0.005], L)
    angle, clamped = walking_angle(cosine)
    assert angle == pytest.approx([0.0, np.pi])
    assert clamped.all()
    printed, clamped = walking_angle(cosine, clamped=False)
    assert np.isnan(printed).all()
    assert not clamped.any()


@given(azimuth=st.floats(0.01, 1.5), pitch=st.floats(-1.2, 1.2))
@settings(max_examples=50, deadline=None)
def test_pitch_turns_a_cone_angle_into_an_azimuth(azimuth, pitch):
    axis = np.array([np.cos(pitch), 0.0, np.sin(pitch)])
    toward = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    angle, _ = walking_angle(np.array([axis @ toward]), float(np.cos(pitch)))
    assert angle[0] == pytest.approx(azimuth, abs=1e-6)


@given(azimuth=st.floats(0.0, 1.4), distance=st.floats(0.05, 0.8), pitch=st.floats(-1.0, 1.0))
@settings(max_examples=50, deadline=None)
def test_detour_is_deducted_exactly_for_a_plane_body(azimuth, distance, pitch):
    """Plane wave from an azimuth, body a plane behind the microphone: its image microphone receives it 2 d cos a
    late."""
    toward = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    top = L * np.array([np.cos(pitch), 0.0, np.sin(pitch)])
    image = np.array([-2.0 * distance, 0.0, 0.0])
    gap, u = (top - image) @ toward, top @ toward
    assert deducted_difference(gap, L, distance, float(np.cos(pitch))) == pytest.approx(u, abs=1e-12)


@given(distance=st.floats(0.05, 0.8), pitch=st.floats(-1.0, 1.0))
@settings(max_examples=50, deadline=None)
def test_body_distance_from_the_direct_sounds_echo(distance, pitch):
    """Speaker at the top end: its way to the bottom microphone's image, less the phone's length."""
    way = np.hypot(L * np.cos(pitch) + 2.0 * distance, L * np.sin(pitch))
    assert body_distance(way - L, L, float(np.cos(pitch))) == pytest.approx(distance, rel=1e-9)


def test_printed_detour_is_half_of_it():
    """Erratum `whole_detour`: straight ahead u should be L; deducting the distance once leaves it d too long."""
    gap = L + 2.0 * 0.3
    assert float(deducted_difference(gap, L, 0.3)) == pytest.approx(L)
    assert float(deducted_difference(gap, L, 0.3, whole_detour=False)) == pytest.approx(L + 0.3)


def _pair(path2, amplitude2, body=np.nan, **switches):
    least = np.array([0.05])
    path1, path2, amplitude2 = np.array([6.0]), np.array(path2), np.array(amplitude2)
    return path_difference(path1, path2, amplitude2, L, 0.03, lambda: body, least, **switches)


def test_gate_prefers_what_can_be_the_obstacle_to_what_is_louder():
    """Erratum `gated_second_mic`: the peak by way of the body is louder, but lies beyond +-L."""
    gated = _pair([6.1, 6.7], [0.1, 1.0], body=0.3)
    assert gated.u_m[0] == pytest.approx(0.1)
    assert not gated.body_deducted[0]
    printed = _pair([6.1, 6.7], [0.1, 1.0], body=0.3, gated=False)
    assert printed.body_deducted[0]
    assert printed.u_m[0] == pytest.approx(0.7 * L / (L + 0.6))


def test_body_is_deducted_when_nothing_else_is_there():
    by_body = _pair([6.7], [1.0], body=0.3)
    assert by_body.body_deducted[0]
    assert by_body.u_m[0] == pytest.approx(0.7 * L / (L + 0.6))


def test_sidelobes_are_too_weak_to_be_the_obstacle():
    """A spurious peak at -30 dB inside the gate does not keep the one by way of the body from being found."""
    assert _pair([6.1, 6.7], [0.04, 1.0], body=0.3).body_deducted[0]


@pytest.mark.parametrize(("path2", "body"), [([6.7], np.nan), ([], 0.3), ([5.0, 9.0], 0.3)])
def test_no_partner_is_nan(path2, body):
    pair = _pair(path2, [1.0] * len(path2), body=body)
    assert np.isnan(pair.u_m).all()
    assert not pair.body_deducted.any()


def test_bearing_std_is_first_order_and_stays_finite():
    """sqrt(u / L) straight ahead; u / (L sin) to the side."""
    std = bearing_std(np.radians([0.0, 10.0, 90.0]), np.array([0.35e-3, 2.1e-3, 2.1e-3]), L)
    assert np.degrees(std[0]) == pytest.approx(2.9, abs=0.1)
    assert np.degrees(std[1]) == pytest.approx(4.0, abs=0.1)
    assert std[2] == pytest.approx(2.1e-3 / L, rel=0.01)
