"""Background, ground and coherent path difference, each against a closed form or a slow sum."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.background import ClutterMap, CoherentBackground
from obstaclewatch.carrier_phase import (
    OFFSETS_M,
    at_path_differences,
    coherent_sum,
    log_agreement,
    second_channel,
    with_deviation,
)
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
    asked_m = np.array([[u_m], [u_m - 0.12], [u_m + 0.12]])
    value = at_path_differences(row, asked_m)
    power = np.abs(coherent_sum(value, asked_m, WAVELENGTH)) ** 2
    assert np.abs(value[:, 0]) ** 2 == pytest.approx(power, rel=1e-3)  # one beep has no phase to compare
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


def test_coherent_sum_against_a_slow_one():
    rng = np.random.default_rng(3)
    second = (rng.standard_normal((5, len(OFFSETS_M))) + 1j * rng.standard_normal((5, len(OFFSETS_M)))).astype("c8")
    u, now = rng.uniform(-0.15, 0.15, (2, 7, 5))
    for row, phase, found in zip(u, now, coherent_sum(at_path_differences(second, u), now, WAVELENGTH), strict=True):
        total = 0j
        for k, one in enumerate(row):
            value = np.interp(one, OFFSETS_M, second[k].real) + 1j * np.interp(one, OFFSETS_M, second[k].imag)
            total += value * np.exp(2j * np.pi * phase[k] / WAVELENGTH)
        assert found == pytest.approx(total / np.sqrt(5), rel=1e-3, abs=1e-2)


@pytest.mark.parametrize(("power", "most"), [(0.5, 1.0), (3.0, 2.69), (400.0, 3.64)])
def test_agreement_of_phases_is_a_density_over_the_circle(power, most):
    """The mean over all phases is that of any phase, 1; a loud echo tells what a normal density of 0.6 rad does."""
    phase = np.linspace(-np.pi, np.pi, 2001)[:-1]
    ratio = np.exp(log_agreement(np.sqrt(power) * np.exp(1j * phase), 0.7))
    assert ratio.mean() == pytest.approx(1.0, rel=1e-6)
    assert phase[np.argmax(ratio)] == pytest.approx(0.7, abs=0.01)
    assert ratio.max() == pytest.approx(most, rel=0.03)
    assert ratio.min() > 0.09
    normal = 0.9 * np.sqrt(2.0 * np.pi) / 0.6 + 0.1
    assert most < 1.02 * normal


def test_a_direct_sound_that_drifts_keeps_the_window_of_the_clutter_map():
    """Near and far ends of the reach were rounded apart, and some drifts gave one sample more or less."""
    finder = PeakFinder(BEEP, PHONE, PaperSettings(), C)
    found = 0
    for shift in range(0, 40):
        block = np.roll(record([Point(2.0)], noise=1e-3), shift, axis=1)
        found += finder.find(block) is not None
    assert found == 40


def test_a_deviation_limits_what_one_beep_says():
    second = np.array([[0.1, 0.0], [3.0, 100.0], [0.0, 1e4]], dtype=np.complex64)
    limited = np.abs(second).max(axis=1) * with_deviation(second, 0.5)
    assert limited == pytest.approx([0.1, 2.0, 2.0], rel=2e-3)


@pytest.mark.parametrize("height_m", [1.15, 1.33, 1.5])
def test_the_ground_is_sounded(height_m):
    """A bobbing echo at right angles to the phone: half of its path, which is 3 cm longer than twice its distance."""
    finder = PeakFinder(BEEP, PHONE, PaperSettings(), C)
    ground = Point(PHONE.mics_m[0, 1] + height_m - 0.015, gain=0.3, carried=True, bob_m=0.02)
    samples = record([ground], beeps=12, noise=0.02)
    for block in np.split(samples, 12, axis=1):
        finder.find(block)
    assert finder.ground_m == pytest.approx(height_m, abs=0.03)
    finder.reset()
    finder.find(record([], noise=0.02))
    assert finder.ground_m == 1.35
