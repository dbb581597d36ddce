"""One beep to the peaks that may move: ringing and clutter taken away, a low threshold, both microphones.

The threshold is meant for a tracker: it lets some noise pass, which no straight approach explains.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sin
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import Flag
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.recordings.sample_faults import flag_of_second
from obstaclewatch.recordings.streaming import reach_s
from obstaclewatch.signal.background import ClutterMap, CoherentBackground
from obstaclewatch.signal.carrier_phase import OFFSETS_M
from obstaclewatch.signal.clock_slip import ClockSlip
from obstaclewatch.signal.damaged_beeps import DamagedBeeps
from obstaclewatch.signal.direct_sound import direct_sound, expected_direct_delay_s
from obstaclewatch.signal.matched_filter import EchoProfile, MatchedFilter
from obstaclewatch.signal.pulse import rms_bandwidth_hz
from obstaclewatch.signal.two_mics import distance_of
from obstaclewatch.support.arrays import Complexes, Floats, SingleComplexes, Singles
from obstaclewatch.support.compiled import compiled
from obstaclewatch.tracking.peak_readings import MOST_PEAKS, Reception, peak_readings
from obstaclewatch.tracking.settings import TrackingSettings
from obstaclewatch.walker.ground_height import HELD_HEIGHTS_M
from obstaclewatch.walker.pitch_estimate import HALF_POWER, PitchEstimator
from obstaclewatch.walker.pitch_oscillation import GroundEcho, ground_echo, ground_path_difference_m

BACKGROUND_BEEPS = 16
"""Beeps in the coherent mean; an echo that moves leaves 1/16 of itself in its earlier places."""
CLUTTER_BEEPS = 12
CLUTTER_HALF_WIDTH_S = 0.25e-3
"""How far a standing echo may wander between beeps: 4.3 cm of range. Range-Doppler coupling makes gait look larger."""
SETTLING_BEEPS = 2
"""Beeps without candidates, for the background to be known."""
NOISE_WINDOW_S = 8e-3
"""Over which noise is measured: 1.4 m of range. Windows overlap by half."""
GROUND_CONTRAST = 3.0
"""How far above the mean clutter the ground's echo must stand."""
PITCH_STEP_RAD = np.deg2rad(1.5)
"""By how much the pitch that is estimated must depart from the one in use to replace it."""
USUAL_GROUND_M, GROUND_SPREAD_M = 1.35, 0.15
"""Where no echo stands out: 0.745 of 1.74 m of stature, and half a phone's length at 30 degrees; and how people differ,
generously. Walls alongside and what comes via ground and body stand at their distances as well, often louder."""


@dataclass(frozen=True)
class MovingPeaks:
    """Peaks of one beep, nearest first, as the chirp reads them: `range_doppler_s` ahead of their time.

    Attributes:
        readings: (5, n) of each peak its power, height squared over the local noise power, of which 1 is noise, and
            which is half of 2E/N0; its range from microphone 0, and the range's deviation from noise alone; its level
            relative to the direct sound, dB, and 2E/N0, dB, at microphone 0.
        second: (n, W) microphone 1 around each peak, see `carrier_phase`; NaN if it says nothing.
        log_ratio: (M,) of an echo against noise in cells of two samples, see `track_before_detect`.
        moved: (2, 2M or 2M + 1) envelopes of what moved, two samples a cell.
        first_m, cell_m: range of the first cell, and their spacing.
        flag: why microphone 1 says nothing, NO_SECOND_MIC or IDENTICAL_CHANNELS; NONE if it does.
    """

    readings: Floats
    second: SingleComplexes
    log_ratio: Singles
    moved: Complexes
    first_m: float
    cell_m: float
    flag: Flag

    def __len__(self) -> int:
        return self.readings.shape[1]

    @property
    def range_m(self) -> Floats:
        """(n,) from microphone 0."""
        return self.readings[1]


class PeakFinder:
    """Compresses beeps and hands out what may move, with the memory that this needs.

    Args:
        beep: the emitted signal.
        phone: speaker and microphones.
        settings: range that is searched, and the calibrated direct sound.
        sound_speed_m_s: speed of sound.
        pitch_rad: pitch of the phone, for the height above the ground; None if it is not given: it is then
            taken for level until the ground is received (`pitch_estimate`).

    Attributes:
        ground_m: height of microphone 0 above the ground, as known so far.
        pitch_rad: the pitch, as given or as estimated so far.
        ground: the ground in the last beep; None before its place is known.
    """

    def __init__(
        self,
        beep: BeepDesign,
        phone: PhoneGeometry,
        settings: TrackingSettings,
        sound_speed_m_s: float,
        pitch_rad: float | None = 0.0,
    ) -> None:
        self._settings, self._c = settings, sound_speed_m_s
        self._filter = MatchedFilter(beep, reach_s(beep, settings.far_m, sound_speed_m_s))
        self._baseline_m, self._speaker_cosine = float(phone.speaker_to_mic_m[0]), phone.speaker_cosine
        self._direct_delay_s = expected_direct_delay_s(phone, sound_speed_m_s, settings.direct_delay_s)
        self._damage = DamagedBeeps()
        self._slip, self._background = ClockSlip(self._filter), CoherentBackground(BACKGROUND_BEEPS)
        self._clutter = ClutterMap(CLUTTER_BEEPS, round(CLUTTER_HALF_WIDTH_S * self._filter.rate_hz))
        # As many samples in every beep: rounding both ends of the reach apart would give the map one more or one less.
        self._span = round(2.0 * (settings.far_m - settings.near_m) / sound_speed_m_s * self._filter.rate_hz) + 1
        if self._span < self._noise_window:
            raise ValueError(
                f"far_m must be {0.5 * NOISE_WINDOW_S * sound_speed_m_s:.2f} m or more beyond near_m to measure "
                f"the noise, got {settings.near_m} and {settings.far_m}"
            )
        self._received, self._floor = 0, 10.0 ** (settings.floor_db / 20.0)
        self._reception, self._offset = self._reception_of(beep), OFFSETS_M / sound_speed_m_s * self._filter.rate_hz
        self._separation_m = phone.mic_separation_m
        estimator = PitchEstimator(
            self._separation_m,
            sound_speed_m_s / self._filter.rate_hz,
            self._speaker_cosine * self._baseline_m,
            sound_speed_m_s * HALF_POWER / rms_bandwidth_hz(beep),
        )
        self._pitch_estimator = estimator if pitch_rad is None else None
        self.pitch_rad = pitch_rad or 0.0
        self._ground_path_m: float | None = None
        self.ground_m = USUAL_GROUND_M
        self.ground: GroundEcho | None = None

    @property
    def wavelength_m(self) -> float:
        """Of the carrier whose phase the second channel keeps."""
        return self._c / self._filter.reference_hz

    @property
    def _noise_window(self) -> int:
        """Samples over which noise is measured, even."""
        return 2 * round(0.5 * NOISE_WINDOW_S * self._filter.rate_hz)

    @property
    def cells(self) -> int:
        """Cells of the log ratio."""
        return self._span // 2

    @property
    def samples(self) -> int:
        """Of the envelopes of what moved."""
        return self._span

    @property
    def cell_m(self) -> float:
        """Their spacing: two samples of the two-way path."""
        return self._c / self._filter.rate_hz

    def _reception_of(self, beep: BeepDesign) -> tuple[float | int, ...]:
        """`Reception`, as a plain tuple: a third of a named one's time to hand over."""
        rate_hz = self._filter.rate_hz
        one_m = self._c / (2.0 * np.pi * rms_bandwidth_hz(beep))
        samples = self._noise_window, round(1e-3 * rate_hz), round(0.35e-3 * rate_hz)
        return tuple(
            Reception(self._filter.start_s, rate_hz, self._c, self._baseline_m, self._speaker_cosine, one_m, *samples)
        )

    def reset(self) -> None:
        """Forget all beeps."""
        self._damage.clear()
        self._forget()

    @property
    def began_anew(self) -> bool:
        """Whether the first beep turned out to be damaged with the last one, and is forgotten."""
        return self._damage.was_first

    def _forget(self) -> None:
        """Forget all that beeps left but how loud their noise was."""
        self._slip.clear()
        self._background.clear()
        self._clutter.clear()
        self._received = 0
        self._ground_path_m = None
        self.ground_m = USUAL_GROUND_M
        self.ground = None
        if self._pitch_estimator is not None:
            self._pitch_estimator.clear()
            self.pitch_rad = 0.0

    def find(self, block: NDArray[np.floating]) -> tuple[float, MovingPeaks] | Literal[Flag.NO_BEEP, Flag.DAMAGED]:
        """Emission relative to the block's first sample, s, and the peaks; why not if nothing is to be learned."""
        profile = self._filter.compress(block)
        direct = direct_sound(profile)
        if not direct.found:
            return Flag.NO_BEEP
        if self._damage.found(profile, direct):
            return Flag.DAMAGED
        if self._damage.was_first:
            self._forget()
        profile, slip_s = self._slip.held(block, profile, direct)
        start_s = float(direct.delay_s[0]) - slip_s - self._direct_delay_s
        height = float(direct.amplitude[0])
        moved = self._background.subtract(profile.envelope)
        self._received += 1
        near = profile.position(start_s + 2.0 * self._settings.near_m / self._c)
        first = min(near, profile.envelope.shape[1] - self._span)
        first_s, magnitude = profile.start_s + first / profile.rate_hz - start_s, np.abs(moved)
        received = magnitude[0, first : first + self._span]
        clutter = self._clutter.level(received)
        self._sound_the_ground(first_s)
        self.ground = self._ground_now(profile, start_s)
        flag = flag_of_second(block, direct)
        found = peak_readings(
            moved,
            magnitude,
            clutter,
            self._offset,
            self._reception,
            first,
            start_s,
            height,
            height * self._floor,
            MOST_PEAKS if self._received > SETTLING_BEEPS else 0,
            flag is not Flag.NONE,
        )
        first_m = distance_of(self._c * (first_s + 0.5 / self._filter.rate_hz), self._baseline_m, self._speaker_cosine)
        moved = moved[:, first : first + self._span]
        return start_s + slip_s, MovingPeaks(*found, moved, first_m, self.cell_m, flag)

    def _sound_the_ground(self, first_s: float) -> None:
        """Height of microphone 0 above the ground: where clutter is strongest for where it is to be expected."""
        if self._clutter.mean is None:
            return
        middle = _middle_that_stands_out(self._clutter.mean, first_s, self._filter.rate_hz, self._c)
        if middle >= 0.0:
            self._ground_path_m = self._c * (first_s + middle / self._filter.rate_hz)
            self.ground_m = distance_of(
                self._ground_path_m, self._baseline_m, -self._speaker_cosine * sin(self.pitch_rad)
            )

    def _ground_now(self, profile: EchoProfile, start_s: float) -> GroundEcho | None:
        """The ground in this beep; None before its place is known."""
        if self._ground_path_m is None:
            return None
        difference_m = ground_path_difference_m(self.ground_m, self._separation_m, sin(self.pitch_rad))
        ground = ground_echo(profile, start_s, self._ground_path_m, difference_m, self._c)
        if self._pitch_estimator is not None:
            delay_s = start_s + 2.0 * ground.read_m / self._c
            self._pitch_estimator.add(profile.magnitude[1], (delay_s - profile.start_s) * profile.rate_hz)
            estimated_rad = self._pitch_estimator.pitch_rad(self.ground_m)
            if abs(estimated_rad - self.pitch_rad) > PITCH_STEP_RAD:
                self.pitch_rad = estimated_rad
        return ground


@compiled
def _middle_that_stands_out(clutter: Floats, first_s: float, rate_hz: float, sound_speed_m_s: float) -> float:
    """Middle of the peak of clutter (S,) that is highest for how far it is from where the ground usually is, samples.

    -1 if it does not stand out. The map's peaks are widened, so that the middle is that of what is nearly as high.
    """
    low = round((2.0 * HELD_HEIGHTS_M[0] / sound_speed_m_s - first_s) * rate_hz)
    high = round((2.0 * HELD_HEIGHTS_M[1] / sound_speed_m_s - first_s) * rate_hz)
    usual = (2.0 * USUAL_GROUND_M / sound_speed_m_s - first_s) * rate_hz
    spread = 2.0 * GROUND_SPREAD_M / sound_speed_m_s * rate_hz
    low, high = max(low, 0), min(high, len(clutter))
    best, most = -1, 0.0
    for sample in range(low, high):
        likely = clutter[sample] * np.exp(-0.5 * ((sample - usual) / spread) ** 2)
        if likely > most:
            best, most = sample, likely
    if best < 0 or not clutter[best] > GROUND_CONTRAST * clutter.mean():
        return -1.0
    first, last, least = best, best, 0.8 * clutter[best]
    while first > low and clutter[first - 1] > least:
        first -= 1
    while last < high - 1 and clutter[last + 1] > least:
        last += 1
    return 0.5 * (first + last)
