"""Path difference between the microphones from the carriers: tenfold finer than the envelopes, up to whole cycles.

At 20.5 kHz a cycle is 16.7 mm of path. The cycle is not chosen here: the track weighs the phase of every beep against
each course (see `courses`), and wrong cycles fall out because they would have to follow another course.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.matched_filter import EchoProfile

Array = NDArray[np.float64]


def carrier_difference(profile: EchoProfile, delay_s: Array, u_m: Array, sound_speed_m_s: float) -> Array:
    """(n,) path difference modulo the wavelength c / reference_hz, in [-1/2, 1/2) of it.

    The envelope of an echo at delay d carries the phase -2 pi reference_hz d at its peak.

    Args:
        profile: two channels.
        delay_s: (n,) peaks of microphone 0.
        u_m: (n,) path difference from the envelopes: where microphone 1 peaks; NaN is passed on.
        sound_speed_m_s: speed of sound.
    """
    first = complex_at(profile, 0, delay_s)
    second = complex_at(profile, 1, delay_s + np.where(np.isnan(u_m), 0.0, u_m) / sound_speed_m_s)
    cycles = -np.angle(second * first.conj()) / (2.0 * np.pi)
    return np.where(np.isnan(u_m), np.nan, cycles * sound_speed_m_s / profile.reference_hz)


def complex_at(profile: EchoProfile, channel: int, delay_s: Array) -> NDArray[np.complex128]:
    """(n,) envelope of a channel at any delays within the profile, linear between samples."""
    position = (delay_s - profile.start_s) * profile.rate_hz
    low = np.minimum(np.maximum(np.floor(position).astype(np.intp), 0), profile.envelope.shape[1] - 2)
    rest = position - low
    return (1.0 - rest) * profile.envelope[channel, low] + rest * profile.envelope[channel, low + 1]
