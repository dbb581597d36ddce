"""What microphone 1's channel adds to the carrier's phase, from the echo of a mirror whose direction is known.

`TrackingDetector` takes the phase between the microphones for absolute. That of a flat wall or floor is known: the path
to the speaker's image behind the mirror, a distance 2 d along the normal n,
    path_k^2 = |m_k - s|^2 - 4 d n.(m_k - s) + 4 d^2,
d from the path to microphone 0, the path to microphone 1 from d. What is received besides is the channel's own. The
direct sound does not show it where it comes through the case.

A wall or a floor at which the phone's long edge points squarely is the best: there an error of the direction counts in
its square alone, one of 2 degrees by 0.03 rad. Above the ground, held at 30 degrees, one of 1 degree counts by 0.8 rad.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from obstaclewatch.beep import BeepDesign
from obstaclewatch.recording import PhoneGeometry, Recording
from obstaclewatch.recordings.alignment import BeepFinder
from obstaclewatch.signal.carrier_phase import phase_at
from obstaclewatch.signal.direct_sound import direct_sound, expected_direct_delay_s
from obstaclewatch.signal.echoes import noise_amplitude, refined_peak
from obstaclewatch.signal.matched_filter import EchoProfile, MatchedFilter
from obstaclewatch.support.arrays import Floats

LEAST_BEEPS = 8
LEAST_SNR_DB = 15.0
"""Of the echo at each microphone, 2E/N0: 0.25 rad of phase from one beep if neither receives it better."""
MOST_SCATTER_RAD = 0.7
"""Between beeps: a phone that sways by 1 degree or an echo that fades has more."""
MOST_LATE_M = 0.03
"""How far the echo at microphone 1 may lie from its place: a channel's own delay, noise, and not another echo."""
LEAST_REACH_M = 0.3
"""Nearer, the direct sound and the hand mask everything."""
OTHER_STD_RAD = 0.1
"""Deviation by what overlaps with the echo."""


@dataclass(frozen=True)
class MicPhase:
    """What microphone 1's channel adds to the phase at the beep's centre, compared with microphone 0's.

    Attributes:
        phase_rad: for `TrackingDetector(mic_phase_rad=...)`, -pi to pi.
        std_rad: its standard deviation, by noise, by that of the mirror's direction, and by other echoes.
        distance_m: from the speaker to the mirror.
        beeps: how many were used.

    >>> measured = MicPhase(phase_rad=0.4, std_rad=0.1, distance_m=1.0, beeps=10)
    >>> print(f"TrackingDetector(..., mic_phase_rad={measured.phase_rad})")
    TrackingDetector(..., mic_phase_rad=0.4)
    """

    phase_rad: float
    std_rad: float
    distance_m: float
    beeps: int


def measure_mic_phase(
    recording: Recording,
    beep: BeepDesign,
    phone: PhoneGeometry,
    tilt_rad: float,
    tilt_std_rad: float,
    reach_m: tuple[float, float],
    sound_speed_m_s: float = 343.0,
    direct_delay_s: float | None = None,
) -> MicPhase:
    """Measure at a flat mirror with the phone held still: the strongest echo within reach must be the mirror's.

    Args:
        recording: of 8 beeps or more, at the beep's rate.
        beep: the emitted signal.
        phone: speaker and microphones.
        tilt_rad: by how much the phone's top edge is pitched from the straight line to the mirror: 0 where it points at
            a wall squarely, the phone's pitch before a wall otherwise, pi / 2 more than that above level ground.
        tilt_std_rad: standard deviation of that.
        reach_m: nearest and farthest distance at which the mirror may be.
        sound_speed_m_s: speed of sound.
        direct_delay_s: calibrated delay of the direct peak at microphone 0; None takes the path through the air.

    Raises:
        NoBeepError: the recording holds no beep.
        ValueError: arguments out of range; fewer than 8 beeps in which both microphones receive the echo; an echo that
            reaches microphone 1 at another time than the mirror's, or whose phase does not stay.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign, measure_mic_phase, PhoneGeometry, Recording
    >>> beep = BeepDesign()
    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> time_s = np.arange(10 * beep.period_samples) / beep.sample_rate_hz
    >>> def train(path_m):
    ...     return beep.waveform((time_s - path_m / 343) % beep.period_s)
    >>> wall = [0.1 * train(0.0) + 0.01 * train(2.0), 0.1 * train(0.14) + 0.01 * train(2.14)]
    >>> found = measure_mic_phase(Recording(wall, beep.sample_rate_hz), beep, phone, 0.0, 0.03, reach_m=(0.5, 1.5))
    >>> print(f"{found.distance_m:.2f} m to the wall, {abs(found.phase_rad):.2f} rad of the channel")
    1.00 m to the wall, 0.00 rad of the channel
    """
    _check(recording, beep, tilt_std_rad, reach_m, sound_speed_m_s)
    _check_finite(tilt_rad=tilt_rad, tilt_std_rad=tilt_std_rad, direct_delay_s=direct_delay_s or 0.0)
    delay_s = expected_direct_delay_s(phone, sound_speed_m_s, direct_delay_s)
    mirror = _MirrorEcho(phone, tilt_rad, reach_m, sound_speed_m_s, delay_s)
    received = [
        mirror.echo_in(profile) for profile in _profiles(recording, beep, delay_s, 2.0 * reach_m[1] / sound_speed_m_s)
    ]
    found = np.array([echo for echo in received if echo is not None]).reshape(-1, 3)
    if len(found) < LEAST_BEEPS:
        raise ValueError(
            f"both microphones must receive an echo {LEAST_SNR_DB:g} dB above the noise at {reach_m[0]:g} to "
            f"{reach_m[1]:g} m in at least {LEAST_BEEPS} beeps, got {len(found)} of {len(received)}"
        )
    path_m, late_m = np.median(found[:, :2], axis=0).tolist()
    phase_rad, scatter_rad = _mean_phase(found[:, 2], late_m, tilt_rad)
    wrong_m = [image_difference_m(phone, tilt_rad + side * tilt_std_rad, path_m)[0] for side in (-1, 0, 1)]
    by_tilt = 2.0 * np.pi * beep.center_hz / sound_speed_m_s * float(np.ptp(wrong_m[:2]) + np.ptp(wrong_m[1:])) / 2.0
    std_rad = float(np.sqrt(scatter_rad**2 / len(found) + by_tilt**2 + OTHER_STD_RAD**2))
    return MicPhase(phase_rad, std_rad, image_difference_m(phone, tilt_rad, path_m)[1], len(found))


def image_difference_m(phone: PhoneGeometry, tilt_rad: float, path_m: float) -> tuple[float, float]:
    """Path to microphone 1 less that to microphone 0, by a flat mirror, and the speaker's distance from the mirror.

    Args:
        phone: speaker and microphones.
        tilt_rad: by how much the top edge is pitched from the straight line to the mirror.
        path_m: from the speaker to microphone 0 by the mirror.
    """
    normal = np.array([0.0, np.cos(tilt_rad), -np.sin(tilt_rad)])
    offset = phone.mics_m - phone.speaker_m
    toward, apart2 = offset @ normal, np.sum(offset**2, axis=1)
    distance = 0.5 * (toward[0] + np.sqrt(toward[0] ** 2 + path_m**2 - apart2[0]))
    other = np.sqrt(apart2[1] - 4.0 * distance * toward[1] + 4.0 * distance**2)
    return float(other - path_m), float(distance)


@dataclass(frozen=True)
class _MirrorEcho:
    """How the mirror's echo is measured in one beep: arguments of `measure_mic_phase`, and the direct sound's delay."""

    phone: PhoneGeometry
    tilt_rad: float
    reach_m: tuple[float, float]
    sound_speed_m_s: float
    direct_delay_s: float

    def echo_in(self, profile: EchoProfile) -> tuple[float, float, float] | None:
        """Path, m, how much later than the mirror's the echo reaches microphone 1, m, and what is left of its phase.

        None where there is no beep, or no echo loud enough at either microphone.
        """
        direct = direct_sound(profile)
        if not direct.found:
            return None
        start_s, speed = float(direct.delay_s[0]) - self.direct_delay_s, self.sound_speed_m_s
        edges_m = [2.0 * edge for edge in self.reach_m]
        first, snr = _highest(profile, 0, *(start_s + edge / speed for edge in edges_m))
        path_m = speed * (first - start_s)
        expected_m, _ = image_difference_m(self.phone, self.tilt_rad, path_m)
        middle_s, margin_s = first + expected_m / speed, 2.0 * MOST_LATE_M / speed
        second, snr2 = _highest(profile, 1, middle_s - margin_s, middle_s + margin_s)
        if min(snr, snr2) < 10.0 ** (0.1 * LEAST_SNR_DB):
            return None
        places = [(delay - profile.start_s) * profile.rate_hz for delay in (first, middle_s)]
        phase = phase_at(profile.envelope, *places) + 2.0 * np.pi * profile.reference_hz * expected_m / speed
        return path_m, speed * (second - middle_s), phase


def _highest(profile: EchoProfile, mic: int, early_s: float, late_s: float) -> tuple[float, float]:
    """Delay of the highest peak of a microphone between two delays, and its 2E/N0."""
    magnitude = profile.magnitude[mic]
    low, high = profile.position(early_s), profile.position(late_s)
    position, height = refined_peak(magnitude, low + int(np.argmax(magnitude[low : high + 1])))
    noise = max(noise_amplitude(magnitude[profile.position(0.0) :]), np.finfo(float).tiny)
    return profile.start_s + position / profile.rate_hz, 2.0 * (height / noise) ** 2


def _profiles(recording: Recording, beep: BeepDesign, direct_delay_s: float, reach_s: float) -> Iterator[EchoProfile]:
    """Every full beep period of a recording, compressed, up to delays without echoes, which give the noise."""
    compressor = MatchedFilter(beep, max(reach_s + 2e-3, beep.gap_s))
    begin = BeepFinder(beep, direct_delay_s).first_emission(recording.samples)
    while begin + beep.period_samples <= recording.samples.shape[1]:
        yield compressor.compress(recording.samples[:, begin : begin + beep.period_samples])
        begin += beep.period_samples


def _mean_phase(phase_rad: Floats, late_m: float, tilt_rad: float) -> tuple[float, float]:
    """Mean of phases (K,) on the circle, and their deviation, if they are one mirror's."""
    if abs(late_m) > MOST_LATE_M:
        raise ValueError(
            f"the echo must reach microphone 1 within {100.0 * MOST_LATE_M:g} cm of the mirror's, got "
            f"{100.0 * late_m:+.1f} cm: it is another's, or tilt_rad is not {tilt_rad:g}"
        )
    mean = complex(np.mean(np.exp(1j * phase_rad)))
    scatter = float(np.sqrt(-2.0 * np.log(min(max(abs(mean), 1e-9), 1.0))))
    if scatter > MOST_SCATTER_RAD:
        raise ValueError(
            f"the echo's phase must stay within {MOST_SCATTER_RAD:g} rad from beep to beep, got {scatter:.2f} rad: "
            "hold the phone still"
        )
    return float(np.angle(mean)), scatter


def _check(
    recording: Recording, beep: BeepDesign, tilt_std_rad: float, reach_m: tuple[float, float], sound_speed_m_s: float
) -> None:
    if recording.sample_rate_hz != beep.sample_rate_hz:
        raise ValueError(f"the recording's rate must be {beep.sample_rate_hz} Hz, got {recording.sample_rate_hz} Hz")
    if tilt_std_rad < 0.0:
        raise ValueError(f"tilt_std_rad must be at least 0, got {tilt_std_rad}")
    nearest, farthest = reach_m
    if not (LEAST_REACH_M <= nearest < farthest < np.inf):
        raise ValueError(f"reach_m must rise from at least {LEAST_REACH_M:g} m and be finite, got {reach_m}")
    if not 0.0 < sound_speed_m_s < np.inf:
        raise ValueError(f"sound_speed_m_s must be positive and finite, got {sound_speed_m_s}")


def _check_finite(**values: float) -> None:
    for name, value in values.items():
        if not np.isfinite(value):
            raise ValueError(f"{name} must be finite, got {value}")
