"""Crest width to collision angle and radius (paper section 3.6, Eq. 3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.signal.echoes import Echoes
from obstaclewatch.signal.matched_filter import EchoProfile
from obstaclewatch.signal.pulse import REACH_S, PulseShape, trailing_widths
from obstaclewatch.support.arrays import Flags, Floats


@dataclass(frozen=True)
class Size:
    """What the crests of n echoes say about their obstacles.

    Attributes:
        collision_angle_rad: (n,) delta of section 3.6, between the nearest point and the rim.
        radius_m: (n,) distance of the rim from the line to the nearest point.
        merged: (n,) the crest runs into the next one; angle and radius are NaN.
    """

    collision_angle_rad: Floats
    radius_m: Floats
    merged: Flags


def size_from_crest(range_m: Floats, extra_m: Floats, merged: Flags, rim_angle: bool = True) -> Size:
    """Collision angle and radius from how much farther the rim lies than the nearest point.

    Fig. 13: the obstacle is round as seen from the phone, its rim a radius off the line to its nearest point and Df
    away, so cos(delta) = D1 / Df and radius = D1 tan(delta) = sqrt(Df^2 - D1^2). A radius of 20 cm at 3 m makes the
    rim 6.7 mm farther, 7.5 samples of delay at 192 kHz. A smooth round body echoes from its nearest point alone and
    widens nothing: it reads as a radius of zero, give or take the noise.

    Args:
        range_m: (n,) D1.
        extra_m: (n,) Df - D1; negative values, which only noise makes, count as 0.
        merged: (n,) passed on.
        rim_angle: False takes arccos(Df / D1) as printed, which has no value unless Df = D1.
    """
    rim_m = range_m + np.maximum(extra_m, 0.0)
    ratio = range_m / rim_m if rim_angle else rim_m / range_m
    angle = np.arccos(np.where(ratio <= 1.0, ratio, np.nan))
    return Size(angle, range_m * np.tan(angle), merged)


def size_from_radius(range_m: Floats, radius_m: Floats) -> Size:
    """Collision angle of crests whose radius is read off a calibration, as in Fig. 11."""
    return Size(np.arctan2(radius_m, range_m), radius_m, np.zeros(len(range_m), dtype=bool))


def rim_excess(
    profile: EchoProfile, echoes: Echoes, pulse: PulseShape, closing_speed_m_s: Floats, sound_speed_m_s: float
) -> tuple[Floats, Flags]:
    """Df - D1 from the trailing width beyond the beep's own (Eq. 3, corrected): c dW / 2.

    Args:
        profile: compressed block; the crests are those of microphone 0.
        echoes: (n,) its peaks.
        pulse: calibrated widths of the beep.
        closing_speed_m_s: (n,) speeds, which stretch the pulse; NaN counts as standing.
        sound_speed_m_s: speed of sound.

    Returns:
        (n,) excess, m, NaN where the crest does not fall to the pulse's level; (n,) whether it runs into the next one.
    """
    position = (echoes.delay_s - profile.start_s) * profile.rate_hz
    crest, height = profile.magnitude[0], echoes.amplitude
    width, merged = trailing_widths(crest, position, height, profile.rate_hz, pulse.level, REACH_S)
    own = pulse.trailing_width_s(np.where(np.isnan(closing_speed_m_s), 0.0, closing_speed_m_s))
    return 0.5 * sound_speed_m_s * (width - own), merged


def printed_rim_excess(profile: EchoProfile, echoes: Echoes, threshold: float, sound_speed_m_s: float) -> Floats:
    """(n,) Df - D1 of Eq. 3 as printed: half the crest above an absolute threshold, times the speed of sound."""
    above = profile.magnitude[0] > threshold
    ends = np.flatnonzero(np.diff(above, prepend=False, append=False))
    place = np.searchsorted(ends, echoes.sample, side="right")
    inside = (place % 2 == 1) & (place < len(ends))
    right = ends[np.minimum(place, len(ends) - 1)] if len(ends) else np.zeros(len(echoes))
    left = ends[np.maximum(place - 1, 0)] if len(ends) else np.zeros(len(echoes))
    return np.where(inside, 0.5 * (right - left) / profile.rate_hz * sound_speed_m_s, np.nan)
