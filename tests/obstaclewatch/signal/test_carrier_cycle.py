"""The carrier's cycle: phases of exact echoes, the right cycle as often as claimed, limits, and what is left alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from obstaclewatch import StandingDetector
from obstaclewatch.signal.carrier_cycle import CYCLES, DifferenceReadings, within_cycle
from obstaclewatch.signal.carrier_phase import phase_at
from obstaclewatch.signal.matched_filter import MatchedFilter
from tests.obstaclewatch.synthetic import BEEP, FULL_SCALE, PHONE, C, Point, noise_for, record, recording, true_range

CYCLE_M = C / BEEP.center_hz
POINTS = [Point(2.5), Point(2.0, 1.8), Point(1.0, 2.5), Point(0.3, 1.5)]


def difference_of(point):
    return true_range(point, 0.0, 0.0, mic=1) - true_range(point, 0.0, 0.0)


def phases(profile, delay_s, later_s):
    """(n,) phases of microphone 1 so much later than n delays at microphone 0, against it."""
    position = (delay_s - profile.start_s) * profile.rate_hz
    later = later_s * profile.rate_hz
    return np.array([phase_at(profile.envelope, one, one + more) for one, more in zip(position, later, strict=True)])


def within(phase_rad, envelope_m, std_m=0.003, longest_m=0.14):
    """One candidate through `within_cycle`."""
    one = np.ones(1)
    readings = DifferenceReadings(envelope_m * one, std_m * one, phase_rad * one, 0.1 * one, CYCLE_M)
    place, deviation = within_cycle(readings, longest_m * one)
    return float(place[0]), float(deviation[0])


@pytest.mark.parametrize("point", POINTS)
def test_phase_of_an_exact_echo_is_that_of_its_path_difference(point):
    """Asked up to a quarter of a pulse beside the peaks; without noise what is left is the linear interpolation."""
    profile = MatchedFilter(BEEP, 0.02).compress(record([point]))
    delay_s, difference_s = (2.0 * true_range(point, 0.0, 0.0) + 0.03 * 0.9) / C, difference_of(point) / C
    aside = np.array([-2e-5, 0.0, 2e-5])
    phase = phases(profile, delay_s + aside, difference_s - aside)
    rotated = phase + 2.0 * np.pi * profile.reference_hz * difference_s
    np.testing.assert_allclose(np.angle(np.exp(1j * rotated)), 0.0, atol=0.03)


@pytest.mark.parametrize("point", POINTS)
def test_the_detector_tells_the_difference_to_a_tenth_of_a_millimetre(point):
    (found,) = StandingDetector(BEEP, PHONE).stream(recording([point]))
    assert len(found) == 1
    assert found.range2_m[0] - found.range_m[0] == pytest.approx(difference_of(point), abs=1e-4)


@pytest.mark.parametrize(("snr_db", "fewest_right"), [(35.0, 0.94), (45.0, 0.99)])
def test_the_right_cycle_reaches_the_bound_of_the_carrier(snr_db, fewest_right):
    """Envelopes err by 1.9 mm at 35 dB, half a cycle is 8.4 mm; the carrier's bound is 67 um, 21 um at 45 dB."""
    point, rng = POINTS[1], np.random.default_rng(4)
    clean, level = record([point]), FULL_SCALE * noise_for(snr_db, POINTS[1].gain)
    detector, errors = StandingDetector(BEEP, PHONE, averaged_beeps=1), []
    for _ in range(200):
        found = detector.process(clean + level * rng.standard_normal(clean.shape))
        near = np.flatnonzero(np.abs(found.range_m - true_range(point, 0.0, 0.0)) < 0.06)
        assert len(near) == 1
        errors.append(found.range2_m[near[0]] - found.range_m[near[0]] - difference_of(point))
    right = np.abs(errors) < 0.25 * CYCLE_M
    bound = np.sqrt(2.0) * C / (2.0 * np.pi * BEEP.center_hz * 10.0 ** (snr_db / 20.0))
    assert right.mean() > fewest_right
    assert np.std(np.array(errors)[right]) < 1.3 * bound


def test_standing_bearings_follow_the_carrier():
    point = Point(2.0, 1.2)
    received = recording([point], beeps=16, noise=0.3)
    true = np.arctan2(1.2, 2.0 - PHONE.mics_m[0, 1])
    error = {}
    for phase in (0.0, None):
        found = list(StandingDetector(BEEP, PHONE, mic_phase_rad=phase).stream(received))
        assert len(found[-1]) >= 1
        k = int(np.argmin(np.abs(found[-1].range_m - true_range(point, 0.0, 0.0))))
        error[phase] = abs(found[-1].bearing_rad[k] - true)
        assert error[phase] < 3.0 * found[-1].bearing_std_rad[k]
    assert error[0.0] < np.deg2rad(0.2)
    assert error[None] > error[0.0]


def test_what_a_channel_adds_is_taken_off():
    profile = MatchedFilter(BEEP, 0.02).compress(record([POINTS[1]]) * np.array([[1.0], [-1.0]]))
    delay_s = np.array([(2.0 * true_range(POINTS[1], 0.0, 0.0) + 0.027) / C])
    (phase,) = phases(profile, delay_s, np.full(1, difference_of(POINTS[1]) / C))
    place, _ = within(phase - np.pi, difference_of(POINTS[1]))
    assert place == pytest.approx(difference_of(POINTS[1]), abs=1e-4)


def test_too_wide_envelopes_stay_as_they_are():
    assert within(1.0, 0.05, std_m=0.02) == (0.05, 0.02)


def test_unheard_stays_unheard():
    place, std = within(np.nan, np.nan)
    assert np.isnan(place)
    assert within(np.nan, 0.05, std_m=0.003) == (0.05, 0.003)
    assert np.isfinite(std)


def test_nothing_is_further_behind_than_straight_ahead():
    """Half a cycle off both ways, the one that is possible wins; not told so, neither does."""
    middle = 0.14 + 0.4 * CYCLE_M
    phase = -2.0 * np.pi * (middle + 0.5 * CYCLE_M) / CYCLE_M
    place, std = within(phase, middle, longest_m=0.14)
    assert place == pytest.approx(middle - 0.5 * CYCLE_M)
    assert within(phase + 0.01, middle, longest_m=1.0)[1] > std


@given(st.floats(-np.pi, np.pi), st.floats(-0.15, 0.15), st.floats(5e-4, 0.03), st.floats(0.05, 0.16))
def test_a_choice_keeps_the_phase_and_never_claims_less_than_it(phase, envelope, std, longest):
    place, deviation = within(phase, envelope, std, longest)
    assert abs(place - envelope) <= (CYCLES[-1] + 0.5) * CYCLE_M + 1e-12
    assert deviation >= min(std, 0.1 / (2.0 * np.pi) * CYCLE_M)
    if place != envelope:
        assert np.cos(phase + 2.0 * np.pi * place / CYCLE_M) == pytest.approx(1.0, abs=1e-9)


def test_a_phase_that_is_no_number_is_an_error():
    with pytest.raises(ValueError, match="mic_phase_rad must be finite or None, got nan"):
        StandingDetector(BEEP, PHONE, mic_phase_rad=np.nan)
