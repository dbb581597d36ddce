"""Two echoes within a pulse: exact pairs, the Cramer-Rao bound of both delays, what stays one echo, limits."""

import numpy as np
import pytest

from obstaclewatch import PaperSettings, StandingDetector
from obstaclewatch.signal.echoes import local_maxima, noise_amplitude
from obstaclewatch.signal.matched_filter import MatchedFilter
from obstaclewatch.signal.overlap import (
    CLOSEST,
    FINE,
    is_one_pulse,
    nearest_echoes,
    parted_crests,
    pulse_at,
    pulse_table,
    smooth_at,
    two_echoes,
)
from tests.obstaclewatch.pitched import PITCH, by_ground, by_wall, recorded, way_m
from tests.obstaclewatch.synthetic import BEEP, PHONE, C

FILTER = MatchedFilter(BEEP, 0.03)
TABLE = pulse_table(BEEP)
STEP_M = C / FILTER.rate_hz
"""Of path, a sample."""


def crest(paths_m, gains):
    """(M,) envelope of echoes with those path lengths and complex gains."""
    time_s = np.arange(BEEP.period_samples) / BEEP.sample_rate_hz
    return sum(
        gain * FILTER.compress(BEEP.waveform(time_s - path_m / C)[None]).envelope[0]
        for path_m, gain in zip(paths_m, gains, strict=True)
    )


def noise_of(snr, rng):
    """(M,) envelope of noise in which an echo of gain 1 has that SNR, 2E/N0."""
    level = np.sqrt(np.sum(BEEP.samples() ** 2) / snr)
    return FILTER.compress(level * rng.standard_normal((1, BEEP.period_samples))).envelope[0]


def position_of(path_m):
    profile = FILTER.compress(np.zeros((2, BEEP.period_samples)))
    return (path_m / C - profile.start_s) * profile.rate_hz


def peaks_of(envelope, least):
    magnitude = np.abs(envelope)
    peaks = local_maxima(magnitude)
    return peaks[magnitude[peaks] > least]


def test_the_table_is_the_pulse():
    envelope = np.abs(crest([4.0], [1.0]))
    middle = position_of(4.0)
    samples = np.arange(int(middle) - 15, int(middle) + 16)
    np.testing.assert_allclose([pulse_at(TABLE, s - middle) for s in samples], envelope[samples], atol=2e-3)
    assert TABLE[0] == pytest.approx(1.0, abs=1e-9)
    assert pulse_at(TABLE, len(TABLE) / FINE) == 0.0


def test_the_cubic_follows_the_envelope():
    """Asked 0.4 samples on, it says what an echo that comes 0.4 samples earlier has at the sample."""
    sample = round(position_of(4.0))
    earlier = crest([4.0 - 0.4 * STEP_M], [1.0])
    turn = np.exp(-2j * np.pi * FILTER.reference_hz * 0.4 / FILTER.rate_hz)
    assert smooth_at(crest([4.0], [1.0]), sample + 0.4) == pytest.approx(earlier[sample] * turn, abs=1e-3)


@pytest.mark.parametrize(("apart_m", "error_m"), [(0.056, 4e-3), (0.072, 2e-3), (0.1, 1e-3), (0.16, 1e-3)])
@pytest.mark.parametrize("turn_rad", [0.0, 1.6, 3.1])
def test_exact_pairs_are_found(apart_m, error_m, turn_rad):
    """Without noise the interpolations are left, the more the nearer the pair."""
    paths = np.array([4.0, 4.0 + apart_m])
    envelope = crest(paths, [1.0, 0.8 * np.exp(1j * turn_rad)])
    highest = int(np.argmax(np.abs(envelope)))
    pair = two_echoes(envelope, highest, TABLE, 1e-4)
    assert pair.found
    np.testing.assert_allclose(pair.position, position_of(paths), atol=error_m / STEP_M)
    np.testing.assert_allclose(np.abs(pair.amplitude), [1.0, 0.8], rtol=0.2 if apart_m < 0.06 else 0.03)
    assert not is_one_pulse(envelope, highest, TABLE, 1e-4)


BESIDE_A_LOUDER_ONE = np.array(
    [
        0.27,
        0.373,
        0.485,
        0.602,
        0.717,
        0.819,
        0.903,
        0.958,
        0.981,
        0.966,
        0.913,
        0.824,
        0.704,
        0.561,
        0.404,
        0.243,
        0.087,
        -0.055,
        -0.174,
        -0.268,
        -0.332,
        -0.368,
        -0.376,
        -0.361,
        -0.328,
        -0.281,
        -0.225,
        -0.164,
        -0.101,
        -0.038,
        0.023,
        0.082,
        0.138,
        0.192,
        0.243,
        0.291,
        0.335,
        0.375,
        0.409,
        0.438,
        0.459,
        0.474,
        0.48,
        0.478,
        0.466,
    ]
)
BESIDE_A_LOUDER_ONE = BESIDE_A_LOUDER_ONE + 1j * np.array(
    [
        0.026,
        0.054,
        0.086,
        0.118,
        0.148,
        0.173,
        0.191,
        0.198,
        0.196,
        0.184,
        0.163,
        0.136,
        0.106,
        0.074,
        0.043,
        0.015,
        -0.008,
        -0.027,
        -0.042,
        -0.051,
        -0.057,
        -0.06,
        -0.06,
        -0.058,
        -0.056,
        -0.054,
        -0.055,
        -0.059,
        -0.069,
        -0.086,
        -0.11,
        -0.142,
        -0.181,
        -0.224,
        -0.267,
        -0.308,
        -0.34,
        -0.361,
        -0.365,
        -0.352,
        -0.319,
        -0.268,
        -0.2,
        -0.119,
        -0.029,
    ]
)
"""Received by a phone held still about a peak on a flank, sample 22: development split of `ranging`, a wall at 1.5
m."""


def test_a_pair_whose_delays_nothing_bounds_is_none():
    """Regression: a crest was parted where the likelihood has no top, with infinite deviations."""
    pair = two_echoes(BESIDE_A_LOUDER_ONE, 22, TABLE, 0.0656)
    assert not np.isfinite(pair.std).all()
    assert not pair.found


def bound_m(apart_m, turn_rad, ratio, snr):
    """Deviation of the first one's path, all amplitudes and the other's delay unknown, from the beep's own spectrum."""
    samples = BEEP.samples()
    frequency = np.fft.rfftfreq(8 * len(samples), 1.0 / BEEP.sample_rate_hz)
    energy = np.abs(np.fft.rfft(samples, 8 * len(samples))) ** 2
    second = ratio * np.exp(1j * turn_rad - 2j * np.pi * frequency * apart_m / C)
    ramp = -2j * np.pi * (frequency - BEEP.center_hz)
    one = np.ones_like(second)
    jacobian = np.stack([ramp * one, one, 1j * one, ramp * second, second, 1j * second])
    information = snr * np.real((jacobian * energy / energy.sum()) @ jacobian.conj().T)
    return C * np.sqrt(np.linalg.inv(information)[0, 0])


@pytest.mark.parametrize(("apart_m", "turn_rad"), [(0.072, 0.0), (0.072, 3.0), (0.1, 0.0), (0.14, 2.5)])
def test_delays_reach_the_bound_of_two_echoes(apart_m, turn_rad):
    """At 34 dB."""
    snr, rng, errors, claims = 10.0**3.4, np.random.default_rng(3), [], []
    paths = np.array([4.0, 4.0 + apart_m])
    clean = crest(paths, [1.0, 0.8 * np.exp(1j * turn_rad)])
    for _ in range(60):
        envelope = clean + noise_of(snr, rng)
        pair = two_echoes(envelope, int(np.argmax(np.abs(envelope))), TABLE, np.sqrt(2.0 / snr))
        errors.append((pair.position[0] - position_of(4.0)) * STEP_M)
        claims.append(pair.std[0] * STEP_M)
    bound = bound_m(apart_m, turn_rad, 0.8, snr)
    assert bound > C / (2.0 * np.pi * 707.0 * np.sqrt(snr))
    assert 0.75 * bound < np.std(errors) < 1.35 * bound
    assert np.median(claims) == pytest.approx(bound, rel=0.15)
    assert abs(np.mean(errors)) < 0.002


def test_one_echo_stays_one():
    rng, snr = np.random.default_rng(2), 10.0**3.0
    clean = crest([4.0], [1.0])
    for _ in range(40):
        envelope = clean + noise_of(snr, rng)
        rms = noise_amplitude(np.abs(envelope))
        crests = parted_crests(envelope, peaks_of(envelope, 0.5), TABLE, rms)
        assert len(crests.position) == 1
        assert abs(crests.position[0] - position_of(4.0)) < 0.5


def test_a_weak_neighbour_and_three_echoes_are_left_alone():
    """The first is as well a phone's own response; the second no pair explains."""
    weak = crest([4.0, 4.09], [1.0, 0.25j])
    three = crest([4.0, 4.09, 4.2], [1.0, -0.9, 0.9j])
    for envelope, count in ((weak, 1), (three, None)):
        peaks = peaks_of(envelope, 0.4)
        crests = parted_crests(envelope, peaks, TABLE, 1e-4)
        assert len(crests.position) == (count or len(peaks))


def test_both_peaks_of_a_pair_give_it_once_and_phases_are_its_own():
    paths, gains = np.array([4.0, 4.17]), [1.0, 0.9j]
    envelope = crest(paths, gains)
    peaks = peaks_of(envelope, 0.4)
    assert len(peaks) == 2
    crests = parted_crests(envelope, peaks, TABLE, 1e-4)
    np.testing.assert_allclose(crests.position, position_of(paths), atol=0.002 / STEP_M)
    assert np.diff(crests.position)[0] > CLOSEST
    alone = [crest(paths[k : k + 1], gains[k : k + 1]) for k in range(2)]
    expected = [np.angle(smooth_at(alone[k], crests.position[k])) for k in range(2)]
    phase, std = nearest_echoes(crests, np.append(crests.position, np.nan))
    np.testing.assert_allclose(np.exp(1j * phase[:2]), np.exp(1j * np.array(expected)), atol=0.1)
    assert np.isnan(phase[2])
    assert (std[:2] > 0.0).all()


def test_a_corner_beside_a_wall_is_placed_to_a_few_millimetres():
    """A bin's corner 3.6 cm nearer than the wall alongside, both as loud: one peak, read 2 cm off without parting."""
    corner = way_m(by_wall(1.5, foot=True))
    range_m = np.hypot(1.5, 1.35)
    wall = way_m(by_wall(range_m + 0.036, np.pi / 2))
    received = recorded([(way_m(by_ground), (0.05, 0.1)), (corner, (0.04, 0.03)), (wall, (0.036, 0.03))])
    settings = PaperSettings(near_m=0.6)
    found = list(StandingDetector(BEEP, PHONE, settings, pitch_rad=PITCH).stream(received))[-1]
    assert np.abs(found.range_m - range_m).min() < 0.005


@pytest.mark.parametrize("peak", [0, 3, 20, 27, -28, -4, -1])
def test_peaks_at_the_ends_read_nothing_beyond(peak):
    """A crest so near an end that its search would leave the envelope is one echo."""
    rng = np.random.default_rng(1)
    envelope = rng.standard_normal(80) + 1j * rng.standard_normal(80)
    crests = parted_crests(envelope, np.array([peak % 80]), TABLE, 1e-3)
    assert np.isfinite(crests.position).all()
    assert len(crests.position) in (1, 2)
    assert ((crests.position >= 0.0) & (crests.position < 80.0)).all()
    assert len(parted_crests(envelope, np.array([], dtype=np.intp), TABLE, 1e-3).position) == 0
