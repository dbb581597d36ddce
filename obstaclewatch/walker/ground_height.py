"""How high a phone is held, by the ground's echo at microphone 1.

Pitched, the phone looks away from the ground, and microphone 1, at its lower end, looks down at it: what it receives
louder than microphone 0 does within the heights at which phones are held is the ground. On microphone 0 the same echo
may drown in the loudspeaker's ringing.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.signal.echoes import local_maxima, noise_amplitude, refined_peak
from obstaclewatch.signal.matched_filter import EchoProfile
from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled

HELD_HEIGHTS_M = (1.0, 1.7)
"""Of microphone 0 above the ground, at which a phone may be held."""
LEAST_HEIGHT = 4.0
"""Of the ground's echo at microphone 1, in rms of its noise: 15 dB."""


class GroundFinder:
    """Finds the ground in compressed beeps.

    Args:
        separation_m: between the microphones.
        speaker_ahead_m: of the loudspeaker before microphone 0, along the line from microphone 1; negative behind it.
        pitch_rad: pitch of the phone.
        sound_speed_m_s: speed of sound.
    """

    def __init__(self, separation_m: float, speaker_ahead_m: float, pitch_rad: float, sound_speed_m_s: float) -> None:
        self._separation_m, self._ahead_m, self._c = separation_m, speaker_ahead_m, sound_speed_m_s
        self._sin_pitch, self._cos_pitch = float(np.sin(pitch_rad)), float(np.cos(pitch_rad))

    def height_m(self, profile: EchoProfile, start_s: float) -> float:
        """Height of microphone 0 above the ground; NaN if microphone 1 receives no ground.

        Args:
            profile: a beep compressed, with what stands still.
            start_s: its emission, on the profile's axis.
        """
        first, last = (profile.position(start_s + self.path_m(height) / self._c) for height in HELD_HEIGHTS_M)
        least = LEAST_HEIGHT * noise_amplitude(profile.magnitude[1, first:])
        later = (self.path_m(HELD_HEIGHTS_M[0]) - self.path_m(HELD_HEIGHTS_M[0], mic=0)) / self._c * profile.rate_hz
        position = _louder_at_second(profile.magnitude, first, last, round(later), least)
        if np.isnan(position):
            return np.nan
        return self.height_of(self._c * (profile.start_s + position / profile.rate_hz - start_s))

    def path_m(self, height_m: float, mic: int = 1) -> float:
        """Path via the ground to a microphone, while microphone 0 is that high."""
        behind_m = self._separation_m * mic
        aside_m = (self._ahead_m + behind_m) * self._cos_pitch
        return float(np.hypot(2.0 * height_m + (self._ahead_m - behind_m) * self._sin_pitch, aside_m))

    def height_of(self, path_m: float) -> float:
        """Height of microphone 0 while the path via the ground to microphone 1 is that long."""
        aside_m = (self._ahead_m + self._separation_m) * self._cos_pitch
        upright_m = float(np.sqrt(path_m**2 - aside_m**2))
        return 0.5 * (upright_m - (self._ahead_m - self._separation_m) * self._sin_pitch)


@compiled
def _louder_at_second(magnitude: Floats, first: int, last: int, later: int, least: float) -> float:
    """Position of the highest peak of the second channel that the first one, so many samples before, receives
    weaker."""
    best, position = least, np.nan
    for peak in local_maxima(magnitude[1, first : last + 1]) + first:
        before = magnitude[0, max(peak - later, 0)]
        if magnitude[1, peak] > max(best, before):
            best, position = magnitude[1, peak], refined_peak(magnitude[1], peak)[0]
    return position
