"""Echoes of points and mirrors, evaluated at exact retarded times: all that the detector's tests know of acoustics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from obstaclewatch import BeepDesign, PhoneGeometry, Recording
from obstaclewatch.signal.carrier_phase import OFFSETS_M, second_channel

C = 343.0
BEEP = BeepDesign()
PHONE = PhoneGeometry("test", [0.0, 0.0405, 0.0], [[0.0, 0.0705, 0.0], [0.0, -0.0705, 0.0]])
"""A level phone, 14.1 cm between the microphones, speaker 3 cm behind the top one; +y is the walking direction."""
FULL_SCALE = 0.05
"""Digital amplitude of a path of gain 1, so that the direct sound does not clip."""


@dataclass(frozen=True)
class Point:
    """A point that echoes with the same gain from everywhere.

    Attributes:
        ahead_m, aside_m: from the phone's origin at time 0.
        gain: amplitude of its echo.
        carried: it moves along with the walker, like the ground below.
        bob_m: amplitude of a gait twice a second, by which a carried point's distance changes.
        detour_m: (2,) added to its path to each microphone.
    """

    ahead_m: float
    aside_m: float = 0.0
    gain: float = 0.1
    carried: bool = False
    bob_m: float = 0.0
    detour_m: tuple[float, float] = (0.0, 0.0)

    def leg_m(self, place_m, speed_m_s, time_s):
        """Distance from a point of the phone (ahead coordinate) at given times; one for all where nothing moves."""
        ahead = self.ahead_m - place_m
        if self.bob_m:
            ahead = ahead + self.bob_m * np.sin(4.0 * np.pi * time_s)
        if speed_m_s and not self.carried:
            ahead = ahead - speed_m_s * time_s
        return np.sqrt(ahead**2 + self.aside_m**2)


def emission_time(point, mic, speed_m_s, time_s, phone=PHONE):
    """When what microphone `mic` receives at `time_s` was emitted; both move while the sound travels.

    Fixed point of c (t - t_e) = |P - S(t_e)| + |P - M(t)|: each round is v / c more exact, six leave 1e-16 s.
    """
    arrival = point.leg_m(phone.mics_m[mic, 1], speed_m_s, time_s) + point.detour_m[mic]
    emitted = time_s - 2.0 * arrival / C
    for _ in range(6):
        emitted = time_s - (point.leg_m(phone.speaker_m[1], speed_m_s, emitted) + arrival) / C
    return emitted


def beep_train(emitted_s, beep=BEEP):
    """What the speaker plays at given times: beeps from time 0 on."""
    played = np.zeros(np.shape(emitted_s))
    phase = np.mod(emitted_s, beep.period_s)
    during = (emitted_s >= 0.0) & (phase <= beep.duration_s)  # a beep lasts a quarter of its period or so
    played[during] = beep.waveform(phase[during])
    return played


def record(points, beeps=1, speed_m_s=0.0, noise=0.0, seed=0, direct=(10.0, 4.0), beep=BEEP, phone=PHONE):
    """(2, N) float64 recording of whole beep periods, first sample at the emission of beep 0."""
    time = np.arange(beeps * beep.period_samples) / beep.sample_rate_hz
    samples = noise * np.random.default_rng(seed).standard_normal((2, len(time)))
    for mic in range(2):
        samples[mic] += direct[mic] * beep_train(time - phone.speaker_to_mic_m[mic] / C, beep)
        for point in points:
            samples[mic] += point.gain * beep_train(emission_time(point, mic, speed_m_s, time, phone), beep)
    return FULL_SCALE * samples


def recording(points, **options):
    """The same as a Recording."""
    beep = options.get("beep", BEEP)
    return Recording(record(points, **options).astype(np.float32), beep.sample_rate_hz)


def at_another_clock(samples, ratio):
    """What a recorder receives whose clock runs that share faster than the player's."""
    time = np.arange(samples.shape[1]) / (1.0 + ratio)
    return CubicSpline(np.arange(samples.shape[1]), samples, axis=1)(np.minimum(time, samples.shape[1] - 1))


def true_range(point, speed_m_s, time_s, mic=0):
    """Distance from a microphone to the point at a time, m."""
    return float(point.leg_m(PHONE.mics_m[mic, 1], speed_m_s, np.float64(time_s)))


def noise_for(snr_db, gain, beep=BEEP):
    """Standard deviation per sample that gives an echo the matched-filter SNR 2E/N0 = gain^2 sum(s^2) / sigma^2."""
    return gain * np.sqrt(np.sum(beep.samples() ** 2)) / 10.0 ** (snr_db / 20.0)


def second_after(profile, delay_s, noise):
    """(n, W) microphone 1 at `OFFSETS_M` of path after echoes at delays (n,), see `second_channel`."""
    position = (delay_s - profile.start_s) * profile.rate_hz
    return second_channel(profile.envelope, position, OFFSETS_M / C * profile.rate_hz, noise)
