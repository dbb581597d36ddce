"""Bearings of what lies at any height: one cone both ways, a slow posterior, calibration, limits, rendered corners."""

import numpy as np
import pytest

from obstaclewatch import PaperSettings, StandingDetector
from obstaclewatch.paper.bearing import walking_angle
from obstaclewatch.recording import Recording
from obstaclewatch.signal.carrier_cycle import CYCLES, DifferenceReadings
from obstaclewatch.signal.matched_filter import MatchedFilter
from obstaclewatch.signal.two_mics import cone_cosine, path_difference_at, ranges_of_pairs
from obstaclewatch.standing.bearing_posterior import BEARINGS_RAD, HEIGHT_PRIOR, HEIGHTS_M, Attitude, bearing_posterior
from obstaclewatch.walker.ground_height import HELD_HEIGHTS_M as HELD_M
from obstaclewatch.walker.ground_height import GroundFinder
from tests.obstaclewatch.pitched import (
    HEIGHT_M,
    LENGTH,
    PITCH,
    by_ground,
    by_wall,
    recorded,
    transducers,
    way_m,
)
from tests.obstaclewatch.synthetic import BEEP, PHONE, C

CYCLE_M = C / BEEP.center_hz
ATTITUDE = Attitude(np.sin(PITCH), np.cos(PITCH), HEIGHT_M, LENGTH)
AHEAD_M = PHONE.speaker_m[1] - PHONE.mics_m[0, 1]
STANDING = PaperSettings(near_m=0.6)
GROUND = (way_m(by_ground), (0.05, 0.1))


def readings_of(u_m, envelope_std_m=0.004, phase_std_rad=0.3, seed=None):
    """Likelihood of path differences as exact as can be, or with noise of those deviations."""
    u = np.atleast_1d(np.asarray(u_m, dtype=float))
    rng, amount = np.random.default_rng(seed), float(seed is not None)
    envelope = u + amount * envelope_std_m * rng.standard_normal(len(u))
    phase = -2.0 * np.pi * u / CYCLE_M + amount * phase_std_rad * rng.standard_normal(len(u))
    one = np.ones(len(u))
    return DifferenceReadings(
        envelope, envelope_std_m * one, np.angle(np.exp(1j * phase)), phase_std_rad * one, CYCLE_M
    )


def seen(range_m, height_m, bearing_rad, image=2.0, attitude=ATTITUDE):
    """Path difference of what lies that far below the phone, by coordinates."""
    down = height_m / range_m
    along = np.sqrt(1.0 - down**2) * np.array([np.cos(bearing_rad), np.sin(bearing_rad)])
    point = image * range_m * np.array([*along, -down])
    second = -attitude.separation_m * np.array([attitude.cos_pitch, 0.0, attitude.sin_pitch])
    return np.linalg.norm(point - second) - np.linalg.norm(point)


def test_difference_is_that_of_coordinates():
    for height_m in (0.0, 0.6, HEIGHT_M):
        for bearing in (0.0, 0.7, 1.5):
            down = height_m / 2.0
            cosine = np.sqrt(1.0 - down**2) * np.cos(bearing) * ATTITUDE.cos_pitch - down * ATTITUDE.sin_pitch
            assert path_difference_at(2.0, cosine, LENGTH) == pytest.approx(
                seen(2.0, height_m, bearing, 1.0), abs=1e-12
            )


@pytest.mark.parametrize("range_m", [1.9, 3.3, 5.2])
def test_a_corner_straight_ahead_shares_its_cone_with_things_aside(range_m):
    """The level reading is the other way out; every bearing being alike, straight ahead is the likelier."""
    u_m = seen(range_m, HEIGHT_M, 0.0)
    cosine = np.cos(PITCH + np.arcsin(HEIGHT_M / range_m))
    aside = np.arccos(cosine / ATTITUDE.cos_pitch)
    assert seen(range_m, 0.0, aside) == pytest.approx(u_m, abs=1e-12)
    assert aside > np.deg2rad(30.0)
    bearing, std, _ = bearing_posterior(np.array([range_m]), readings_of(u_m), ATTITUDE)
    assert bearing[0] < 0.5 * aside
    assert aside - bearing[0] < 4.0 * std[0]


@pytest.mark.parametrize("bearing_deg", [0.0, 10.0, 25.0, 40.0])
def test_what_no_corner_explains_is_read_as_level(bearing_deg):
    """At 1.5 m a corner's cosine is 0.1 at most, but what is between says something up to 30 degrees."""
    true = np.deg2rad(bearing_deg)
    bearing, std, cycles = bearing_posterior(np.array([1.5]), readings_of(seen(1.5, 0.0, true)), ATTITUDE)
    assert abs(bearing[0] - true) < max(std[0], np.deg2rad(5.0))
    assert np.argmax(cycles[0]) == len(CYCLES) // 2


def test_a_level_phone_tells_heights_only_by_how_steep():
    """Without pitch a corner's cosine is that of its bearing, times the cosine of how far it lies below."""
    flat = Attitude(0.0, 1.0, HEIGHT_M, LENGTH)
    u_m = [seen(range_m, HEIGHT_M, 0.0, attitude=flat) for range_m in (1.9, 40.0)]
    bearing, _, _ = bearing_posterior(np.array([1.9, 40.0]), readings_of(u_m), flat)
    assert np.arccos(np.sqrt(1.0 - (HEIGHT_M / 1.9) ** 2)) == pytest.approx(0.79, abs=0.01)
    assert bearing[0] < 0.4
    assert bearing[1] < np.deg2rad(8.0)


def slow_posterior(range_m, received):
    """Median and deviation from a dense quadrature that shares no code."""
    fine = np.deg2rad(np.arange(0.02, 90.0, 0.04))
    total = np.zeros(len(fine))
    for height, prior in zip(HEIGHTS_M, HEIGHT_PRIOR, strict=True):
        if min(height, HEIGHT_M) >= range_m:
            continue
        for image in (1.0, 2.0):
            u = np.array([seen(range_m, min(height, HEIGHT_M), b, image) for b in fine])
            off = (u - received.envelope_m[0]) / received.envelope_std_m[0]
            k = received.phase_std_rad[0] ** -2
            rotated = np.exp(k * (np.cos(received.phase_rad[0] + 2.0 * np.pi * u / CYCLE_M) - 1.0))
            phase = 0.95 * rotated + 0.05 / np.sqrt(2.0 * np.pi * k)
            total += prior * np.exp(-0.5 * off**2) * phase * (np.abs(off) <= 4.0)
    share = total / total.sum()
    median = fine[np.searchsorted(np.cumsum(share), 0.5)]
    return median, np.sqrt(np.sum(share * (fine - median) ** 2))


@pytest.mark.parametrize(("range_m", "height_m", "bearing_deg"), [(1.9, 1.35, 5.0), (3.0, 0.0, 20.0), (5.0, 0.5, 35.0)])
def test_agrees_with_a_slow_quadrature(range_m, height_m, bearing_deg):
    received = readings_of(seen(range_m, height_m, np.deg2rad(bearing_deg)), phase_std_rad=0.5)
    bearing, std, cycles = bearing_posterior(np.array([range_m]), received, ATTITUDE)
    median, deviation = slow_posterior(range_m, received)
    assert bearing[0] == pytest.approx(median, abs=np.deg2rad(1.0))
    assert std[0] == pytest.approx(deviation, abs=np.deg2rad(1.0))
    assert cycles.sum() == pytest.approx(1.0, abs=1e-6)


def test_deviations_hold_over_what_the_prior_says():
    """Of draws from the prior two in three and more lie within; the level reading misses corners by far."""
    rng, count = np.random.default_rng(5), 600
    height = rng.choice(np.minimum(HEIGHTS_M, HEIGHT_M), count, p=HEIGHT_PRIOR)
    bearing, range_m = rng.uniform(0.0, np.pi / 2, count), rng.uniform(1.5, 5.0, count)
    u_m = [seen(r, z, b, i) for r, z, b, i in zip(range_m, height, bearing, rng.choice([1.0, 2.0], count), strict=True)]
    found, std, _ = bearing_posterior(range_m, readings_of(u_m, seed=6), ATTITUDE)
    error = np.abs(found - bearing)
    assert np.isfinite(found).mean() > 0.99
    assert 0.68 < np.nanmean(error < std) < 0.9
    assert np.nanmean(error < 3.0 * std) > 0.95
    level = np.arccos(np.clip((np.array(u_m) / LENGTH) / ATTITUDE.cos_pitch, -1.0, 1.0))
    assert np.nanmean(error) < 0.7 * np.mean(np.abs(level - bearing))


def test_nothing_heard_or_explained_is_not_a_number():
    received = DifferenceReadings(np.array([np.nan, -0.12]), np.full(2, 0.003), np.zeros(2), np.full(2, 0.3), CYCLE_M)
    bearing, std, cycles = bearing_posterior(np.array([2.0, 2.0]), received, ATTITUDE)
    assert np.isnan(bearing).all()
    assert np.isnan(std).all()
    assert not cycles.any()


def test_without_a_phase_the_envelopes_decide():
    u_m = seen(2.0, 0.0, 0.6)
    received = DifferenceReadings(np.array([u_m]), np.array([0.002]), np.full(1, np.nan), np.full(1, np.nan), CYCLE_M)
    bearing, std, cycles = bearing_posterior(np.array([2.0]), received, ATTITUDE)
    assert abs(bearing[0] - 0.6) < std[0] < 0.3
    assert not cycles.any()
    assert len(BEARINGS_RAD) == 90


@pytest.mark.parametrize("pitch_deg", [0.0, 30.0, -20.0])
def test_ground_path_is_that_of_a_mirrored_speaker(pitch_deg):
    pitch = np.deg2rad(pitch_deg)
    listener = GroundFinder(LENGTH, AHEAD_M, pitch, C)
    for height_m in HELD_M:
        expected = way_m(by_ground, pitch, height_m)
        assert listener.path_m(height_m, mic=0) == pytest.approx(expected[0], abs=1e-12)
        assert listener.path_m(height_m) == pytest.approx(expected[1], abs=1e-12)
        assert listener.height_of(expected[1]) == pytest.approx(height_m, abs=1e-12)


def tracked(ways, **options):
    detector = StandingDetector(BEEP, PHONE, STANDING, pitch_rad=PITCH)
    return list(detector.stream(recorded(ways, **options)))[-1]


@pytest.mark.parametrize("bearing_deg", [0.0, 20.0])
def test_a_corner_is_heard_ahead_once_the_ground_is(bearing_deg):
    """Its own direct echo left out, as a bin's. The paper's detector reads it as if level."""
    true = np.deg2rad(bearing_deg)
    corner = (way_m(by_wall(1.5, true, foot=True)), (0.04, 0.03))
    found = tracked([GROUND, corner])
    assert len(found) == 1
    range_m = np.hypot(1.5, HEIGHT_M)
    assert found.range_m[0] == pytest.approx(range_m, abs=0.01)
    assert abs(found.bearing_rad[0] - true) < found.bearing_std_rad[0] + np.deg2rad(5.0)
    level = tracked([corner])
    assert level.bearing_rad[0] > np.deg2rad(50.0)


def test_without_the_channels_phase_both_ranges_are_still_said():
    """Cycles that no phase tells were once weighed, and the path difference was lost."""
    wall = (way_m(by_wall(1.5, 0.3)), (0.04, 0.03))
    detector = StandingDetector(BEEP, PHONE, STANDING, pitch_rad=PITCH, mic_phase_rad=None)
    found = list(detector.stream(recorded([GROUND, wall])))[-1]
    assert len(found) == 1
    assert found.range2_m[0] == pytest.approx(tracked([GROUND, wall]).range2_m[0], abs=0.01)


@pytest.mark.parametrize("second", [1.0, 0.0])
def test_equal_channels_and_a_deaf_microphone_leave_ranges(second):
    """Equal channels have no second crest to part, which once was an error."""
    received = recorded([GROUND, (way_m(by_wall(1.5, 0.3)), (0.04, 0.03))])
    samples = np.stack([received.samples[0], second * received.samples[0]])
    detector = StandingDetector(BEEP, PHONE, STANDING, pitch_rad=PITCH)
    found = list(detector.stream(Recording(samples, received.sample_rate_hz)))[-1]
    assert np.abs(found.range_m - 1.5).min() < 0.01
    assert np.isnan(found.bearing_rad).all()
    assert np.isnan(found.range2_m).all()


def test_without_the_ground_things_are_placed_as_if_from_the_phone_s_height():
    """By the exact paths, 65 dB over noise after averaging: six deviations of the range are 0.13 mm."""
    wall = way_m(by_wall(2.5, 0.4))
    found = tracked([(wall, (0.04, 0.03))], noise=0.003)
    u_m = np.array([wall[1] - wall[0]])
    range_m = ranges_of_pairs(wall[:1], u_m, LENGTH, float(PHONE.speaker_to_mic_m[0]), np.sign(AHEAD_M))
    bearing_rad, _ = walking_angle(cone_cosine(range_m, range_m + u_m, LENGTH), np.cos(PITCH))
    np.testing.assert_allclose(found.range2_m - found.range_m, u_m, atol=1e-4)
    np.testing.assert_allclose(found.range_m, range_m, atol=1.3e-4)
    np.testing.assert_allclose(found.bearing_rad, bearing_rad, atol=1e-4 / (LENGTH * np.cos(PITCH) * np.sin(0.4)))


def test_a_wall_is_read_the_same_with_the_ground():
    wall = (way_m(by_wall(1.5, 0.3)), (0.04, 0.03))
    received, missed = tracked([GROUND, wall]), tracked([wall])
    assert len(received) == len(missed) == 1
    assert received.bearing_rad[0] == pytest.approx(0.3, abs=np.deg2rad(3.0))
    assert received.range_m[0] == pytest.approx(missed.range_m[0], abs=1e-3)


def test_the_ground_must_be_louder_at_the_lower_microphone():
    listener, compressor = GroundFinder(LENGTH, AHEAD_M, PITCH, C), MatchedFilter(BEEP, 0.03)
    for gains, expected in (((0.05, 0.1), HEIGHT_M), ((0.1, 0.05), np.nan)):
        block = recorded([(way_m(by_ground), gains)], beeps=1).samples.astype(float)
        height_m = listener.height_m(compressor.compress(block), 0.0)
        assert height_m == pytest.approx(expected, abs=0.005, nan_ok=True)
    assert np.isnan(listener.height_m(compressor.compress(recorded([], beeps=1).samples.astype(float)), 0.0))
    assert transducers()[1, 2] == HEIGHT_M
