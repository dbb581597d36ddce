"""The range that is reported of a track: exact where the model holds, honest where it does not."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from obstaclewatch import TrackingDetector
from obstaclewatch.tracking import range_fit as module
from obstaclewatch.tracking.detector import MOST_RANGE_STD_M
from obstaclewatch.tracking.range_fit import DETECTED_SHARE, FITTED_BEEPS, MISSED_GROWTH, Timing, track_range
from obstaclewatch.walker.gait import OSCILLATION_KNOWN_M, OTHER_M, READING_M, STEP_HZ
from obstaclewatch.walker.pitch_oscillation import STEADY, Oscillation
from tests.obstaclewatch.synthetic import BEEP, PHONE, Point, recording

TIMING = Timing(BEEP.range_doppler_s, BEEP.period_s)
STD_M = 0.005
SWING = Oscillation(2.0 * np.pi * 1.9, 0.0j, 0.010 - 0.014j, 0.008 + 0.006j)
BOB, SURGE = 0.6, 0.8
NOW_S = 7.2
HEARD_S = NOW_S - TIMING.period_s * np.arange(FITTED_BEEPS)


def _shown(oscillation, time_s):
    """What the oscillation adds to the range, and that a second, m and m/s."""
    phasor = (BOB * oscillation.height_m - SURGE * oscillation.fore_aft_m) * np.exp(
        1j * oscillation.step_rad_s * np.asarray(time_s)
    )
    return phasor.real, (1j * oscillation.step_rad_s * phasor).real


def _walk(time_s, range_m=2.5, speed=module.SPEED_M_S, acceleration=0.0, oscillation=STEADY):
    """Range at given times, and what a chirp reads then: x + T dx/dt."""
    tau = np.asarray(time_s) - NOW_S
    shown, rate = _shown(oscillation, time_s)
    true = range_m - speed * tau + 0.5 * acceleration * tau**2 + shown
    return true, true + TIMING.ahead_s * (rate - speed + acceleration * tau)


def _readings(read_m, time_s=HEARD_S):
    return np.stack([time_s, read_m, np.full(len(time_s), STD_M)], axis=1)


def _found(read_m, oscillation=STEADY, now_s=NOW_S, time_s=HEARD_S):
    return track_range(_readings(read_m, time_s), now_s, TIMING, oscillation, BOB, SURGE)


def test_a_walk_that_swings_as_is_known_is_found_exactly():
    true, read = _walk(HEARD_S, oscillation=SWING)
    assert np.ptp(read - _walk(HEARD_S)[1]) > 0.03  # what the oscillation does to the readings
    found = _found(read, SWING)
    assert found.range_m == pytest.approx(true[0], abs=1e-12)
    assert found.closing_m_s == pytest.approx(module.SPEED_M_S, abs=1e-12)


@pytest.mark.parametrize(("speed", "acceleration"), [(0.6, 0.0), (2.0, 0.0), (1.2, 0.3), (1.2, -0.3), (0.9, 0.2)])
def test_speed_and_acceleration_leave_no_range_doppler_bias(speed, acceleration):
    """At 0.3 m/s^2 a reading taken for the range T later would leave half of a T^2: 6 mm."""
    true, read = _walk(HEARD_S, speed=speed, acceleration=acceleration)
    found = _found(read)
    assert found.range_m == pytest.approx(true[0], abs=1.5e-3)
    assert found.closing_m_s == pytest.approx(speed, abs=0.03)


def test_without_a_known_swing_the_steps_are_fitted():
    """At worst phases; readings depart by 2.8 cm zero to peak, the range itself by 1.1 cm."""
    errors = []
    for phase in np.exp(2j * np.pi * np.arange(8) / 8.0):
        fore_aft_m = np.sqrt(2.0) * READING_M / abs(1.0 + 2j * np.pi * STEP_HZ * TIMING.ahead_s)
        true, read = _walk(
            HEARD_S, oscillation=Oscillation(2.0 * np.pi * STEP_HZ, 0.0j, 0.0j, fore_aft_m / SURGE * phase)
        )
        errors.append(_found(read).range_m - true[0])
    assert np.abs(errors).max() < 0.0035
    assert np.abs(errors).max() < 2.0 * _found(read).std_m


def _slow(read_m, time_s, oscillation):
    """The same by kriging: covariances of what is read and of the range, and a range of which nothing is known."""
    tau, step, ahead = time_s - NOW_S, oscillation.step_rad_s or 2.0 * np.pi * STEP_HZ, TIMING.ahead_s
    oscillated = _shown(oscillation, time_s)
    wave = np.exp(1j * step * tau)
    apart = wave[:, None] * wave[None].conj()  # of a sinusoid of random phase
    trajectory = np.stack([-(tau + ahead) * module.SPEED_STD_M_S, tau * (tau / 2.0 + ahead) * module.ACCELERATION_M_S2])
    step_m2 = (OSCILLATION_KNOWN_M if oscillation.fore_aft_m else READING_M) ** 2
    prior = trajectory.T @ trajectory + step_m2 * apart.real
    with_range = step_m2 * (wave.conj() / (1.0 + 1j * step * ahead)).real
    own = step_m2 / abs(1.0 + 1j * step * ahead) ** 2
    data = read_m - oscillated[0] - ahead * oscillated[1] + module.SPEED_M_S * (tau + ahead)
    variance = (OTHER_M**2 + STD_M**2) * (1.0 + (module.AGEING_HZ * tau) ** 2)
    weight, ones = np.ones(len(tau)), np.ones(len(tau))
    for _ in range(module.ROUNDS):
        noise = variance / weight
        inverse = np.linalg.inv(prior + np.diag(noise))
        mean = ones @ inverse @ data / (ones @ inverse @ ones)
        left = noise * (inverse @ (data - mean))
        weight = (module.FREEDOM + 1.0) / (module.FREEDOM + left**2 / variance)
    range_m = mean + with_range @ inverse @ (data - mean) + _shown(oscillation, NOW_S)[0]
    gap = 1.0 - ones @ inverse @ with_range
    std_m = np.sqrt(own - with_range @ inverse @ with_range + gap**2 / (ones @ inverse @ ones))
    return range_m, std_m


@pytest.mark.parametrize("oscillation", [STEADY, SWING])
@pytest.mark.parametrize("count", [1, 4, 16])
def test_fit_is_that_of_kriging(oscillation, count):
    rng = np.random.default_rng(count)
    read = _walk(HEARD_S[:count], speed=0.8, oscillation=oscillation)[1] + rng.standard_t(3.0, count) * OTHER_M
    found = _found(read, oscillation, time_s=HEARD_S[:count])
    range_m, std_m = _slow(read, HEARD_S[:count], oscillation)
    assert found.range_m == pytest.approx(range_m, abs=1e-9)
    assert found.std_m == pytest.approx(DETECTED_SHARE * std_m, rel=1e-7)


def test_the_fits_deviation_is_honest():
    """Of random walks by the model's priors. Weights cost 7 % of the information of normal noise, and do not say so."""
    rng, within = np.random.default_rng(0), []
    for _ in range(1500):
        steps = READING_M * complex(*rng.standard_normal(2)) / (1.0 + 2j * np.pi * STEP_HZ * TIMING.ahead_s)
        oscillation = Oscillation(2.0 * np.pi * STEP_HZ, 0.0j, steps / BOB, 0.0j)
        speed = rng.normal(module.SPEED_M_S, module.SPEED_STD_M_S)
        true, read = _walk(
            HEARD_S, speed=speed, acceleration=rng.normal(0.0, module.ACCELERATION_M_S2), oscillation=oscillation
        )
        scale = np.hypot(OTHER_M, STD_M) * np.sqrt(1.0 + (module.AGEING_HZ * (HEARD_S - NOW_S)) ** 2)
        found = _found(read + scale * rng.standard_normal(len(read)))
        within.append(abs(found.range_m - true[0]) < found.std_m / DETECTED_SHARE)
    assert 0.60 < np.mean(within) < 0.70  # found: 0.64


@pytest.mark.parametrize("count", [1, 2])
def test_peaks_of_another_echo_are_left_out(count):
    """Any one or two of the 16 are 8 cm off."""
    errors, straight = [], []
    for wrong in combinations(range(FITTED_BEEPS), count):
        true, read = _walk(HEARD_S)
        read[list(wrong)] += 0.08
        errors.append(abs(_found(read).range_m - true[0]))
        straight.append(abs(np.polyfit(HEARD_S - NOW_S + TIMING.ahead_s, read, 1)[1] - true[0]))
    assert np.median(straight) > 0.0049 * count
    assert np.median(errors) < 0.2 * np.median(straight)


def test_neither_order_nor_origin_of_time_matters():
    read = _walk(HEARD_S, oscillation=SWING)[1] + np.random.default_rng(3).normal(0.0, OTHER_M, len(HEARD_S))
    found, order = _found(read, SWING), np.random.default_rng(4).permutation(len(read))
    assert _found(read[order], SWING, time_s=HEARD_S[order]) == pytest.approx(found, abs=1e-12)
    back = np.exp(-100j * SWING.step_rad_s)
    later = Oscillation(SWING.step_rad_s, 0.0j, SWING.height_m * back, SWING.fore_aft_m * back)
    assert _found(read, later, NOW_S + 100.0, HEARD_S + 100.0) == pytest.approx(found, abs=1e-9)


def test_what_was_missed_makes_less_sure():
    """Every second beep missed: the deviation is larger by what fewer readings say, and by what they may be instead."""
    _, read = _walk(HEARD_S)
    half = _found(read[::2], time_s=HEARD_S[::2]).std_m
    assert half == pytest.approx(
        DETECTED_SHARE * (1.0 + MISSED_GROWTH * (1.0 - 8.0 / 15.0)) * _slow(read[::2], HEARD_S[::2], STEADY)[1],
        rel=1e-7,
    )
    waiting = [_found(read, now_s=NOW_S + missed * TIMING.period_s).std_m for missed in range(8)]
    assert np.all(np.diff(waiting) > 0.0)
    assert waiting[0] < 0.01
    assert waiting[-1] > 2.0 * waiting[0]


def test_what_is_not_heard_any_more_is_not_shown_for_long():
    """The echo ends with beep 20; its filter goes on for seven beeps without a peak."""
    samples = recording([Point(1.3, gain=0.3, carried=True), Point(5.2, gain=0.1)], beeps=34, speed_m_s=1.3, noise=0.02)
    silent = recording([Point(1.3, gain=0.3, carried=True)], beeps=34, speed_m_s=1.3, noise=0.02)
    size, detector = BEEP.period_samples, TrackingDetector(BEEP, PHONE)
    found = []
    for beep in range(34):
        source = samples if beep <= 20 else silent
        found.append(detector.process(source.samples[:, beep * size : (beep + 1) * size]))
    shown = np.array([len(d) for d in found])
    assert np.all(shown[14:22] >= 1)
    assert not shown[28:].any()
    claimed = np.concatenate([d.range_std_m for d in found])
    assert np.all((claimed > 0.0) & (claimed <= MOST_RANGE_STD_M))
