"""Pulse compression against closed forms and against the correlation written out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from obstaclewatch import BeepDesign
from obstaclewatch.signal.echoes import echoes_at
from obstaclewatch.signal.matched_filter import MatchedFilter
from tests.obstaclewatch.synthetic import BEEP

FILTER = MatchedFilter(BEEP, 0.043)
TIME = np.arange(BEEP.period_samples) / BEEP.sample_rate_hz


def _peak(profile, channel=0):
    return echoes_at(profile, channel, np.array([np.argmax(profile.magnitude[channel])]))


@settings(max_examples=30, deadline=None)
@given(delay_s=st.floats(0.0, 0.039), gain=st.floats(1e-6, 1e3))
def test_peak_has_the_delay_and_gain_of_the_echo(delay_s, gain):
    """Band-limited and sampled 9 times per pulse: what is left is the log-parabola's error, 0.03 samples at 192 kHz."""
    peak = _peak(FILTER.compress(gain * BEEP.waveform(TIME - delay_s)[None]))
    assert len(peak) == 1
    assert abs(peak.delay_s[0] - delay_s) * BEEP.sample_rate_hz < 0.03
    assert peak.amplitude[0] == pytest.approx(gain, rel=1e-4)


@settings(max_examples=10, deadline=None)
@given(delay_s=st.floats(0.0, 0.039))
def test_carrier_phase_is_kept(delay_s):
    """The analytic signal's phase at the echo's delay is that of the gain: zero for a real positive one."""
    profile = FILTER.compress(BEEP.waveform(TIME - delay_s)[None])
    nearest = profile.position(delay_s)
    around = np.arange(nearest - 200, nearest + 201)
    around = around[(around >= 0) & (around < profile.envelope.shape[1])]
    weight = np.sinc((delay_s - profile.delay_s[around]) * profile.rate_hz)
    envelope = np.sum(weight * profile.envelope[0, around])
    analytic = envelope * np.exp(2j * np.pi * profile.reference_hz * delay_s)
    assert abs(np.angle(analytic)) < 0.02


@pytest.mark.parametrize("taper", [0.1, 0.25, 0.5])
def test_under_a_tukey_window_the_pulse_is_the_hann_chirp_s_and_stands_higher_over_noise(taper):
    """By Cauchy-Schwarz the replica's echo stands 10 log10((sum t r)^2 / (sum r^2 sum h^2)) over the Hann chirp's."""
    tukey = BeepDesign(taper=taper)
    np.testing.assert_allclose(tukey.window(TIME[:9600]), signal.windows.tukey(9600, taper, sym=False), atol=1e-3)
    own, hann = MatchedFilter(tukey, 0.043), FILTER.compress(0.3 * BEEP.waveform(TIME - 0.01)[None]).magnitude
    np.testing.assert_allclose(own.compress(0.3 * tukey.waveform(TIME - 0.01)[None]).magnitude, hann, atol=3e-3 * 0.3)
    noise = np.random.default_rng(4).normal(size=(8, len(TIME)))
    gained_db = -20.0 * np.log10(own.compress(noise).magnitude.std() / FILTER.compress(noise).magnitude.std())
    h = signal.windows.hann(9600, sym=False)
    r = np.divide(h**2, tukey.window(TIME[:9600]), out=np.zeros(9600), where=h > 0)
    expected_db = 10.0 * np.log10(np.sum(h**2) ** 2 / (np.sum(r**2) * np.sum(h**2)))
    assert gained_db == pytest.approx(expected_db, abs=0.1)
    assert expected_db > 1.0


def test_equals_the_correlation_written_out():
    """Independent reference: full-rate time-domain correlation and Hilbert envelope of an in-band signal."""
    rng = np.random.default_rng(1)
    block = sum(rng.normal() * BEEP.waveform(TIME - delay) for delay in rng.uniform(0.0, 0.035, 6))
    replica = BEEP.samples()
    direct = signal.correlate(np.concatenate([block, np.zeros(len(replica) - 1)]), replica, "valid", "direct")
    envelope = np.abs(signal.hilbert(np.concatenate([direct, np.zeros(len(direct))])))[: len(direct)]
    envelope /= np.sum(replica**2)
    profile = FILTER.compress(block[None])
    step = round(BEEP.sample_rate_hz / profile.rate_hz)
    start = profile.position(0.0)
    inner = slice(40, 900)
    difference = profile.magnitude[0, start:][inner] - envelope[::step][inner]
    assert envelope.max() > 0.5
    assert np.abs(difference).max() < 1e-3 * envelope.max()


def test_equals_the_peers_matched_filter():
    """Stored output of arlpy.signal.mfilter (tests/references/make_arlpy_matched_filter.py)."""
    stored = np.load(Path(__file__).parents[2] / "references" / "arlpy_matched_filter.npz")
    echoes = zip(stored["gain"], stored["delay_s"], strict=True)
    block = sum(gain * BEEP.waveform(TIME - delay) for gain, delay in echoes)
    profile = MatchedFilter(BEEP, 0.043, lead_s=0.0, rate_hz=BEEP.sample_rate_hz).compress(block[None])
    expected = stored["magnitude"]
    ours = profile.magnitude[0, :: int(stored["step"])][: len(expected)]
    assert expected.max() > 0.9
    assert np.abs(ours - expected).max() < 2e-4


def test_pulse_width_and_sidelobes_are_those_of_the_hann_chirp():
    """-3 dB width 370 us = 71 samples, highest sidelobe -46.7 dB, read at eight times the default rate."""
    fine = MatchedFilter(BEEP, 0.043, rate_hz=192_000.0)
    profile = fine.compress(BEEP.waveform(TIME - 0.015)[None])
    level_db = 20.0 * np.log10(profile.magnitude[0] / profile.magnitude[0].max())
    peak = int(np.argmax(level_db))
    width = np.sum(level_db > -3.0103) / profile.rate_hz
    assert width == pytest.approx(370e-6, abs=2.0 / profile.rate_hz)
    valley = peak + int(np.argmax(np.diff(level_db[peak:]) > 0.0))
    assert level_db[valley:].max() == pytest.approx(-46.7, abs=0.1)


def test_time_reversed_beep_costs_18_5_db():
    """Eq. 1 as printed (erratum `correlate_once`)."""
    block = BEEP.waveform(TIME - 0.015)[None]
    printed = MatchedFilter(BEEP, 0.043, reverse=True).compress(block).magnitude.max()
    assert 20.0 * np.log10(printed / FILTER.compress(block).magnitude.max()) == pytest.approx(-18.5, abs=0.3)


def test_noise_outside_the_band_does_not_pass():
    tone = np.sin(2.0 * np.pi * 5_000.0 * TIME)[None]
    assert FILTER.compress(tone).magnitude.max() < 1e-6


def test_gain_and_superposition():
    rng = np.random.default_rng(2)
    one, two = rng.standard_normal((2, 1, BEEP.period_samples))
    both = FILTER.compress(3.0 * one + two).envelope
    assert np.allclose(both, 3.0 * FILTER.compress(one).envelope + FILTER.compress(two).envelope, atol=1e-12)


@pytest.mark.parametrize(
    "beep",
    [
        BeepDesign(start_hz=23_000.0, stop_hz=18_000.0),
        BeepDesign(start_hz=16_000.0),
        BeepDesign(start_hz=18_000.0, stop_hz=21_500.0, sample_rate_hz=44_100.0),
        BeepDesign(sample_rate_hz=384_000.0),
    ],
    ids=["down", "16-23 kHz", "44.1 kHz", "384 kHz"],
)
def test_other_beeps_and_rates(beep):
    time = np.arange(beep.period_samples) / beep.sample_rate_hz
    peak = _peak(MatchedFilter(beep, 0.04).compress(beep.waveform(time - 0.0123)[None]))
    assert peak.delay_s[0] == pytest.approx(0.0123, abs=1e-6)
    assert peak.amplitude[0] == pytest.approx(1.0, rel=1e-3)


def test_bad_blocks_are_refused():
    with pytest.raises(ValueError, match=r"17280.*got \(2, 100\)"):
        FILTER.compress(np.zeros((2, 100)))
    with pytest.raises(ValueError, match=r"17280.*got \(0, 17280\)"):
        FILTER.compress(np.zeros((0, BEEP.period_samples)))
    with pytest.raises(ValueError, match="a block must be numbers, got None"):
        FILTER.compress(None)
    block = np.zeros((2, BEEP.period_samples))
    block[1, 7] = np.nan
    with pytest.raises(ValueError, match="1 NaN"):
        FILTER.compress(block)


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ({"reach_s": -1.0}, "reach_s must be finite and not negative, got -1.0"),
        ({"reach_s": np.nan}, "reach_s must be finite and not negative, got nan"),
        ({"lead_s": -2e-3}, "lead_s must be finite and not negative, got -0.002"),
        ({"block_samples": 9_000}, "block_samples must be a whole number, 9600 or more, got 9000"),
        ({"block_samples": 1e5}, "block_samples must be a whole number, 9600 or more, got 100000.0"),
        ({"rate_hz": 0.0}, "rate_hz must be positive and finite, got 0.0"),
        ({"rate_hz": "24k"}, "rate_hz must be a number, got '24k'"),
        ({"beep": None}, "beep must be of type BeepDesign, got None"),
    ],
)
def test_arguments_out_of_range(wrong, rule):
    """A negative reach cut the profile from behind, a short block wrapped the beep round: both without a word."""
    with pytest.raises(ValueError, match=rule):
        MatchedFilter(**({"beep": BEEP, "reach_s": 0.04} | wrong))
