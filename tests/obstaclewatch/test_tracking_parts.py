"""Background, coherent path difference and courses, each against a closed form or a slow sum."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch.background import ClutterMap, CoherentBackground
from obstaclewatch.carrier_phase import OFFSETS_M, coherent_power, second_channel
from obstaclewatch.courses import CourseGrid, Samples
from obstaclewatch.echoes import echoes_at
from obstaclewatch.matched_filter import MatchedFilter
from obstaclewatch.moving_peaks import PeakFinder
from obstaclewatch.settings import PaperSettings

from .synthetic import BEEP, FULL_SCALE, PHONE, C, Point, record, true_range

LENGTH = PHONE.mic_separation_m
WAVELENGTH = C / BEEP.center_hz
AHEAD_S = BEEP.range_doppler_s


def test_what_never_changes_goes_and_what_turns_stays():
    rng = np.random.default_rng(1)
    steady = rng.standard_normal((2, 50)) + 1j * rng.standard_normal((2, 50))
    background = CoherentBackground(8)
    assert not background.subtract(steady).any()
    for k in range(1, 30):
        turning = np.zeros((2, 50), dtype=complex)
        turning[:, 20] = np.exp(2.3j * k)
        rest = background.subtract(steady + turning)
        assert np.abs(rest[:, :20]).max() < 1e-12
        assert 0.6 < np.abs(rest[0, 20]) < 1.4
    background.clear()
    assert not background.subtract(steady).any()


def test_clutter_map_is_the_mean_of_the_nearby_maximum():
    clutter = ClutterMap(4, 1)
    assert np.isinf(clutter.level(np.zeros(6))).all()
    first = clutter.level(np.array([0.0, 0.0, 4.0, 0.0, 0.0, 0.0]))
    assert first == pytest.approx(0.0)
    second = clutter.level(np.zeros(6))
    assert second == pytest.approx([0.0, 2.0, 2.0, 2.0, 0.0, 0.0])


@pytest.mark.parametrize("aside_m", [0.0, 0.8, 2.5])
def test_coherent_power_peaks_at_the_true_path_difference(aside_m):
    """One beep, no noise: within the true path difference the power is a maximum in phase and envelope."""
    point = Point(2.0, aside_m)
    profile = MatchedFilter(BEEP, 0.03).compress(record([point]) / FULL_SCALE)
    u_m = true_range(point, 0.0, 0.0, 1) - true_range(point, 0.0, 0.0, 0)
    start = profile.position((true_range(point, 0.0, 0.0) * 2.0 - 0.1) / C)
    peak = start + np.argmax(profile.magnitude[0, start : start + 30])
    delay = echoes_at(profile, 0, np.array([peak])).delay_s
    row = second_channel(profile, delay, 0.01, C)
    assert row.shape == (1, len(OFFSETS_M))
    phase = np.angle(np.interp(u_m, OFFSETS_M, row[0].real) + 1j * np.interp(u_m, OFFSETS_M, row[0].imag))
    off = (phase + 2.0 * np.pi * u_m * profile.reference_hz / C + np.pi) % (2.0 * np.pi) - np.pi
    assert abs(off) < 0.15
    power = coherent_power(row, *2 * [np.array([[u_m], [u_m - 0.12], [u_m + 0.12]])], WAVELENGTH)
    assert power[0] == pytest.approx((point.gain / 0.01) ** 2, rel=0.05)
    assert power[0] > 1.4 * power[1:].max()


@pytest.mark.parametrize("speed", [1.0, 1.5, 2.0])
def test_phase_reads_the_moment_while_the_envelope_reads_ahead(speed):
    """Regression: the phase was compared with the path difference 0.205 s later, here 2-6 mm of a 16.7 mm cycle."""
    point = Point(1.9, 0.8)
    profile = MatchedFilter(BEEP, 0.03).compress(record([point], speed_m_s=speed) / FULL_SCALE)
    hit = 0.5 * BEEP.duration_s + true_range(point, 0.0, 0.0) / C

    def u_m(time_s):
        return true_range(point, speed, time_s, 1) - true_range(point, speed, time_s, 0)

    start = profile.position(2.0 * (true_range(point, speed, hit + AHEAD_S) - 0.2) / C)
    peak = start + np.argmax(profile.magnitude[0, start : start + 40])
    row = second_channel(profile, echoes_at(profile, 0, np.array([peak])).delay_s, 1.0, C)[0]
    envelope_m = OFFSETS_M[np.argmax(np.abs(row))]
    assert abs(envelope_m - u_m(hit + AHEAD_S)) < 0.015
    value = np.interp(envelope_m, OFFSETS_M, row.real) + 1j * np.interp(envelope_m, OFFSETS_M, row.imag)
    off = [np.angle(value * np.exp(2j * np.pi * u_m(t) / WAVELENGTH)) for t in (hit, hit + AHEAD_S)]
    assert abs(off[1]) > 0.45
    assert abs(off[0]) < 0.3 * abs(off[1])


def test_coherent_power_against_a_slow_sum():
    rng = np.random.default_rng(3)
    second = (rng.standard_normal((5, len(OFFSETS_M))) + 1j * rng.standard_normal((5, len(OFFSETS_M)))).astype("c8")
    u, now = rng.uniform(-0.15, 0.15, (2, 7, 5))
    for row, phase, power in zip(u, now, coherent_power(second, u, now, WAVELENGTH), strict=True):
        total = 0j
        for k, one in enumerate(row):
            value = np.interp(one, OFFSETS_M, second[k].real) + 1j * np.interp(one, OFFSETS_M, second[k].imag)
            total += value * np.exp(2j * np.pi * phase[k] / WAVELENGTH)
        assert power == pytest.approx(abs(total) ** 2 / 5, rel=1e-3, abs=1e-3)


PITCH = 0.5


def _samples(speed, miss, height=0.0, angle=0.0, level=3.0, beeps=14):
    """Exact readings on a course, from 4.5 m on, at a level of microphone 1 over its noise."""
    time = 0.09 * np.arange(beeps)
    ahead = speed * np.cos(angle) * (4.5 / speed - time)
    center = np.sqrt(ahead**2 + miss**2 + height**2)

    def u_m(ahead):
        distance = np.sqrt(ahead**2 + miss**2 + height**2)
        cosine = (ahead * np.cos(angle) * np.cos(PITCH) - height * np.sin(PITCH)) / distance
        return np.sqrt(distance**2 + LENGTH**2 + 2.0 * distance * LENGTH * cosine) - distance

    shape = np.exp(-(((OFFSETS_M - u_m(ahead)[:, None]) / 0.1) ** 2))
    phase = u_m(ahead + speed * np.cos(angle) * AHEAD_S)
    second = level * shape * np.exp(-2j * np.pi * phase / WAVELENGTH)[:, None]
    return Samples(time, center, np.full(beeps, 0.005), second.astype("c8")), time[-1]


@pytest.mark.parametrize(("miss", "angle"), [(0.0, 0.0), (0.0, 0.3)])
def test_constant_bearing_is_a_collision(miss, angle):
    grid = CourseGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S)
    samples, now = _samples(1.3, miss, angle=angle)
    course = grid.judge(samples, now)
    assert course.collision > 0.6
    assert course.contact_s == pytest.approx(4.5 / 1.3 - now, abs=0.25)


@pytest.mark.parametrize("miss", [1.2, 1.6])
def test_growing_bearing_is_none(miss):
    course = CourseGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S).judge(*_samples(1.3, miss, beeps=24))
    assert course.collision < 0.3
    assert course.miss_m == pytest.approx(miss, abs=0.4)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.8, 2.6), st.floats(0.0, 2.0), st.floats(0.0, 1.3), st.floats(-1.0, 1.0))
def test_probabilities_stay_probabilities_and_time_has_no_origin(speed, miss, height, shift_s):
    grid = CourseGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S)
    samples, now = _samples(speed, miss, height)
    course = grid.judge(samples, now)
    moved = Samples(samples.time_s + shift_s, samples.range_m, samples.range_std_m, samples.second)
    later = grid.judge(moved, now + shift_s)
    assert 0.0 <= course.collision <= 1.0 + 1e-9
    assert 0.0 <= course.bearing_rad <= np.pi / 2
    assert later.collision == pytest.approx(course.collision, abs=2e-3)
    assert later.contact_s == pytest.approx(course.contact_s, abs=5e-3)


def test_a_direct_sound_that_drifts_keeps_the_window_of_the_clutter_map():
    """Near and far ends of the reach were rounded apart, and some drifts gave one sample more or less."""
    finder = PeakFinder(BEEP, PHONE, PaperSettings(), C)
    found = 0
    for shift in range(0, 40):
        block = np.roll(record([Point(2.0)], noise=1e-3), shift, axis=1)
        found += finder.find(block) is not None
    assert found == 40
