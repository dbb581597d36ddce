"""Two ranges to a walking angle: the path difference, freed of the walker's body (paper section 3.5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.support.compiled import compiled


@dataclass(frozen=True)
class PathDifference:
    """u = path 2 - path 1 of n candidates; both share the segment from the speaker, so u = D2 - D1.

    Attributes:
        u_m: (n,) NaN where microphone 1 received nothing that can be the candidate.
        amplitude: (n,) height of the peak at microphone 1, NaN likewise.
        body_deducted: (n,) the peak came via the walker's body, and the detour was deducted.
    """

    u_m: Floats
    amplitude: Floats
    body_deducted: Flags


def path_difference(
    path1_m: Floats,
    path2_m: Floats,
    amplitude2: Floats,
    separation_m: float,
    margin_m: float,
    body_distance_m: Callable[[], float],
    least_amplitude: Floats,
    cos_pitch: float = 1.0,
    gated: bool = True,
    whole_detour: bool = True,
) -> PathDifference:
    """Pair each candidate with the strongest peak of microphone 1 that can be the same obstacle.

    Args:
        path1_m: (n,) paths of the candidates to microphone 0.
        path2_m: (m,) paths of microphone 1's peaks.
        amplitude2: (m,) their heights.
        separation_m: L, between the microphones.
        margin_m: how far u may lie outside [-L, L].
        body_distance_m: from microphone 1 to the walker's body, asked for only where it can matter; NaN if it is not
            known: nothing is deducted.
        least_amplitude: (n,) height below which a peak cannot be the candidate: a sidelobe of something else.
        cos_pitch: cosine of the phone's pitch.
        gated: False takes the strongest peak up to the body's detour and always deducts (section 3.5 as printed).
        whole_detour: False deducts the distance to the body once (section 3.5 as printed).
    """
    reach = separation_m + margin_m
    own, own_height = _strongest(path1_m, path2_m, amplitude2, least_amplitude, -reach, reach)
    unpaired = np.isnan(own)
    distance_m = body_distance_m() if not gated or unpaired.any() else np.nan
    if np.isnan(distance_m):
        return PathDifference(own, own_height, np.zeros(len(own), dtype=bool))
    detour = 2.0 * distance_m
    late, late_height = _strongest(path1_m, path2_m, amplitude2, least_amplitude, -reach, reach + detour)
    deduct = ~np.isnan(late) & (unpaired | (not gated))
    shortened = deducted_difference(late, separation_m, distance_m, cos_pitch, whole_detour)
    u = np.where(deduct, shortened, own)
    return PathDifference(u, np.where(deduct, late_height, own_height), deduct & ~np.isnan(u))


def deducted_difference(
    gap_m: ArrayLike, separation_m: float, body_distance_m: float, cos_pitch: float = 1.0, whole_detour: bool = True
) -> Floats:
    """u of an echo that reached microphone 1 via the walker's body (D3 of Fig. 8).

    The body is a plane across the walking direction, a distance d behind the microphone. A plane wave from azimuth a
    then arrives 2 d cos a late, so that gap = (L cos(pitch) + 2 d) cos a, and u = L cos(pitch) cos a. As printed, d is
    deducted once, whatever the azimuth.
    """
    gap = np.asarray(gap_m, dtype=np.float64)
    if not whole_detour:
        return gap - body_distance_m
    along = separation_m * cos_pitch
    return gap * along / (along + 2.0 * body_distance_m)


def body_distance(excess_m: float, separation_m: float, cos_pitch: float = 1.0) -> float:
    """Distance from microphone 1 to the walker's body, from the excess of the body's echo over the direct path.

    With the speaker at the other end of the phone, L away and pitched, and the body a vertical plane:
    (L + excess)^2 = (L cos(pitch) + 2 d)^2 + (L sin(pitch))^2. For a level phone d = excess / 2.
    """
    sine2 = 1.0 - cos_pitch**2
    squared = (separation_m + excess_m) ** 2 - separation_m**2 * sine2
    return 0.5 * (float(np.sqrt(squared)) - separation_m * cos_pitch)


def walking_angle(cosine: Floats, cos_pitch: float = 1.0, clamped: bool = True) -> tuple[Floats, Flags]:
    """Bearing from the cone's cosine, and whether it had to be clamped.

    An obstacle at the phone's height lies at the azimuth cos a = cos(cone) / cos(pitch). The angle is unsigned: two
    microphones do not distinguish left from right.

    Args:
        cosine: (n,) from `cone_cosine`.
        cos_pitch: cosine of the phone's pitch; 1 if it is not known.
        clamped: False leaves NaN where arccos has no value, and the pitch unused (Eq. 2 as printed).
    """
    azimuth = cosine / cos_pitch if clamped else cosine
    outside = np.abs(azimuth) > 1.0
    inside = np.where(outside, np.sign(azimuth) if clamped else np.nan, azimuth)
    return np.arccos(inside), outside & clamped


def bearing_std(bearing_rad: Floats, u_std_m: Floats, separation_m: float, cos_pitch: float = 1.0) -> Floats:
    """Standard deviation of the bearing, to first order; near straight ahead, where that diverges, held finite.

    The cosine has s = u_std / (L cos(pitch)); the bearing s / sin(bearing), and about sqrt(s) straight ahead.
    """
    spread = u_std_m / (separation_m * cos_pitch)
    return spread / np.sqrt(np.sin(bearing_rad) ** 2 + spread)


@compiled
def _strongest(
    path1_m: Floats, path2_m: Floats, amplitude2: Floats, least_amplitude: Floats, nearest_m: float, farthest_m: float
) -> tuple[Floats, Floats]:
    """Path 2 - path 1 and height of each candidate's strongest peak between two differences, NaN where none is."""
    gap_m, height = np.empty(len(path1_m)), np.empty(len(path1_m))
    for row in range(len(path1_m)):
        gap_m[row] = height[row] = np.nan
        for peak in range(len(path2_m)):
            gap, louder = path2_m[peak] - path1_m[row], not amplitude2[peak] <= height[row]
            if nearest_m <= gap <= farthest_m and amplitude2[peak] >= least_amplitude[row] and louder:
                gap_m[row], height[row] = gap, amplitude2[peak]
    return gap_m, height
