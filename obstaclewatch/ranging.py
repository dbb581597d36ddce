"""Time of flight to range: one start for both channels, and the triangle of speaker, obstacle and microphone.

Ranges are those of the beep's centre as the chirp reads them. A closing obstacle's delay shrinks while the frequency
rises, and the matched filter reads the range center_hz / chirp_rate ahead: 0.205 s, or 20-33 cm short at 1.0-1.6 m/s.
The paper's method has that bias and `PaperDetector` keeps it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from obstaclewatch.bearing import law_of_cosines
from obstaclewatch.beep import BeepDesign
from obstaclewatch.echoes import echoes_at, refined_peak, separated_peaks
from obstaclewatch.matched_filter import EchoProfile, MatchedFilter, nearest_sample
from obstaclewatch.support.arrays import Floats

DIRECT_SEARCH_S = 1.2e-3
"""How far from the block's start the direct peak may lie: the air path along a 16 cm phone takes 0.47 ms."""


class DirectSound(NamedTuple):
    """The direct peaks of one beep.

    Attributes:
        delay_s: (2,) on the profile's delay axis.
        amplitude: (2,) heights of the peaks.
        found: the strongest peak of microphone 0's whole profile is the direct one; False says there is no beep here.
    """

    delay_s: Floats
    amplitude: Floats
    found: bool


def direct_sound(profile: EchoProfile) -> DirectSound:
    """The strongest peak of each channel near the block's start ("the first strongest peak", section 3.4)."""
    return DirectSound(*_direct_peaks(profile.magnitude, profile.start_s, profile.rate_hz))


def checked_direct_delay_s(delay_s: float) -> float:
    """Delay of microphone 0's direct peak after emission, if `direct_sound` can find it in a block that starts then.

    Raises:
        ValueError: it is not within `DIRECT_SEARCH_S`: no beep of a recording would ever be heard.
    """
    if not abs(delay_s) < DIRECT_SEARCH_S:
        raise ValueError(
            f"the direct sound must reach microphone 0 within {DIRECT_SEARCH_S * 1e3:g} ms of its emission, got "
            f"direct_delay_s = {delay_s:g}"
        )
    return delay_s


@numba.njit(cache=True)
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
            strongest = magnitude[0].max()
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


def one_way_range(path_m: ArrayLike, baseline_m: float, cosine: ArrayLike = 1.0) -> Floats:
    """Distance from a microphone to a point, from the whole path speaker - point - microphone.

    path = D + sqrt(D^2 + b^2 - 2 D b cos a), hence D = (path^2 - b^2) / (2 (path - b cos a)); for b = 0 path / 2.

    Args:
        path_m: whole path.
        baseline_m: b, distance from microphone to speaker.
        cosine: cos a, of the angle at the microphone between the speaker and the point.

    Returns:
        Distances, NaN where the path is not longer than the baseline.
    """
    path = np.asarray(path_m, dtype=np.float64)
    path = np.where(path > baseline_m, path, np.nan)
    return np.asarray(distance_of.py_func(path, baseline_m, np.asarray(cosine, dtype=np.float64)))


@numba.njit(cache=True, error_model="numpy")
def distance_of(path_m: Any, baseline_m: float, cosine: Any) -> Any:
    """`one_way_range` of paths that are longer than the baseline; compiled loops hand it floats."""
    return (path_m**2 - baseline_m**2) / (2.0 * (path_m - baseline_m * cosine))


@numba.njit(cache=True)
def ranges_of_pairs(
    path1_m: Floats,
    u_m: Floats,
    separation_m: float,
    baseline_m: float,
    speaker_cosine: float,
) -> Floats:
    """(n,) distances from microphone 0 by both microphones' paths, with the speaker somewhere between them.

    The triangle needs the bearing and the bearing the range: the second round moves it by less than 0.1 mm.

    Args:
        path1_m: (n,) whole paths to microphone 0.
        u_m: (n,) path 2 - path 1; where it is NaN, echoes count as from straight ahead.
        separation_m: between the microphones.
        baseline_m: from microphone 0 to the speaker.
        speaker_cosine: of the angle at microphone 0 between the speaker and the line on from microphone 1.
    """
    range_m = np.empty(len(path1_m))
    for row, path in enumerate(path1_m):
        distance = 0.5 * path
        for _ in range(2):
            toward = law_of_cosines(distance, distance + u_m[row], separation_m)
            toward = 1.0 if np.isnan(toward) else min(max(toward, -1.0), 1.0)
            distance = distance_of(path, baseline_m, speaker_cosine * toward) if path > baseline_m else np.nan
        range_m[row] = distance
    return range_m


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
