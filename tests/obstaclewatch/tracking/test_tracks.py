"""Background, ground and coherent path difference, each against a closed form or a slow sum."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import i0

from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.signal.background import ClutterMap, CoherentBackground
from obstaclewatch.signal.carrier_phase import (
    OFFSETS_M,
    PHASE_STD,
    add_rotated,
    bessel_i0,
    cycle,
    deviation_factor,
    log_agreement,
    received_at,
)
from obstaclewatch.signal.echoes import echoes_at
from obstaclewatch.signal.matched_filter import MatchedFilter
from obstaclewatch.tracking.moving_peaks import PeakFinder
from tests.obstaclewatch.synthetic import BEEP, FULL_SCALE, PHONE, C, Point, record, second_after, true_range

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


def test_the_background_leaves_envelopes_as_they_are():
    """Cause: the first envelope itself became the mean, which later beeps then wrote into."""
    first, background = np.ones((2, 5), dtype=complex), CoherentBackground(8)
    background.subtract(first)
    background.subtract(np.zeros((2, 5), dtype=complex))
    assert (first == 1.0).all()


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
    row = second_after(profile, delay, 0.01)
    assert row.shape == (1, len(OFFSETS_M))
    phase = np.angle(np.interp(u_m, OFFSETS_M, row[0].real) + 1j * np.interp(u_m, OFFSETS_M, row[0].imag))
    off = (phase + 2.0 * np.pi * u_m * profile.reference_hz / C + np.pi) % (2.0 * np.pi) - np.pi
    assert abs(off) < 0.15
    asked_m = np.array([u_m, u_m - 0.12, u_m + 0.12], dtype=np.float32)
    value = _heard_at(row[0], asked_m)
    power = np.abs(_sum(row, asked_m[None], asked_m[None])) ** 2
    assert np.sum(value**2, axis=0) == pytest.approx(power, rel=1e-3)  # one beep has no phase to compare
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
    row = second_after(profile, echoes_at(profile, 0, np.array([peak])).delay_s, 1.0)[0]
    envelope_m = OFFSETS_M[np.argmax(np.abs(row))]
    assert abs(envelope_m - u_m(hit + AHEAD_S)) < 0.015
    value = np.interp(envelope_m, OFFSETS_M, row.real) + 1j * np.interp(envelope_m, OFFSETS_M, row.imag)
    off = [np.angle(value * np.exp(2j * np.pi * u_m(t) / WAVELENGTH)) for t in (hit, hit + AHEAD_S)]
    assert abs(off[1]) > 0.45
    assert abs(off[0]) < 0.3 * abs(off[1])


def _heard_at(row, u_m):
    """(2, H) real and imaginary part of a row at path differences."""
    received = np.empty((2, len(u_m)), dtype=np.float32)
    received_at(received, np.empty(len(u_m), dtype=np.int32), row, u_m)
    return received


def _sum(second, read_m, hit_m):
    """(H,) what (K, W) rows add up to at path differences (K, H), as read and as hit."""
    total = np.zeros((2, read_m.shape[1]), dtype=np.float32)
    for row, read, hit in zip(second, read_m, hit_m, strict=True):
        add_rotated(total, _heard_at(row, read), hit, np.float32(1.0 / WAVELENGTH), np.float32(1.0))
    return total[0] + 1j * total[1]


def test_path_differences_out_of_reach_read_the_ends():
    row = (np.arange(len(OFFSETS_M)) + 1.0j).astype("c8")
    asked_m = np.array([-1.0, 1.0, np.nan], dtype=np.float32)
    assert _heard_at(row, asked_m)[0] == pytest.approx([0.0, len(OFFSETS_M) - 1.0, 0.0], abs=0.011)


def test_coherent_sum_against_a_slow_one():
    rng = np.random.default_rng(3)
    second = (rng.standard_normal((5, len(OFFSETS_M))) + 1j * rng.standard_normal((5, len(OFFSETS_M)))).astype("c8")
    u, now = rng.uniform(-0.15, 0.15, (2, 5, 7)).astype(np.float32)
    expected = np.zeros(7, dtype=complex)
    for k, row in enumerate(second):
        value = np.interp(u[k], OFFSETS_M, row.real) + 1j * np.interp(u[k], OFFSETS_M, row.imag)
        expected += value * np.exp(2j * np.pi * now[k].astype(float) / WAVELENGTH)
    assert np.abs(expected).min() > 0.1
    assert _sum(second, u, now) == pytest.approx(expected, abs=1e-4)


def test_cycles_and_bessel_are_those_of_the_library():
    turns = np.linspace(-20.0, 20.0, 4001).astype(np.float32)
    found = np.array([cycle(turn) for turn in turns]).T
    angle = 2.0 * np.pi * turns.astype(float)
    assert found == pytest.approx(np.stack([np.cos(angle), np.sin(angle)]), abs=2e-6)
    argument = np.linspace(0.0, PHASE_STD**-2, 50)
    assert [bessel_i0(x) for x in argument] == pytest.approx(list(i0(argument)), rel=1e-12)


def test_a_sum_that_is_not_above_noise_says_nothing():
    assert log_agreement(0.0, 0.0, 0.7) == log_agreement(0.3, -0.9, 0.7) == 0.0


@pytest.mark.parametrize(("power", "most"), [(1.001, 1.0), (3.0, 2.69), (400.0, 3.64)])
def test_agreement_of_phases_is_a_density_over_the_circle(power, most):
    """The mean over all phases is that of any phase, 1; a loud echo tells what a normal density of 0.6 rad does."""
    phase = np.linspace(-np.pi, np.pi, 2001)[:-1]
    ratio = np.exp([log_agreement(*(np.sqrt(power) * np.array([np.cos(p), np.sin(p)])), 0.7) for p in phase])
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
    limited = [np.abs(row).max() * deviation_factor(row) for row in second]
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


@pytest.mark.parametrize(("height_m", "other_m", "gain"), [(1.38, 1.66, 0.35), (1.4, 1.04, 0.3), (1.3, 1.68, 0.28)])
def test_the_ground_is_not_mistaken_for_what_else_stands_at_its_distance(height_m, other_m, gain):
    """Regression: a louder way by ground and body was taken for the ground, or the middle between both."""
    finder = PeakFinder(BEEP, PHONE, PaperSettings(), C)
    ground = Point(PHONE.mics_m[0, 1] + height_m - 0.015, gain=0.3, carried=True, bob_m=0.02)
    other = Point(PHONE.mics_m[0, 1] + other_m - 0.015, gain=gain, carried=True, bob_m=0.02)
    for block in np.split(record([ground, other], beeps=12, noise=0.02), 12, axis=1):
        finder.find(block)
    assert finder.ground_m == pytest.approx(height_m, abs=0.03)
