"""Summed envelopes against the beep filtered by one long Fourier transform and read at the retarded times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial, chebyshev
from scipy.interpolate import make_interp_spline

from obstaclewatch.beep import BeepDesign
from simulator import Phone
from simulator.field.motion import Motion
from simulator.rendering.beep_table import SKIRT_S, TOLERANCE, beep_table
from simulator.rendering.superposition import Sounds, add_sounds

RATE_HZ, REFERENCE_RATE_HZ = 24_000.0, 384_000.0
TERMS = 10
ROUNDING = 4e-7  # single precision: spline, rotation and level, each to 6e-8, and what the speaker rings past a circle


def _sounds(beep: BeepDesign, rng: np.random.Generator, closing: float, count: int = 2) -> Sounds:
    """Sounds that close in at that share of the speed of sound, with gains like those of a body's cells."""
    start, delay = rng.uniform(0.01, 0.05, count), rng.uniform(0.01, 0.04, count)
    half = 0.505 * beep.duration_s
    middle = start + delay + 0.5 * beep.duration_s
    coefficient = np.stack([delay, np.full(count, -closing * half), np.full(count, 2e-6), np.full(count, 1e-7)], axis=1)
    strength = np.stack([np.ones(count), *np.full((3, count), 0.01)], axis=1)
    shape = count, TERMS
    weight = (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) * 0.4 ** np.arange(TERMS)
    return Sounds(start, rng.integers(0, 2, count), weight, Motion(middle, half, coefficient, strength), delay)


def _summed(beep: BeepDesign, phone: Phone, sounds: Sounds) -> np.ndarray:
    total = np.zeros((2, 2, 6000))
    add_sounds(total, RATE_HZ, beep_table(beep, phone.speaker, TERMS, RATE_HZ), sounds)
    return total[:, 0] + 1j * total[:, 1]


def _reference(beep: BeepDesign, phone: Phone, sounds: Sounds) -> np.ndarray:
    """The same in double precision, beep and Chebyshev gains written out, in 3 s of silence."""
    count = round((3.0 + beep.duration_s) * REFERENCE_RATE_HZ)
    time = np.arange(count) / REFERENCE_RATE_HZ - 1.5
    frequency = 20e3 + np.fft.fftfreq(count, 1.0 / REFERENCE_RATE_HZ)
    share = time / beep.duration_s
    phase = Polynomial([0.0, beep.start_hz - 20e3, 0.5 * (beep.stop_hz - beep.start_hz) / beep.duration_s])(time)
    inside = (share >= 0.0) & (share <= 1.0)
    emitted = np.fft.fft(np.where(inside, (0.5 - 0.5 * np.cos(2 * np.pi * share)) * np.exp(2j * np.pi * phase), 0.0))
    emitted *= phone.speaker.response(frequency)
    near = np.abs(time - 0.5 * beep.duration_s) < 0.5 * beep.duration_s + 1e-3
    total = np.zeros((2, 6000), dtype=np.complex128)
    reception = np.arange(6000) / RATE_HZ
    for p, mic in enumerate(sounds.mic):
        gain = chebyshev.chebval(np.clip((frequency - 20e3) / 5e3, -1.0, 1.0), sounds.weight[p])
        filtered = make_interp_spline(time[near], np.fft.ifft(emitted * gain)[near], 5)
        x = (reception - sounds.motion.middle_s[p]) / sounds.motion.half_width_s
        travel = chebyshev.chebval(x, sounds.motion.delay_s[p])
        leaving = reception - travel - sounds.start_s[p]
        here = (np.abs(x) < 1.5) & (leaving >= -SKIRT_S) & (leaving <= beep.duration_s + SKIRT_S)
        level = chebyshev.chebval(x, sounds.motion.strength[p]) * sounds.center_delay_s[p] / travel
        carried = level * np.exp(-2j * np.pi * 20e3 * (travel + sounds.start_s[p]))
        total[mic, here] += carried[here] * filtered(leaving[here])
    return total


@pytest.mark.parametrize(
    ("phone", "change", "closing"),
    [
        ("ideal", {}, 0.008),
        ("galaxy-s5", {}, -0.008),
        ("nexus-6p", {"start_hz": 23e3, "stop_hz": 18e3}, 0.008),
        ("galaxy-s8-plus", {"start_hz": 15e3, "stop_hz": 25e3}, 0.0),
        ("ideal", {"duration_s": 0.005, "gap_s": 0.085}, 0.008),
        ("ideal", {}, -0.09),
    ],
)
def test_against_the_filtered_beep_at_its_retarded_times(phone, change, closing, rng):
    # Cause of the galaxy-s5's row: its speaker was filtered in a circle 0.7 ms longer than the beep, and what it rings
    # came in at the other end: 1.3e-3 of the peak.
    beep, instrument = replace(BeepDesign(), **change), Phone.named(phone)
    sounds = _sounds(beep, rng, closing)
    exact = _reference(beep, instrument, sounds)
    error = np.abs(_summed(beep, instrument, sounds) - exact).max()
    assert error < (TOLERANCE + ROUNDING) * np.abs(exact).max()


def test_one_by_one_or_together_is_the_same_to_the_bit(rng):
    # Cause: buffers are kept from row to row; what a row leaves in them must not reach the next.
    beep, phone = BeepDesign(), Phone.named("ideal")
    sounds = _sounds(beep, rng, -0.08, 4)
    alone = np.zeros((2, 2, 6000))
    table = beep_table(beep, phone.speaker, TERMS, RATE_HZ)
    for k in range(4):
        rows = slice(k, k + 1)
        one = Sounds(
            sounds.start_s[rows],
            sounds.mic[rows],
            sounds.weight[rows],
            sounds.motion[rows],
            sounds.center_delay_s[rows],
        )
        add_sounds(alone, RATE_HZ, table, one)
    assert np.abs(alone).max() > 0.1
    np.testing.assert_array_equal(_summed(beep, phone, sounds), alone[:, 0] + 1j * alone[:, 1])


def test_a_beep_too_short_for_the_table_is_refused():
    beep = replace(BeepDesign(), duration_s=1e-4, gap_s=0.0899)
    with pytest.raises(ValueError, match=r"about 1 ms or more, got .*duration_s=0.0001"):
        beep_table(beep, Phone.named("ideal").speaker, TERMS, RATE_HZ)


def test_a_table_is_kept_by_the_content_of_the_speaker():
    """Made anew for each block it took most of the time of a sum; a speaker changed in place has a table of its own."""
    phone, same = Phone.named("galaxy-s5"), Phone.named("galaxy-s5")
    kept = beep_table(BeepDesign(), phone.speaker, TERMS, RATE_HZ)
    assert beep_table(BeepDesign(), same.speaker, TERMS, RATE_HZ) is kept
    louder = replace(same.speaker, response_db=same.speaker.response_db.copy())
    louder.response_db[:] += 6.0
    found = beep_table(BeepDesign(), louder, TERMS, RATE_HZ)
    np.testing.assert_allclose(found.splines, 10.0**0.3 * kept.splines, rtol=1e-5, atol=1e-6)
    with pytest.raises(ValueError, match="read-only"):
        kept.splines[0] = 0.0


def test_a_travel_time_that_runs_off_reads_nothing_outside_the_beep():
    """What left before the beep was read from memory beyond the table: a microphone of NaN, or 1e37."""
    beep, phone = BeepDesign(), Phone.named("ideal")
    calm = _sounds(beep, np.random.default_rng(8), 0.005)
    delay = calm.motion.delay_s + np.array([0.034, 0.053, 0.024, 0.004])
    wild = replace(calm, motion=replace(calm.motion, delay_s=delay))
    expected = _reference(beep, phone, wild)
    np.testing.assert_allclose(_summed(beep, phone, wild), expected, atol=1e-5 * np.abs(expected).max())
