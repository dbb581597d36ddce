"""Noise: its level in the band, its whiteness, independence of the microphones, and reproducibility."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from obstaclewatch.beep import BeepDesign
from simulator.phone.noise import noise_rms, noise_samples
from simulator.phone.phone import Phone

QUIET = Phone.named("galaxy-s5")


def band_power(samples, rate_hz, low_hz=18e3, high_hz=23e3):
    """Mean square of each row between two frequencies (two-sided FFT of the row)."""
    spectrum = np.abs(np.fft.fft(samples.astype(np.complex128), axis=1) / samples.shape[1]) ** 2
    frequency = np.abs(np.fft.fftfreq(samples.shape[1], 1.0 / rate_hz))
    return spectrum[:, (frequency >= low_hz) & (frequency < high_hz)].sum(axis=1)


def spl_db(power, phone):
    """A sine of amplitude 1, power 1/2, is at full scale."""
    return 10.0 * np.log10(power / 0.5) + phone.full_scale_spl_db


@pytest.mark.parametrize("rate_hz", [48e3, 96e3, 192e3])
def test_band_level_is_the_phones(rate_hz):
    # 1 s holds 5000 independent complex bins: standard deviation of the level 4.34 / sqrt(5000) = 0.06 dB
    samples = noise_samples(QUIET, int(rate_hz), rate_hz, np.random.default_rng(1))
    np.testing.assert_allclose(spl_db(band_power(samples, rate_hz), QUIET), 30.0, atol=4 * 0.062)


def test_a_sine_of_the_same_level_has_the_same_band_power():
    amplitude = 10.0 ** ((QUIET.noise_spl_db - QUIET.full_scale_spl_db) / 20.0)
    sine = amplitude * np.sin(2.0 * np.pi * 20e3 * np.arange(192_000) / 192e3)[None]
    noise = noise_samples(QUIET, 192_000, 192e3, np.random.default_rng(5))
    np.testing.assert_allclose(band_power(noise, 192e3) / band_power(sine, 192e3), 1.0, rtol=4 / np.sqrt(5000))


def test_rms_follows_the_levels():
    louder = replace(QUIET, noise_spl_db=36.0)
    hotter = replace(QUIET, full_scale_spl_db=126.0)
    assert noise_rms(louder, 192e3) / noise_rms(QUIET, 192e3) == pytest.approx(10.0 ** (6.0 / 20.0))
    assert noise_rms(hotter, 192e3) / noise_rms(QUIET, 192e3) == pytest.approx(10.0 ** (-6.0 / 20.0))
    assert noise_rms(QUIET, 192e3) / noise_rms(QUIET, 48e3) == pytest.approx(2.0)


def test_white_gaussian_and_independent():
    count = 400_000
    samples = noise_samples(QUIET, count, 192e3, np.random.default_rng(2)) / noise_rms(QUIET, 192e3)
    _, density = signal.welch(samples, fs=1.0, nperseg=64, detrend=False)
    # Welch averages about 2 * count / 64 half-overlapping segments: 0.9 % per bin
    np.testing.assert_allclose(density[:, 1:-1] / 2.0, 1.0, atol=0.05)
    assert abs(np.mean(samples[0] * samples[1])) < 5.0 / np.sqrt(count)
    assert abs(np.mean(samples**4) - 3.0) < 5.0 * np.sqrt(96.0 / (2 * count))


def test_matched_filter_gains_19_7_db():
    """A beep of 50 dB in 30 dB of noise: 20 dB plus 10 log10(B T = 250) plus Hann's energy, 3/8 of the peak's."""
    beep = BeepDesign()
    emitted = beep.samples()
    amplitude = 10.0 ** ((50.0 - QUIET.full_scale_spl_db) / 20.0)
    noise = noise_samples(QUIET, 1_000_000, beep.sample_rate_hz, np.random.default_rng(9))[0]
    filtered = signal.fftconvolve(noise.astype(np.float64), emitted[::-1], mode="valid")
    peak = amplitude * np.sum(emitted**2)
    snr_db = 10.0 * np.log10(peak**2 / (2.0 * np.mean(filtered**2)))  # of the envelope: both quadratures are noise
    # about 1 kHz of equivalent bandwidth over 5.2 s: 5000 independent values, 0.09 dB
    assert snr_db == pytest.approx(20.0 + 10.0 * np.log10(250.0 * 3.0 / 8.0), abs=0.3)


def test_silent_phone_is_exactly_silent():
    samples = noise_samples(Phone.named("ideal"), 1000, 192e3, np.random.default_rng(0))
    np.testing.assert_array_equal(samples, np.zeros((2, 1000), dtype=np.float32))


def test_same_seed_same_noise_and_longer_begins_the_same():
    short, again, longer = (
        noise_samples(QUIET, count, 192e3, np.random.default_rng(7)) for count in (300_000, 300_000, 600_001)
    )
    assert short.dtype == np.float32
    assert np.any(short != 0.0)
    np.testing.assert_array_equal(short, again)
    np.testing.assert_array_equal(short, longer[:, :300_000])
    assert np.any(noise_samples(QUIET, 300_000, 192e3, np.random.default_rng(8)) != short)


def test_no_samples_is_an_empty_array():
    assert noise_samples(QUIET, 0, 192e3, np.random.default_rng(0)).shape == (2, 0)


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="count must not be negative, got -1"):
        noise_samples(QUIET, -1, 192e3, np.random.default_rng(0))
    with pytest.raises(ValueError, match="sample_rate_hz must be positive, got 0"):
        noise_samples(QUIET, 1, 0.0, np.random.default_rng(0))
