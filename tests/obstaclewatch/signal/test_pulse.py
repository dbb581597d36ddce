"""Calibration of the pulse from the beep's design alone."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch import BeepDesign
from obstaclewatch.signal.pulse import pulse_shape, rms_bandwidth_hz, trailing_widths
from tests.obstaclewatch.synthetic import BEEP, C

SHAPE = pulse_shape(BEEP, 0.5, C)


def test_rms_bandwidth_is_that_of_a_hann_chirp():
    """By stationary phase the energy spectrum is the window to the fourth power: 707 Hz."""
    swept = np.linspace(-0.5, 0.5, 20_001)
    energy = np.cos(np.pi * swept) ** 4
    expected = 5_000.0 * np.sqrt(np.sum(swept**2 * energy) / np.sum(energy))
    assert expected == pytest.approx(707.0, abs=1.0)
    assert rms_bandwidth_hz(BEEP) == pytest.approx(expected, rel=0.005)


@pytest.mark.parametrize(("snr_db", "range_mm"), [(20.0, 3.9), (30.0, 1.2), (40.0, 0.39)])
def test_delay_bound(snr_db, range_mm):
    bound = 0.5 * C * SHAPE.delay_std_s(10.0 ** (snr_db / 10.0))
    assert 1e3 * float(bound) == pytest.approx(range_mm, rel=0.03)


def test_motion_widens_the_pulse():
    assert SHAPE.trailing_width_s(0.0) == pytest.approx(259.0e-6, abs=0.5e-6)
    assert SHAPE.trailing_width_s(1.3) == pytest.approx(280.4e-6, abs=0.5e-6)
    assert SHAPE.trailing_width_s(-1.3) == SHAPE.trailing_width_s(1.3)
    assert (np.diff(SHAPE.trailing_s) > 0.0).all()


def test_trailing_width_of_a_gaussian():
    """exp(-x^2 / 2 w^2) falls to one half at w sqrt(2 ln 2); three points on a parabola: 0.1 %."""
    envelope = np.exp(-0.5 * ((np.arange(200) - 80.3) / 8.0) ** 2)
    width, merged = trailing_widths(envelope, np.array([80.3]), np.array([1.0]), 1.0, 0.5, 100.0)
    assert width[0] == pytest.approx(8.0 * np.sqrt(2.0 * np.log(2.0)), rel=0.001)
    assert not merged[0]


def test_a_crest_that_rises_again_has_no_width():
    axis = np.arange(200)
    envelope = np.exp(-0.5 * ((axis - 80.0) / 8.0) ** 2) + np.exp(-0.5 * ((axis - 99.0) / 8.0) ** 2)
    width, merged = trailing_widths(envelope, np.array([81.0]), np.array([1.05]), 1.0, 0.5, 100.0)
    assert merged[0]
    assert np.isnan(width[0])


@pytest.mark.parametrize(("duration_s", "gap_s"), [(0.05, 0.01), (0.2, 0.045), (0.15, 0.03)])
def test_the_pulse_is_that_of_the_chirp_whatever_the_gap(duration_s, gap_s):
    """Cause: the echo that calibrates widths lay beyond the delays that were kept, and widths were NaN or a third."""
    widths = pulse_shape(BeepDesign(duration_s=duration_s, gap_s=gap_s), 0.5, C).trailing_s
    assert widths[0] == pytest.approx(259.0e-6, abs=0.5e-6)
    assert (np.diff(widths) > -2e-6).all()
