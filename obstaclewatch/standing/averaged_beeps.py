"""What a phone held still hears ahead of it: beeps averaged, and what comes from behind and below explained away.

While standing nothing moves, so that what moves along with the walker cannot be told from obstacles by motion. The
direction of arrival tells: averaged beeps give the cosine of the cone about the phone's long axis to 0.05, and the
ground below a phone lifted by 30 degrees arrives at -0.5, the walker's body at -1, the foot of a wall alongside at
-0.3, a thing ahead at 0.4 to 0.9.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obstaclewatch.detection import Detection
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.signal.two_mics import cone_cosine

HELD_BEEPS = 16
"""In the running mean: 12 dB over one beep after as many, 15 dB at most."""
CANDIDATES = 20
"""Measured before the direction is asked; of 96 rendered places none had more than 9."""
GATE_MARGIN_M = 0.015
"""How far a path difference may pass the phone's length: three deviations of what overlap leaves, 3.5 mm, and of noise
at 30 dB."""
OTHER_STD_M = 0.003
"""Deviation of a range by what is not noise: echoes that overlap, and the speed of sound."""
BEHIND = 0.1
"""How far below zero a cosine must lie to be from behind for certain, beside its noise."""
DIFFERENCE_TO_RANGE = 3.0
"""Deviation of the path difference over that of the range by noise: two whole paths against half of one."""


def standing_settings(settings: PaperSettings, mic_phase_rad: float | None) -> PaperSettings:
    """The settings with beeps averaged, more candidates measured, the carrier used if its phase is known."""
    return replace(
        settings,
        held_beeps=HELD_BEEPS,
        max_candidates=CANDIDATES,
        mic_phase_rad=mic_phase_rad,
        gate_margin_m=min(settings.gate_margin_m, GATE_MARGIN_M),
    )


def ahead_alone(found: Detection, separation_m: float, most: int) -> Detection:
    """The nearest candidates that do not arrive from behind the phone; their deviations count more than noise.

    Their radii are not told: by the width of crests they are 63 cm off in the median.

    Args:
        found: candidates, nearest first; those without a path difference stay.
        separation_m: between the microphones.
        most: how many are kept.
    """
    cosine = cone_cosine(found.range_m, found.range2_m, separation_m)
    noise = 2.0 * DIFFERENCE_TO_RANGE * found.range_std_m / separation_m
    kept = np.flatnonzero(~(cosine < -(BEHIND + noise)))[:most]
    return replace(
        found,
        range_m=found.range_m[kept],
        range2_m=found.range2_m[kept],
        bearing_rad=found.bearing_rad[kept],
        radius_m=np.full(len(kept), np.nan),
        level_db=found.level_db[kept],
        snr_db=found.snr_db[kept],
        closing_speed_m_s=found.closing_speed_m_s[kept],
        range_std_m=np.hypot(found.range_std_m[kept], OTHER_STD_M),
        bearing_std_rad=found.bearing_std_rad[kept],
        radius_std_m=found.radius_std_m[kept],
        collides=found.collides[kept],
        flags=found.flags[kept],
    )
