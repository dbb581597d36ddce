"""The measurements of a phone held still: what is heard by both microphones, weighed with where things can be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.beep import BeepDesign
from obstaclewatch.carrier_cycle import PathEvidence, likeliest_cycle
from obstaclewatch.cone_posterior import Attitude, bearing_posterior
from obstaclewatch.ground_height import GroundListener
from obstaclewatch.matched_filter import EchoProfile
from obstaclewatch.pipeline import EchoPipeline, Placed
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.settings import PaperSettings


class StandingPipeline(EchoPipeline):
    """`EchoPipeline`, with bearings of things at any height once the ground is heard.

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

    def _placed(
        self, profile: EchoProfile, start_s: float, path1_m: NDArray[np.float64], evidence: PathEvidence
    ) -> Placed:
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
