"""The direct sound: when the beep was emitted, by both channels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.beep import BeepDesign
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.signal.direct_delay import DIRECT_SEARCH_S, check_direct_delay
from obstaclewatch.signal.echoes import refined_peak
from obstaclewatch.signal.matched_filter import EchoProfile, MatchedFilter, nearest_sample
from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled


class DirectSound(NamedTuple):
    """The direct peaks of one beep.

    Attributes:
        delay_s: (2,) on the profile's delay axis.
        amplitude: (2,) heights of the peaks.
        found: the strongest peak of microphone 0's profile is the direct one; False says there is no beep here.
    """

    delay_s: Floats
    amplitude: Floats
    found: bool


def direct_sound(profile: EchoProfile) -> DirectSound:
    """The strongest peak of each channel near the block's start ("the first strongest peak", section 3.4)."""
    return DirectSound(*_direct_peaks(profile.magnitude, profile.start_s, profile.rate_hz))


def expected_direct_delay_s(phone: PhoneGeometry, sound_speed_m_s: float, calibrated_s: float | None) -> float:
    """Delay of microphone 0's direct peak after emission: as calibrated, or None for that of the air path.

    Raises:
        ValueError: it is not within `DIRECT_SEARCH_S` of the emission: no beep of a recording would ever be found.
    """
    delay_s = float(phone.speaker_to_mic_m[0]) / sound_speed_m_s if calibrated_s is None else calibrated_s
    check_direct_delay(delay_s)
    return delay_s


@compiled
def _direct_peaks(magnitude: Floats, start_s: float, rate_hz: float) -> tuple[Floats, Floats, bool]:
    """`DirectSound` of a profile's (2, M) magnitude."""
    delay_s, height, found, count = np.empty(2), np.empty(2), True, magnitude.shape[1]
    first = nearest_sample(-DIRECT_SEARCH_S, start_s, rate_hz, count)
    last = nearest_sample(DIRECT_SEARCH_S, start_s, rate_hz, count) + 1
    for mic in range(2):
        peak = first + int(np.argmax(magnitude[mic, first:last]))
        position, height[mic] = refined_peak(magnitude[mic], peak)
        delay_s[mic] = start_s + position / rate_hz
        if mic == 0:
            strongest = magnitude[0, np.argmax(magnitude[0])]
            found = first < peak < last - 1 and bool(strongest > 0.0 and magnitude[0, peak] == strongest)
    return delay_s, height, found


def measured_direct_delay_s(block: NDArray[np.floating], beep: BeepDesign) -> float:
    """Delay of microphone 0's direct peak in a block that starts exactly at an emission: the calibration of d_s.

    Args:
        block: (2, period_samples) one beep period, first sample at the emission.
        beep: the emitted signal.

    Raises:
        ValueError: the block has another shape, or no direct peak near its start.
    """
    direct = direct_sound(MatchedFilter(beep, beep.gap_s or beep.period_s).compress(block))
    if not direct.found:
        raise ValueError(f"the direct sound must be the strongest peak within {DIRECT_SEARCH_S * 1e3} ms of the start")
    return float(direct.delay_s[0])
