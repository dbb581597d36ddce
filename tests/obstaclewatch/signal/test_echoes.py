"""Thresholds, peak picking and interpolation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage, signal

from obstaclewatch.signal.echoes import (
    SIDELOBE,
    above_sidelobes,
    highest_nearby,
    highest_of_windows,
    local_maxima,
    mean_threshold,
    noise_amplitude,
    os_cfar_passes,
    os_cfar_threshold,
    refine_peaks,
    separated_peaks,
)


def _pulse(center, width=4.0, count=200):
    return np.exp(-0.5 * ((np.arange(count) - center) / width) ** 2)


@given(center=st.floats(20.0, 180.0), height=st.floats(1e-3, 1e3))
@settings(max_examples=50, deadline=None)
def test_a_gaussian_is_interpolated_exactly(center, height):
    """Its logarithm is a parabola."""
    envelope = height * _pulse(center)
    position, peak = refine_peaks(envelope, np.array([np.argmax(envelope)]))
    assert position[0] == pytest.approx(center, abs=1e-9)
    assert peak[0] == pytest.approx(height, rel=1e-9)


def test_edges_and_slopes_stay_where_they_are():
    ramp = np.arange(1.0, 11.0)
    position, height = refine_peaks(ramp, np.array([0, 5, 9]))
    assert position.tolist() == [0.0, 5.0, 9.0]
    assert height.tolist() == [1.0, 6.0, 10.0]


def test_of_two_near_peaks_the_higher_stays():
    envelope = _pulse(50.0) + 0.6 * _pulse(62.0) + 0.6 * _pulse(120.0)
    assert separated_peaks(envelope, 0.1, 9).tolist() == [50, 62, 120]
    assert separated_peaks(envelope, 0.1, 15).tolist() == [50, 120]
    assert separated_peaks(envelope, 0.7, 9).tolist() == [50]


@given(seed=st.integers(0, 999), separation=st.integers(1, 30), threshold=st.floats(0.0, 2.0))
@settings(max_examples=50, deadline=None)
def test_separated_peaks_are_scipys(seed, separation, threshold):
    envelope = np.random.default_rng(seed).rayleigh(size=400)
    expected = signal.find_peaks(envelope, height=threshold, distance=separation)[0]
    assert separated_peaks(envelope, threshold, separation).tolist() == expected.tolist()


@given(seed=st.integers(0, 999), steps=st.integers(1, 6))
@settings(max_examples=50, deadline=None)
def test_local_maxima_are_scipys_on_flat_tops_too(seed, steps):
    envelope = np.random.default_rng(seed).integers(0, steps, size=200).astype(float)
    assert local_maxima(envelope).tolist() == signal.find_peaks(envelope)[0].tolist()


@given(seed=st.integers(0, 999), half_width=st.integers(0, 90), count=st.integers(1, 200))
@settings(max_examples=50, deadline=None)
def test_highest_nearby_is_scipys_maximum_filter(seed, half_width, count):
    envelope = np.random.default_rng(seed).rayleigh(size=count)
    expected = ndimage.maximum_filter1d(envelope, 2 * half_width + 1, mode="nearest")
    assert highest_nearby(envelope, half_width).tolist() == expected.tolist()


@given(seed=st.integers(0, 999), half_width=st.integers(1, 90), least=st.floats(0.0, 2.0))
@settings(max_examples=50, deadline=None)
def test_being_above_sidelobes_is_reaching_their_floor(seed, half_width, least):
    envelope = np.random.default_rng(seed).lognormal(sigma=3.0, size=400)
    peaks = local_maxima(envelope)
    reaches = envelope[peaks] >= np.maximum(SIDELOBE * highest_nearby(envelope, half_width)[peaks], least)
    assert above_sidelobes(envelope, peaks, half_width, least).tolist() == peaks[reaches].tolist()


@given(seed=st.integers(0, 999), count=st.integers(3, 400), half_width=st.integers(1, 90), factor=st.floats(0.5, 3.0))
@settings(max_examples=100, deadline=None)
def test_passing_a_cfar_is_reaching_its_threshold(seed, count, half_width, factor):
    """Whole threshold curve and single peaks agree bit for bit, at the ends and for windows longer than it all."""
    envelope = np.random.default_rng(seed).rayleigh(size=count)
    peaks = local_maxima(envelope)
    expected = envelope[peaks] >= os_cfar_threshold(envelope, factor, half_width)[peaks]
    assert os_cfar_passes(envelope, peaks, factor, half_width).tolist() == expected.tolist()


def test_fixed_windows_split_a_peak_at_their_edge():
    """Erratum `separated_peaks`: section 3.4's windows count one echo twice."""
    envelope = _pulse(95.5)
    assert np.sum(envelope[highest_of_windows(envelope, 96)] > 0.5) == 2
    assert len(separated_peaks(envelope, 0.5, 9)) == 1


def test_mean_threshold_is_the_average_times_lambda():
    assert mean_threshold(np.array([1.0, 2.0, 3.0]), 2.5) == pytest.approx(5.0)


def test_noise_amplitude_ignores_echoes():
    """4,000 Rayleigh heights know their quartile to 2 %; an echo over a tenth of the range shifts it by 7 %."""
    rng = np.random.default_rng(3)
    noise = np.abs(rng.normal(size=4000) + 1j * rng.normal(size=4000))
    assert noise_amplitude(noise) == pytest.approx(np.sqrt(2.0), rel=0.05)
    noise[1000:1400] += 100.0
    assert noise_amplitude(noise) == pytest.approx(np.sqrt(2.0), rel=0.12)


def test_os_cfar_follows_the_clutter_and_keeps_the_echo():
    rng = np.random.default_rng(4)
    envelope = np.abs(rng.normal(size=1000) + 1j * rng.normal(size=1000))
    envelope[:500] *= 20.0
    envelope[800] = 30.0
    threshold = os_cfar_threshold(envelope, 4.0, 90)
    assert threshold.shape == envelope.shape
    assert np.sum(envelope > threshold) < 5
    assert envelope[800] > threshold[800]
    assert envelope[800] < mean_threshold(envelope, 3.0)
