"""Path via the walker's body (paper section 3.5, Fig. 9)."""

from __future__ import annotations

import numpy as np

from obstaclewatch.signal.echoes import echoes_at, separated_peaks
from obstaclewatch.signal.matched_filter import EchoProfile


def nearest_body_path(
    profile: EchoProfile, start_s: float, path_m: tuple[float, float], sound_speed_m_s: float, least_amplitude: float
) -> float:
    """Path speaker - walker's body - microphone 1: the strongest peak after the direct sound (section 3.5, Fig. 9).

    Args:
        profile: compressed block.
        start_s: emission, on the profile's delay axis.
        path_m: (shortest, longest) path that can be the body.
        sound_speed_m_s: speed of sound.
        least_amplitude: lowest height that counts.

    Returns:
        The path, m; NaN if no peak lies there.
    """
    first, last = (profile.position(start_s + path / sound_speed_m_s) for path in path_m)
    peaks = separated_peaks(profile.magnitude[1, first : last + 1], least_amplitude, 1) + first
    if len(peaks) == 0:
        return np.nan
    strongest = peaks[np.argmax(profile.magnitude[1, peaks])]
    return sound_speed_m_s * float(echoes_at(profile, 1, np.array([strongest])).delay_s[0] - start_s)
