"""The detector from no echo to no noise, against the Cramer-Rao bound and the Rice distribution."""

from __future__ import annotations

import math

import numpy as np
import scipy

from benchmarks.cells.probes.extremes.mirrors import MICS_M, SOUND_M_S, SPEAKER_M
from benchmarks.cells.probes.extremes.sound import chirp
from benchmarks.cells.probes.extremes.verdict import Error, Errors
from obstaclewatch import BeepDesign, PaperStandingDetector, PhoneGeometry, Recording
from obstaclewatch.support.arrays import Floats

TRIALS = 60
RANGE_M = 2.0
NEAR_M = 0.05
FLOAT32_M = 2e-5
"""Ranges in float32 samples without noise."""
THRESHOLD = 3.0 * math.sqrt(-2.0 * math.log(0.4))
"""The rule as stated, three times the 60 % quantile of noise, in deviations of a Rayleigh envelope: 12.2 dB."""


def detector_snr(snr_db: float) -> Errors:
    """Standing points at 2 m straight ahead of microphone 0 under white noise of this 2E/N0."""
    found = _range_errors_m(snr_db)
    near = found[np.abs(found) < NEAR_M]
    missed = 1.0 - len(near) / TRIALS
    expected = float(scipy.stats.ncx2.cdf(THRESHOLD**2, 2, 10.0 ** (snr_db / 10.0)))
    sampling = 3.0 * math.sqrt(max(expected * (1.0 - expected), 1.0 / TRIALS) / TRIALS)
    errors = {"missed": Error(missed - expected, sampling + 0.05)}
    if snr_db >= 20.0:
        bound = max(bound_m(snr_db), FLOAT32_M)
        rms = float(np.sqrt(np.mean(near**2))) if len(near) else math.inf
        errors["range_over_bound"] = Error(rms / bound, 1.5)
    return errors


def bound_m(snr_db: float) -> float:
    """Least deviation of half a path: c / (4 pi B sqrt(2E/N0)), B the spread of a Hann chirp's spectrum.

    The spectrum of a long chirp is its window squared over the band: B = 0.1414 of it for a Hann window.
    """
    beep = BeepDesign()
    spread_hz = 0.14145 * abs(beep.stop_hz - beep.start_hz)
    return SOUND_M_S / (4.0 * math.pi * spread_hz * 10.0 ** (snr_db / 20.0))


def _range_errors_m(snr_db: float) -> Floats:
    """(TRIALS,) of the candidate nearest to the point; infinite without one."""
    beep, rng = BeepDesign(), np.random.default_rng(0)
    phone = PhoneGeometry("ideal", SPEAKER_M, MICS_M)
    point = MICS_M[0] + np.array([0.0, RANGE_M, 0.0])
    to_point = np.linalg.norm(point - SPEAKER_M)
    time = np.arange(beep.period_samples) / beep.sample_rate_hz
    direct, echo = (
        np.stack([chirp(time - length / SOUND_M_S, beep) for length in lengths])
        for lengths in (np.linalg.norm(MICS_M - SPEAKER_M, axis=1), to_point + np.linalg.norm(point - MICS_M, axis=1))
    )
    noise = np.sqrt(np.sum(echo[0] ** 2) / 10.0 ** (snr_db / 10.0))
    samples = np.tile(30.0 * direct + echo, TRIALS) + noise * rng.standard_normal((2, TRIALS * beep.period_samples))
    recording = Recording((0.5 / np.abs(samples).max() * samples).astype(np.float32), beep.sample_rate_hz)
    detector = PaperStandingDetector(beep, phone, sound_speed_m_s=SOUND_M_S)
    blocks = recording.samples.reshape(2, TRIALS, beep.period_samples)
    ranges = (detector.process(blocks[:, k], k * beep.period_s).range_m for k in range(TRIALS))
    return np.array([found[np.argmin(np.abs(found - RANGE_M))] - RANGE_M if len(found) else np.inf for found in ranges])
