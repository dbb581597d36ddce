"""How the phone oscillates with the walker's steps, measured in the echo of the ground beneath it.

That echo stays while everything else closes in, and it is loud at both microphones. Its range is the phone's height;
its phase between the microphones is the phone's pitch: the path difference to the ground's mirror image is
    u = sqrt(4 h^2 - 4 h L sin(pitch) + L^2) - 2 h,    du/dpitch = -2 h L cos(pitch) / (2 h + u).
Both follow the step, so that a sinusoid of one frequency is fitted to both; what the chirp reads ahead of its time is
taken off the range's. On 22 rendered walks the pitch, which oscillates by 18 mrad rms, is left with 2 mrad, the height
with 2 mm of 13. The fore-aft oscillation follows: a walking trunk is fastest when it is lowest (Cavagna, Thys and
Zamboni 1976, J. Physiol. 262:639), its size is an assumption.
"""

from __future__ import annotations

from collections import deque
from math import sqrt
from typing import NamedTuple

import numpy as np

from obstaclewatch.signal.carrier_phase import phase_at
from obstaclewatch.signal.echoes import refined_peak
from obstaclewatch.signal.matched_filter import EchoProfile, nearest_sample
from obstaclewatch.support.arrays import Complexes, Floats
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.order_statistic import median
from obstaclewatch.walker.gait import STEP_HZ, STEP_STD_HZ
from obstaclewatch.walker.sinusoid import common_sinusoid

STEP_RAD_S = 2.0 * np.pi * np.arange(1.3, 2.45, 0.05)
"""Steps of adults (gait.STEP_HZ) and a margin."""
LOG_PRIOR = -0.5 * ((STEP_RAD_S / (2.0 * np.pi) - STEP_HZ) / STEP_STD_HZ) ** 2
NEAR_RATES = 3
"""On either side of the walker's own, 0.15 Hz, which are tried once that is known."""
REACH_M = 0.13
"""How far from its mean place the ground may be read: a bob of 2.4 cm reads 7 cm."""
MEMORY_BEEPS = 24
LEAST_BEEPS = 12
"""A second: two steps."""
RATE_BEEPS = 60
"""Over which the walker's cadence is taken, 5 s: what crosses the ground's echo spoils it for a second or two. On 252
development walks it is off by 2.8 % rms with the median and the prior, and by 7.3 % without either. Another pace is
taken up after 4 to 6 s."""
READ_SCALE_M, PHASE_SCALE = 0.012, 0.35
"""Residuals, m and rad, at which a beep's weight has halved."""
LEAST_SHARE = 0.6
"""Of the variance that a sinusoid must explain to be believed. Of 24 random numbers the best of all frequencies
explains 0.25 (median) to 0.53 (95 %), of the ground's echo on rendered walks mostly 0.9 and more."""
FORE_AFT_M = 0.010
"""Of the trunk, zero to peak."""
LEAST_COS = 0.2
"""A phone that stands on end says nothing of its pitch; noise must not become oscillation."""


class GroundEcho(NamedTuple):
    """The ground in one beep: range as the chirp reads it, m, and phase of microphone 1 after microphone 0, rad."""

    read_m: float
    phase_rad: float


class Oscillation(NamedTuple):
    """Departures from the mean as phasors X, Re(X exp(j step_rad_s t)).

    Attributes:
        step_rad_s: angular frequency of the steps.
        pitch_rad, height_m, fore_aft_m: of the phone's pitch, its height, and its place along the walk; 0 where not
            received.
    """

    step_rad_s: float
    pitch_rad: complex
    height_m: complex
    fore_aft_m: complex


STEADY = Oscillation(0.0, 0.0j, 0.0j, 0.0j)
"""No oscillation, or none that is known."""


@compiled
def oscillation_at(oscillation: Oscillation, time_s: Floats) -> Floats:
    """(3, K) pitch, height and fore-aft oscillation at that time."""
    waves = np.empty((3, len(time_s)))
    for beep in range(len(time_s)):
        phasor = complex(np.cos(oscillation.step_rad_s * time_s[beep]), np.sin(oscillation.step_rad_s * time_s[beep]))
        waves[0, beep] = (oscillation.pitch_rad * phasor).real
        waves[1, beep] = (oscillation.height_m * phasor).real
        waves[2, beep] = (oscillation.fore_aft_m * phasor).real
    return waves


@compiled
def oscillation_as_read(oscillation: Oscillation, time_s: Floats, ahead_s: float) -> Floats:
    """(3, K) the same as a chirp reads them that meets the obstacle then: x + ahead_s dx/dt."""
    ahead = complex(1.0, oscillation.step_rad_s * ahead_s)
    read = Oscillation(
        oscillation.step_rad_s,
        oscillation.pitch_rad * ahead,
        oscillation.height_m * ahead,
        oscillation.fore_aft_m * ahead,
    )
    return oscillation_at(read, time_s)


def ground_path_difference_m(height_m: float, separation_m: float, sin_pitch: float) -> float:
    """From microphone 1 to microphone 0's image in the ground, less that from microphone 0, at that height."""
    image_m = 2.0 * height_m
    return sqrt(image_m**2 - 2.0 * image_m * separation_m * sin_pitch + separation_m**2) - image_m


def ground_echo(
    profile: EchoProfile, start_s: float, path_m: float, difference_m: float, sound_speed_m_s: float
) -> GroundEcho:
    """The strongest sound of a beep about the ground's place.

    Args:
        profile: the beep compressed, with what stands still.
        start_s: its emission, on the profile's axis.
        path_m: mean path to the ground and back.
        difference_m: path difference at which microphone 1 is read.
        sound_speed_m_s: speed of sound.
    """
    early_s, late_s = (start_s + (path_m + side * 2.0 * REACH_M) / sound_speed_m_s for side in (-1, 1))
    later_s, about = difference_m / sound_speed_m_s, (profile.start_s, profile.rate_hz)
    delay_s, phase_rad = _strongest(profile.magnitude, profile.envelope, *about, early_s, late_s, later_s)
    return GroundEcho(0.5 * sound_speed_m_s * (delay_s - start_s), phase_rad)


@compiled
def _strongest(
    magnitude: Floats,
    envelope: Complexes,
    start_s: float,
    rate_hz: float,
    early_s: float,
    late_s: float,
    later_s: float,
) -> tuple[float, float]:
    """Delay of microphone 0's highest peak between two, and the phase of microphone 1 that much later against it."""
    first = nearest_sample(early_s, start_s, rate_hz, magnitude.shape[1])
    last = nearest_sample(late_s, start_s, rate_hz, magnitude.shape[1])
    position, _ = refined_peak(magnitude[0], first + int(np.argmax(magnitude[0, first : last + 1])))
    return start_s + position / rate_hz, phase_at(envelope, position, position + later_s * rate_hz)


class OscillationEstimator:
    """Remembers the ground's echo and estimates the oscillation.

    Args:
        separation_m: between the microphones.
        wavelength_m: of the carrier.
        pitch_rad: mean pitch of the phone.
        ahead_s: how far ahead the chirp reads.
    """

    def __init__(self, separation_m: float, wavelength_m: float, pitch_rad: float, ahead_s: float) -> None:
        self._separation_m, self._wavelength_m, self._ahead_s = separation_m, wavelength_m, ahead_s
        self.set_pitch(pitch_rad)
        self._received = deque[tuple[float, float, float]](maxlen=MEMORY_BEEPS)
        self._rates_rad_s = deque[float](maxlen=RATE_BEEPS)

    @property
    def step_hz(self) -> float:
        """Steps a second: the median of what the last beeps said; 0 where none said any."""
        return self._step_rad_s() / (2.0 * np.pi)

    def set_pitch(self, pitch_rad: float) -> None:
        """Take another pitch of the phone for the mean; what was received stays."""
        self._sin_pitch, self._cos_pitch = float(np.sin(pitch_rad)), max(float(np.cos(pitch_rad)), LEAST_COS)

    def clear(self) -> None:
        """Forget everything."""
        self._received.clear()
        self._rates_rad_s.clear()

    def add(self, time_s: float, echo: GroundEcho) -> None:
        """One beep's ground, at the time at which the beep's centre met it."""
        self._received.append((time_s, echo.read_m, echo.phase_rad))

    def oscillation(self, height_m: float) -> Oscillation:
        """The oscillation over the beeps remembered; what no step explains is left out.

        Args:
            height_m: of microphone 0 above the ground.
        """
        if len(self._received) < LEAST_BEEPS:
            return STEADY
        per_phase, tried = self._pitch_per_phase(height_m), self._tried()
        found = self._fitted(tried, per_phase)
        if found.step_rad_s in STEP_RAD_S[tried][[0, -1]]:  # the walker may have changed pace
            found = self._fitted(slice(None), per_phase)
        self._rates_rad_s.append(found.step_rad_s)
        return found

    def _fitted(self, tried: slice, pitch_per_phase: float) -> Oscillation:
        rates, received = (STEP_RAD_S[tried], LOG_PRIOR[tried]), np.array(self._received)
        return Oscillation(*_oscillation(received, *rates, pitch_per_phase, self._ahead_s))

    def _tried(self) -> slice:
        """Which rates come into question: those about the walker's own where it is known for a second or more."""
        usual_rad_s = self._step_rad_s(LEAST_BEEPS)
        if usual_rad_s == 0.0:
            return slice(None)
        own = int(np.argmin(np.abs(STEP_RAD_S - usual_rad_s)))
        return slice(max(own - NEAR_RATES, 0), own + NEAR_RATES + 1)

    def _step_rad_s(self, least_beeps: int = 1) -> float:
        """The median rate of the beeps that said one; 0 where fewer did."""
        said = [rate for rate in self._rates_rad_s if rate > 0.0]
        return float(np.median(said)) if len(said) >= least_beeps else 0.0

    def _pitch_per_phase(self, height_m: float) -> float:
        """du = -wavelength / 2 pi dphase, and du/dpitch as above."""
        u_m = ground_path_difference_m(height_m, self._separation_m, self._sin_pitch)
        slope = -2.0 * height_m * self._separation_m * self._cos_pitch / (2.0 * height_m + u_m)
        return -self._wavelength_m / (2.0 * np.pi) / slope


@compiled
def _oscillation(
    received: Floats, rates_rad_s: Floats, log_prior: Floats, pitch_per_phase: float, ahead_s: float
) -> tuple[float, complex, complex, complex]:
    """`Oscillation` of (K, 3) times and `GroundEcho`s; steady where no step explains enough of them."""
    time_s, read_m, phase_rad = received[:, 0].copy(), received[:, 1].copy(), received[:, 2].copy()
    departures = _departures(read_m, phase_rad)
    step_rad_s, phasors, shares = common_sinusoid(time_s, departures, rates_rad_s, log_prior)
    if shares[np.argmax(shares)] < LEAST_SHARE:
        return 0.0, 0.0j, 0.0j, 0.0j
    read = phasors[0] if shares[0] >= LEAST_SHARE else 0.0j
    phase = phasors[1] if shares[1] >= LEAST_SHARE else 0.0j
    height = READ_SCALE_M * read / complex(1.0, step_rad_s * ahead_s)
    fore_aft = 1j * FORE_AFT_M * height / abs(height) if abs(height) > 0.0 else 0.0j
    return step_rad_s, PHASE_SCALE * phase * pitch_per_phase, height, fore_aft


@inlined
def _departures(read_m: Floats, phase_rad: Floats) -> Floats:
    """(2, K) of ranges from their median, and of phases from their mean on the circle, in units of their scales."""
    departures, middle = np.empty((2, len(read_m))), median(read_m)
    rotated = 0.0j
    for beep in range(len(read_m)):
        rotated += np.exp(1j * phase_rad[beep])
    for beep in range(len(read_m)):
        departures[0, beep] = (read_m[beep] - middle) / READ_SCALE_M
        departures[1, beep] = np.angle(np.exp(1j * phase_rad[beep]) * rotated.conjugate()) / PHASE_SCALE
    return departures
