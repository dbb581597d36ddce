"""What the last beeps received along approaches: points that are met, that are passed, and that are not there."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.tracking.approach_picture import AHEAD_M, LAYERS, SHAPE, Carrier, approach_picture
from obstaclewatch.tracking.approach_sums import MEMORY_BEEPS, RecentBeeps
from obstaclewatch.walker.pitch_oscillation import STEADY, Oscillation

CELL_M, FIRST_M, CELLS = 343.0 / 24_000.0, 0.3, 460
WAVELENGTH_M, AHEAD_S, PERIOD_S, NOW_S = 343.0 / 20_500.0, 0.205, 0.09, 5.0
CARRIER = Carrier(1.25, 1.3, 0.14, 0.4, 2.0 * np.pi * 1.8)
STEPS = Oscillation(CARRIER.step_rad_s, 0.02 + 0.0j, 0.0j, 0.0j)
HEIGHT = {0.0: 0, 0.45: 1, 1.3: 2}


def _beeps(ahead_m, aside_m, height_m, pitch_rad=0.0, strength=30.0):
    """A point that is so far ahead now, received by both microphones; its pulse is a few samples wide."""
    time_s = NOW_S - PERIOD_S * np.arange(MEMORY_BEEPS)
    along_m = ahead_m + CARRIER.speed_m_s * (NOW_S - AHEAD_S - time_s)
    range_m = np.sqrt(along_m**2 + aside_m**2 + height_m**2)
    pitch = CARRIER.pitch_rad + pitch_rad * np.cos(CARRIER.step_rad_s * time_s)
    cosine = (along_m * np.cos(pitch) - height_m * np.sin(pitch)) / range_m
    length_m = CARRIER.separation_m
    later_m = np.sqrt(range_m**2 + 2.0 * range_m * length_m * cosine + length_m**2) - range_m
    sample = 2.0 * (range_m - FIRST_M) / CELL_M + 0.5
    envelope = np.zeros((MEMORY_BEEPS, 2, 2 * CELLS), dtype=np.complex64)
    phase = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, MEMORY_BEEPS)
    every = np.arange(2 * CELLS)
    for mic, later in enumerate((0.0, later_m)):
        place = (sample + later / CELL_M)[:, None]
        pulse = np.exp(-0.5 * ((every - place) / 3.0) ** 2)
        turn = np.exp(1j * (phase - 2.0 * np.pi * later / WAVELENGTH_M))
        envelope[:, mic] = strength * pulse * turn[:, None]
    ratio = np.zeros((MEMORY_BEEPS, CELLS))
    inside = (sample > 0) & (sample < 2 * CELLS - 2)
    ratio[np.flatnonzero(inside), (sample[inside] / 2).astype(int)] = 5.0
    return RecentBeeps(time_s, ratio, envelope, FIRST_M, CELL_M)


def _picture(beeps, oscillation=STEADY, mic_phase_rad=0.0):
    found = approach_picture(beeps, NOW_S, AHEAD_S, CARRIER, oscillation, WAVELENGTH_M, mic_phase_rad)
    assert found.shape == SHAPE
    assert found.dtype == np.float32
    return found.reshape(-1, LAYERS, *SHAPE[1:])


@pytest.mark.parametrize("height_m", HEIGHT)
def test_what_is_met_stands_upright_at_its_place(height_m):
    found = _picture(_beeps(1.0, 0.0, height_m))[HEIGHT[height_m]]
    column = int(np.argmin(np.abs(AHEAD_M - 1.0)))
    assert (found[3].argmax(axis=1) == column).all()
    assert (found[0, :, column] == 5.0).mean() > 0.8
    both = found[1, :, column] + 1j * found[2, :, column]
    assert np.abs(np.angle(both)).max() < 0.15  # an envelope that is linear between samples
    assert both.real.min() > 2.0


def test_what_is_passed_bends_and_turns_the_phase():
    found = _picture(_beeps(1.0, 0.8, 0.0))[0]
    places = AHEAD_M[found[3].argmax(axis=1)]
    assert places[0] > places[8] + 0.1
    rows = np.arange(MEMORY_BEEPS)
    both = found[1, rows, found[3].argmax(axis=1)] + 1j * found[2, rows, found[3].argmax(axis=1)]
    assert abs(np.angle(both[0] * np.conj(both[12]))) > 1.0


def test_oscillation_of_the_pitch_is_taken_off():
    swaying = _beeps(1.0, 0.0, 0.0, pitch_rad=0.02)
    column = int(np.argmin(np.abs(AHEAD_M - 1.0)))
    taken, left = (_picture(swaying, oscillation)[0] for oscillation in (STEPS, STEADY))
    angle = [np.angle(found[1, :, column] + 1j * found[2, :, column]) for found in (taken, left)]
    assert np.abs(angle[0]).max() < 0.15
    assert np.abs(angle[1]).max() > 0.25


def test_a_known_phase_of_microphone_1_is_taken_off_and_an_unknown_one_leaves_it_out():
    beeps = _beeps(1.0, 0.0, 0.0)
    column = int(np.argmin(np.abs(AHEAD_M - 1.0)))
    turned = _picture(beeps, mic_phase_rad=0.5)[0]
    assert np.angle(turned[1] + 1j * turned[2])[:, column] == pytest.approx(-0.5, abs=0.15)
    alone = _picture(beeps, mic_phase_rad=None)
    assert not alone[:, 1:3].any()
    assert alone[:, 3].any()


def test_few_beeps_and_ranges_that_are_not_searched_are_zero():
    beeps = _beeps(1.0, 0.0, 0.0)
    few = RecentBeeps(*(values[:3] for values in beeps[:3]), FIRST_M, CELL_M)
    assert not _picture(few)[:, :, 3:].any()
    near = AHEAD_M + CARRIER.speed_m_s * -AHEAD_S < FIRST_M - CELL_M
    assert near.any()
    assert not _picture(beeps)[0][:, 0, near].any()


def test_a_point_at_the_phone_itself_has_a_picture():
    """Cause: with some beeps a place ahead is read at no distance at all: 0 / 0, and no alert from that beep on."""
    found = approach_picture(
        _beeps(1.0, 0.0, 0.0), NOW_S, AHEAD_M[2] / CARRIER.speed_m_s, CARRIER, STEADY, WAVELENGTH_M, 0.0
    )
    assert np.isfinite(found).all()
