"""The walker's oscillation from the ground's echo: exact geometry of a mirrored speaker, rendered beeps, what is no
step."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.signal.matched_filter import MatchedFilter
from obstaclewatch.walker.pitch_oscillation import (
    LEAST_BEEPS,
    LEAST_SHARE,
    LOG_PRIOR,
    MEMORY_BEEPS,
    STEADY,
    GroundEcho,
    Oscillation,
    OscillationEstimator,
    ground_echo,
    ground_path_difference_m,
    oscillation_as_read,
    oscillation_at,
)
from obstaclewatch.walker.pitch_oscillation import STEP_RAD_S as STEPS_RAD_S
from obstaclewatch.walker.sinusoid import common_sinusoid, waves, weighted_fits
from tests.obstaclewatch.synthetic import BEEP, FULL_SCALE, PHONE, C, Point, record, true_range

LENGTH = PHONE.mic_separation_m
WAVELENGTH = C / BEEP.center_hz
AHEAD_S = BEEP.range_doppler_s
PITCH = np.deg2rad(30.0)
HEIGHT_M = 1.35
STEP_RAD_S = 2.0 * np.pi * 1.8
TRUE = Oscillation(STEP_RAD_S, 0.026 * np.exp(0.7j), 0.02 * np.exp(-0.4j), 0.01j * np.exp(-0.4j))
TIME_S = 0.09 * np.arange(MEMORY_BEEPS)


def _listener(oscillation=TRUE, noise=0.0, crossed=()):
    """A listener that received the ground of a swinging phone: the way to its own image, from both microphones."""
    rng = np.random.default_rng(3)
    listener = OscillationEstimator(LENGTH, WAVELENGTH, PITCH, AHEAD_S)
    pitch = PITCH + oscillation_at(oscillation, TIME_S)[0]
    height = HEIGHT_M + oscillation_at(oscillation, TIME_S)[1]
    axis = np.stack([np.cos(pitch), np.sin(pitch)])
    down = np.stack([np.zeros_like(height), -2.0 * height]) + LENGTH * axis
    phase = -2.0 * np.pi / WAVELENGTH * (np.linalg.norm(down, axis=0) - 2.0 * height) + 0.4
    read = HEIGHT_M + oscillation_as_read(oscillation, TIME_S, AHEAD_S)[1]
    for k, time in enumerate(TIME_S):
        other = (0.09, 2.0) if k in crossed else (0.0, 0.0)
        at = read[k] + noise * 0.003 * rng.standard_normal() + other[0]
        listener.add(time, GroundEcho(at, phase[k] + noise * 0.1 * rng.standard_normal() + other[1]))
    return listener


def _left(found, true):
    """(3,) rms of the oscillation that is left, over the true one's."""
    error, size = oscillation_at(found, TIME_S) - oscillation_at(true, TIME_S), oscillation_at(true, TIME_S)
    return np.sqrt(np.mean(error**2, axis=1) / np.mean(size**2, axis=1))


def test_path_difference_to_the_ground_is_that_of_the_image():
    axis = np.array([np.cos(PITCH), np.sin(PITCH)])
    image = np.array([0.0, -2.0 * HEIGHT_M])
    expected = np.linalg.norm(image + LENGTH * axis) - np.linalg.norm(image)
    assert ground_path_difference_m(HEIGHT_M, LENGTH, np.sin(PITCH)) == pytest.approx(expected, abs=1e-12)


def test_exact_readings_give_the_swing_back():
    """Up to the grid of frequencies and the second order of the pitch, 1 % each."""
    found = _listener().oscillation(HEIGHT_M)
    assert found.step_rad_s == pytest.approx(STEP_RAD_S, abs=1e-8)
    assert np.all(_left(found, TRUE) < 0.03)


@pytest.mark.parametrize("crossed", [(), (4, 5, 6), (15, 16, 17, 18)])
def test_noise_and_an_echo_that_crosses_leave_most_of_it(crossed):
    found = _listener(noise=1.0, crossed=crossed).oscillation(HEIGHT_M)
    assert found.step_rad_s == pytest.approx(STEP_RAD_S, abs=2.0 * np.pi * 0.051)
    assert np.all(_left(found, TRUE)[:2] < 0.3)


def test_what_crosses_the_ground_s_echo_leaves_the_cadence():
    """For two seconds of an approach something stronger is read instead, which keeps a step of its own."""
    rng = np.random.default_rng(6)
    listener, steps = OscillationEstimator(LENGTH, WAVELENGTH, PITCH, AHEAD_S), []
    for beep in range(66):
        time = np.array([0.09 * beep])
        at_m, phase = HEIGHT_M + oscillation_as_read(TRUE, time, AHEAD_S)[1, 0], 4.0 * oscillation_at(TRUE, time)[0, 0]
        if beep >= 40:
            at_m, phase = HEIGHT_M + 0.03 * np.cos(2.0 * np.pi * 1.45 * time[0]), rng.uniform(-0.5, 0.5)
        listener.add(time[0], GroundEcho(at_m + 0.003 * rng.standard_normal(), phase + 0.02 * rng.standard_normal()))
        steps.append((listener.oscillation(HEIGHT_M).step_rad_s, listener.step_hz))
    assert steps[10] == (0.0, 0.0)
    assert any(abs(rate / STEP_RAD_S - 1.0) > 0.15 for rate, _ in steps[50:])  # what crosses is taken for steps
    assert all(abs(2.0 * np.pi * step_hz / STEP_RAD_S - 1.0) < 0.03 for _, step_hz in steps[12:])
    listener.clear()
    assert listener.step_hz == 0.0


@pytest.mark.parametrize("later_hz", [1.45, 1.65, 2.2])
def test_another_pace_is_followed_within_six_seconds(later_hz):
    """Only rates about the walker's own are tried, until the likeliest of them is the outermost."""
    rng = np.random.default_rng(4)
    listener, phase, said = OscillationEstimator(LENGTH, WAVELENGTH, PITCH, AHEAD_S), 0.0, []
    for beep in range(60 + 67):
        phase += 0.09 * 2.0 * np.pi * (1.8 if beep < 60 else later_hz)
        at_m, difference = HEIGHT_M + 0.04 * np.cos(phase), 0.5 * np.cos(phase - 0.7)
        noise = rng.standard_normal(2)
        listener.add(0.09 * beep, GroundEcho(at_m + 0.003 * noise[0], difference + 0.1 * noise[1]))
        listener.oscillation(HEIGHT_M)
        said.append(listener.step_hz)
    assert said[59] == pytest.approx(1.8, rel=0.03)
    assert said[-1] == pytest.approx(later_hz, rel=0.03)


def test_what_people_do_decides_between_two_rates():
    """Faint steps of 1.8 a second in noise: of 300 series, a third as many have a rate more than 0.15 Hz off."""
    rng = np.random.default_rng(2)
    step = np.cos(STEP_RAD_S * TIME_S + rng.uniform(0.0, 2.0 * np.pi, (300, 2, 1)))
    series = 0.6 * step + rng.standard_normal(step.shape)
    flat, known = (
        np.array([common_sinusoid(TIME_S, values, STEPS_RAD_S, prior)[0] for values in series])
        for prior in (np.zeros(len(STEPS_RAD_S)), LOG_PRIOR)
    )
    off = [np.mean(np.abs(found - STEP_RAD_S) > 2.0 * np.pi * 0.151) for found in (flat, known)]
    assert off[0] > 0.15
    assert off[1] < 0.33 * off[0]


def test_what_is_read_is_the_place_and_its_speed_ahead():
    step = 1e-5
    speed = (oscillation_at(TRUE, TIME_S + step) - oscillation_at(TRUE, TIME_S - step)) / (2.0 * step)
    assert oscillation_as_read(TRUE, TIME_S, AHEAD_S) == pytest.approx(
        oscillation_at(TRUE, TIME_S) + AHEAD_S * speed, abs=1e-8
    )


def test_a_walker_is_fastest_when_lowest():
    found = _listener().oscillation(HEIGHT_M)
    times = np.linspace(0.0, 1.0, 1000)
    height, fore_aft = oscillation_at(found, times)[1:]
    assert np.ptp(height) > 0.03
    speed = np.gradient(fore_aft, times)
    assert np.corrcoef(speed, height)[0, 1] < -0.999


def test_no_step_no_swing():
    """Noise alone, a phone at rest, and too few beeps. Of random numbers one in forty passes for a step."""
    rng = np.random.default_rng(2)
    noise, rest, short = (OscillationEstimator(LENGTH, WAVELENGTH, PITCH, AHEAD_S) for _ in range(3))
    for time in TIME_S:
        noise.add(time, GroundEcho(HEIGHT_M + 0.01 * rng.standard_normal(), rng.uniform(-np.pi, np.pi)))
        rest.add(time, GroundEcho(HEIGHT_M, 0.3))
    for time in TIME_S[: LEAST_BEEPS - 1]:
        short.add(time, GroundEcho(HEIGHT_M + oscillation_at(TRUE, TIME_S[:1])[1, 0], 0.0))
    assert noise.oscillation(HEIGHT_M) == STEADY
    assert short.oscillation(HEIGHT_M) == STEADY
    assert np.abs(oscillation_at(rest.oscillation(HEIGHT_M), TIME_S)).max() < 1e-9
    listener = _listener()
    listener.clear()
    assert listener.oscillation(HEIGHT_M) == STEADY


def test_random_numbers_hardly_pass_for_a_step():
    rng = np.random.default_rng(8)
    noise = rng.standard_normal((200, 2, len(TIME_S)))
    shares = np.array([common_sinusoid(TIME_S, values, STEPS_RAD_S, LOG_PRIOR)[2] for values in noise])
    assert 0.15 < np.median(shares) < 0.35
    assert np.mean(shares > LEAST_SHARE) < 0.03
    assert np.mean(shares.min(axis=1) > LEAST_SHARE) == 0.0


def test_ground_echo_of_a_rendered_beep():
    """A point that stands for the ground: half its path, and the phase of its path difference."""
    point = Point(1.3, 0.4)
    profile = MatchedFilter(BEEP, 0.03).compress(record([point]) / FULL_SCALE)
    one, two = (true_range(point, 0.0, 0.0, mic) for mic in (0, 1))
    path_m = one + float(point.leg_m(PHONE.speaker_m[1], 0.0, np.float64(0.0)))
    received = ground_echo(profile, 0.0, path_m + 0.05, two - one, C)
    assert received.read_m == pytest.approx(0.5 * path_m, abs=0.003)
    expected = -2.0 * np.pi * (two - one) * profile.reference_hz / C
    assert abs(np.angle(np.exp(1j * (received.phase_rad - expected)))) < 0.15


def test_waves_turn_on_without_drifting():
    """An hour after the start, whose phase a step of the rates knows to 1e-12."""
    time = TIME_S + 3600.0
    turn = time[:, None] * STEPS_RAD_S
    assert np.stack(waves(time, STEPS_RAD_S)) == pytest.approx(np.stack([np.cos(turn), np.sin(turn)]), abs=1e-8)


def test_the_weighted_fits_are_the_least_squares_of_lapack():
    rng = np.random.default_rng(3)
    rates = np.array([8.2, 11.0, 15.3])
    values, weight = rng.standard_normal(len(TIME_S)), rng.uniform(0.05, 1.0, len(TIME_S))
    turn = TIME_S[:, None] * rates
    fits, shares = weighted_fits(np.cos(turn), np.sin(turn), values, weight)
    scatter = np.sum(weight * (values - np.average(values, weights=weight)) ** 2)
    for rate, fit, share in zip(rates, fits.T, shares, strict=True):
        design = np.stack([np.cos(rate * TIME_S), np.sin(rate * TIME_S), np.ones(len(TIME_S))], axis=1)
        expected = np.linalg.lstsq(design * np.sqrt(weight)[:, None], values * np.sqrt(weight), rcond=None)[0]
        assert fit == pytest.approx(expected, rel=1e-11)
        left = np.sum(weight * (values - design @ expected) ** 2)
        assert share == pytest.approx(1.0 - left / scatter, abs=1e-12)


def test_a_series_that_never_changes_has_no_step():
    time = TIME_S[:, None] * STEPS_RAD_S
    fits, shares = weighted_fits(np.cos(time), np.sin(time), np.zeros(len(TIME_S)), np.ones(len(TIME_S)))
    assert np.all(fits == 0.0)
    assert np.all(shares == 0.0)
