"""Which of the paper's formulas to correct: one named switch each, so that the price of an erratum can be measured."""

from __future__ import annotations

from dataclasses import dataclass

from obstaclewatch.support.argument_types import check_types


@dataclass(frozen=True)
class Errata:
    """One switch per erratum; True (the default) is the corrected form, False the paper's.

    Attributes:
        correlate_once: Eq. 1 conjugates and time-reverses the beep inside a correlation, which compresses nothing.
            Corrected: correlate with the beep itself.
        one_way_range: section 3.4, D1 = m v / f is the two-way path.
            Corrected: D1 solves the triangle of speaker, obstacle and microphone.
        speaker_leg: section 3.5, "use similar way" for D2; halving path 2 halves the difference D2 - D1.
            Corrected: D2 is path 2 less the segment from speaker to obstacle, so D2 - D1 = path 2 - path 1.
            Without `one_way_range` nothing is halved and this switch has no effect.
        shared_start: section 3.4, each channel's direct peak is taken as the time of sending.
            Corrected: one start for both channels, the direct peak of microphone 0 less its calibrated delay.
        given_sound_speed: sections 3.3 and 3.4 use both 340 and 343 m/s. Printed: 340. Corrected: as given.
        clamped_angle: Eq. 2 leaves the domain of arccos and ignores the pitch.
            Corrected: clamped and flagged, and divided by cos(pitch) where a pitch is given.
        pulse_width_removed: Eq. 3 takes the full crest above an absolute threshold, and does not halve the two-way
            length. Corrected: the trailing width at a peak-relative level in excess of the beep's own, halved.
        rim_angle: below Eq. 3, delta = arccos(Df / D1) has no value, because Df > D1; as printed, every angle and
            radius is NaN and nothing ever collides. Corrected: arccos(D1 / Df).
        whole_detour: section 3.5 deducts the distance from microphone 1 to the body. Printed: that distance, half of
            what the peaks are apart, though with D1 = m v / f, unhalved, its count of samples gives the detour itself.
            Corrected: twice that distance, as it appears from the obstacle's direction.
        gated_second_mic: section 3.5 takes the strongest peak of microphone 1, and always deducts the body.
            Corrected: only peaks within +-L of path 1 can be the obstacle; the body is deducted if there is none.
        walker_width: Eq. 4 lets a point walk. Corrected: D1 sin(bearing) <= radius + half the walker's width.
        separated_peaks: section 3.4 picks peaks in fixed windows of 0.5 ms, which splits one at a window's edge in
            two. Corrected: local maxima with a minimum separation.
        local_threshold: section 3.4's average x lambda follows the strongest clutter, wherever it stands.
            Corrected: a multiple of a local order statistic (OS-CFAR), which follows the floor over range.

    >>> Errata(clamped_angle=False).clamped_angle
    False
    >>> any(vars(Errata.as_printed()).values())
    False
    """

    correlate_once: bool = True
    one_way_range: bool = True
    speaker_leg: bool = True
    shared_start: bool = True
    given_sound_speed: bool = True
    clamped_angle: bool = True
    pulse_width_removed: bool = True
    rim_angle: bool = True
    whole_detour: bool = True
    gated_second_mic: bool = True
    walker_width: bool = True
    separated_peaks: bool = True
    local_threshold: bool = True

    def __post_init__(self) -> None:
        check_types(**{name: (value, bool) for name, value in vars(self).items()})

    @classmethod
    def as_printed(cls) -> Errata:
        """Every formula as it stands in the paper."""
        return cls(**dict.fromkeys(cls.__dataclass_fields__, False))
