"""The measurements of a phone held still: beeps averaged, crests parted, bearings over the heights of things.

Noise averaged away is what all need, and what a beep alone has not.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.beep import BeepDesign
from obstaclewatch.paper.bearing import PathDifference
from obstaclewatch.paper.measurement import Measurement
from obstaclewatch.paper.pipeline import Placed, StillPipeline
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.signal.beep_averaging import AveragedBeeps
from obstaclewatch.signal.carrier_cycle import (
    OVERLAP_STD_M,
    PHASE_STD_RAD,
    DifferenceReadings,
    likeliest_cycle,
    within_cycle,
)
from obstaclewatch.signal.clock_slip import ClockSlip
from obstaclewatch.signal.direct_sound import DirectSound, direct_sound
from obstaclewatch.signal.echoes import Echoes, noise_amplitude
from obstaclewatch.signal.matched_filter import EchoProfile
from obstaclewatch.signal.overlap import Crests, nearest_echoes, parted_crests, pulse_table
from obstaclewatch.signal.two_mics import path_difference_at
from obstaclewatch.standing.bearing_posterior import Attitude, bearing_posterior
from obstaclewatch.support.arrays import Floats
from obstaclewatch.walker.ground_height import GroundFinder


class StandingPipeline(StillPipeline):
    """`StillPipeline` of averaged beeps that parts overlapping echoes and takes the carrier where its phase is known.

    Arguments, errors and results as there, and

        mic_phase_rad: what microphone 1's channel adds to the phase at the beep's centre; None for the envelopes alone.
        averaged_beeps: over how many beeps the running mean forgets.
    """

    def __init__(
        self,
        beep: BeepDesign,
        phone: PhoneGeometry,
        settings: PaperSettings,
        sound_speed_m_s: float,
        pitch_rad: float | None,
        mic_phase_rad: float | None,
        averaged_beeps: int,
    ) -> None:
        super().__init__(beep, phone, settings, sound_speed_m_s, pitch_rad)
        self._mic_phase_rad = mic_phase_rad
        self._slip, self._slip_s, self._mean = ClockSlip(self._filter), 0.0, AveragedBeeps(averaged_beeps)
        self._pitch_rad = pitch_rad
        speaker_ahead_m = self._speaker_cosine * float(self._speaker_m[0])
        self._ground = GroundFinder(self._separation_m, speaker_ahead_m, pitch_rad or 0.0, self.sound_speed_m_s)
        self._table = pulse_table(beep)
        self._crests: dict[int, Crests] = {}  # of the beep in hand

    def _forget(self) -> None:
        """Forget all that beeps left but how loud their noise was."""
        super()._forget()
        self._slip.clear()
        self._mean.clear()

    def measure(self, block: NDArray[np.floating], time_s: float) -> Measurement:
        """One beep period to its candidates; see `EchoPipeline.measure`."""
        self._slip_s = 0.0
        found = super().measure(block, time_s)
        return replace(found, start_s=found.start_s + self._slip_s) if self._slip_s else found

    def _settled(
        self, block: NDArray[np.floating], profile: EchoProfile, direct: DirectSound
    ) -> tuple[EchoProfile, DirectSound]:
        """The mean of this beep's profile and of earlier ones, all in phase; a block without a beep is passed over."""
        if not direct.found:
            return profile, direct
        profile, self._slip_s = self._slip.held(block, profile, direct)
        mean = self._mean.add(profile)
        return mean, direct_sound(mean)

    def _echoes_of(self, profile: EchoProfile, channel: int, peaks: NDArray[np.intp], noise: float) -> Echoes:
        """Echoes at peaks of a channel: one each, or two where that explains the crest."""
        self._crests[channel] = parted_crests(profile.envelope[channel], peaks, self._table, noise)
        return self._crests[channel].echoes(profile)

    def _placed(
        self, profile: EchoProfile, echoes: Echoes, start_s: float, snr: Floats, difference: PathDifference
    ) -> Placed:
        """By the carrier's likeliest cycle; over all heights of what lies ahead, where pitch and ground are known."""
        path1_m, readings = self._path_m(echoes, start_s), self._difference_readings(profile, echoes, snr, difference)
        level = self._level(path1_m, *within_cycle(readings, self._longest_m(path1_m)))
        height_m = np.nan if self._pitch_rad is None else self._ground.height_m(profile, start_s)
        if self._pitch_rad is None or np.isnan(height_m):
            return level
        attitude = Attitude(float(np.sin(self._pitch_rad)), self._cos_pitch, height_m, self._separation_m)
        bearing_rad, spread_rad, cycles = bearing_posterior(level.range_m, readings, attitude)
        ahead = ~np.isnan(bearing_rad)
        u_m, _ = likeliest_cycle(readings, cycles)
        range_m, range2_m = self._ranges(path1_m, u_m)
        return Placed(
            np.where(ahead, range_m, level.range_m),
            np.where(ahead, range2_m, level.range2_m),
            np.where(ahead, bearing_rad, level.bearing_rad),
            np.where(ahead, spread_rad, level.bearing_std_rad),
            level.clamped & ~ahead,
        )

    def _difference_readings(
        self, profile: EchoProfile, echoes: Echoes, snr: Floats, difference: PathDifference
    ) -> DifferenceReadings:
        """What envelopes and carriers say of path differences; NaN phases where the carrier says nothing."""
        snr2 = 2.0 * (difference.amplitude / noise_amplitude(profile.magnitude[1, profile.position(0.0) :])) ** 2
        cycle_m, envelope_m = self.sound_speed_m_s / profile.reference_hz, difference.u_m
        if np.isnan(envelope_m).all():  # equal channels: no crest of microphone 1 was parted
            return DifferenceReadings(envelope_m, envelope_m, envelope_m, envelope_m, cycle_m)
        delay2_s = echoes.delay_s + envelope_m / self.sound_speed_m_s
        (first, std), (second, std2) = (
            nearest_echoes(self._crests[channel], (delay_s - profile.start_s) * profile.rate_hz)
            for channel, delay_s in enumerate((echoes.delay_s, delay2_s))
        )
        parting_m = self.sound_speed_m_s / profile.rate_hz * np.hypot(std, std2)
        if self._mic_phase_rad is None:
            by_envelopes = np.sqrt(2.0) * self.sound_speed_m_s * self._pulse.delay_std_s(snr)
            unknown = np.full(len(echoes), np.nan)
            return DifferenceReadings(envelope_m, np.hypot(by_envelopes, parting_m), unknown, unknown, cycle_m)
        delay_std_s = np.hypot(self._pulse.delay_std_s(snr), self._pulse.delay_std_s(snr2))
        by_envelopes = np.hypot(self.sound_speed_m_s * delay_std_s, OVERLAP_STD_M)
        return DifferenceReadings(
            envelope_m,
            np.hypot(by_envelopes, parting_m),
            np.where(difference.body_deducted, np.nan, second - first - self._mic_phase_rad),
            np.sqrt(1.0 / snr + 1.0 / snr2 + PHASE_STD_RAD**2),
            cycle_m,
        )

    def _longest_m(self, path1_m: Floats) -> Floats:
        """Path difference of what is straight ahead at the phone's height."""
        longest: Floats = path_difference_at(0.5 * path1_m, self._cos_pitch, self._separation_m)
        return longest
