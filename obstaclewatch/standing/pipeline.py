"""The measurements of a phone held still: crests parted into echoes, and bearings weighed with where things can be.

Noise averaged away is what both need, and what a beep alone has not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.beep import BeepDesign
from obstaclewatch.paper.bearing import PathDifference
from obstaclewatch.paper.pipeline import EchoPipeline, Placed
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.signal.carrier_cycle import PathEvidence, likeliest_cycle
from obstaclewatch.signal.echoes import Echoes
from obstaclewatch.signal.matched_filter import EchoProfile
from obstaclewatch.signal.overlap import Crests, nearest_echoes, parted_crests, pulse_table
from obstaclewatch.standing.bearing_posterior import Attitude, bearing_posterior
from obstaclewatch.support.arrays import Floats
from obstaclewatch.walker.ground_height import GroundListener


class StandingPipeline(EchoPipeline):
    """`EchoPipeline` that parts overlapping echoes, with bearings of things at any height once the ground is heard.

    Arguments and errors as there, and the lift must be known.
    """

    def __init__(
        self,
        beep: BeepDesign,
        phone: PhoneGeometry,
        settings: PaperSettings,
        sound_speed_m_s: float,
        pitch_rad: float,
    ) -> None:
        super().__init__(beep, phone, settings, sound_speed_m_s, pitch_rad)
        self._sin_pitch = float(np.sin(pitch_rad))
        speaker_ahead_m = self._speaker_cosine * float(self._speaker_m[0])
        self._ground = GroundListener(self._separation_m, speaker_ahead_m, pitch_rad, self.sound_speed_m_s)
        self._table = pulse_table(beep)
        self._crests: dict[int, Crests] = {}  # of the beep in hand

    def _echoes_of(self, profile: EchoProfile, channel: int, peaks: NDArray[np.intp], noise: float) -> Echoes:
        """Echoes at peaks of a channel: one each, or two where that explains the crest."""
        self._crests[channel] = parted_crests(profile.envelope[channel], peaks, self._table, noise)
        return self._crests[channel].echoes(profile)

    def _evidence(self, profile: EchoProfile, echoes: Echoes, snr: Floats, difference: PathDifference) -> PathEvidence:
        """As there, with phases of the echoes themselves instead of the crests', and what parting costs in delay."""
        heard = super()._evidence(profile, echoes, snr, difference)
        if np.isnan(heard.envelope_m).all():  # equal channels are not even parted
            return heard
        delay2_s = echoes.delay_s + heard.envelope_m / self.sound_speed_m_s
        (first, std), (second, std2) = (
            nearest_echoes(self._crests[channel], (delay_s - profile.start_s) * profile.rate_hz)
            for channel, delay_s in enumerate((echoes.delay_s, delay2_s))
        )
        parting_m = self.sound_speed_m_s / profile.rate_hz * np.hypot(std, std2)
        phase_rad = second - first - (self.settings.mic_phase_rad or 0.0)
        return heard._replace(
            envelope_std_m=np.hypot(heard.envelope_std_m, parting_m),
            phase_rad=np.where(np.isnan(heard.phase_rad), np.nan, phase_rad),
        )

    def _placed(self, profile: EchoProfile, start_s: float, path1_m: Floats, evidence: PathEvidence) -> Placed:
        """As there where the ground is not heard, and of what no bearing ahead explains."""
        level = super()._placed(profile, start_s, path1_m, evidence)
        height_m = self._ground.height_m(profile, start_s)
        if np.isnan(height_m):
            return level
        attitude = Attitude(self._sin_pitch, self._cos_pitch, height_m, self._separation_m)
        bearing_rad, spread_rad, cycles = bearing_posterior(level.range_m, evidence, attitude)
        ahead = ~np.isnan(bearing_rad)
        u_m, _ = likeliest_cycle(evidence, cycles)
        range_m, range2_m = self._ranges(path1_m, u_m)
        return Placed(
            np.where(ahead, range_m, level.range_m),
            np.where(ahead, range2_m, level.range2_m),
            np.where(ahead, bearing_rad, level.bearing_rad),
            np.where(ahead, spread_rad, level.bearing_std_rad),
            level.clamped & ~ahead,
        )
