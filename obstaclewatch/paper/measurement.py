"""What one beep says, before any decision: handed from the pipeline to the detectors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.detection import Flag
from obstaclewatch.support.arrays import Flags, Floats


@dataclass(frozen=True)
class Measurement:
    """What one beep says about n candidates, nearest first. Fields as in `Detection`.

    Attributes:
        start_s: emission, relative to the block's first sample.
        collision_angle_rad: (n,) delta of section 3.6.
        may_vote: (n,) comes nearer, as section 3.6 demands of what can be collided with.
    """

    start_s: float
    range_m: Floats
    range2_m: Floats
    bearing_rad: Floats
    collision_angle_rad: Floats
    radius_m: Floats
    level_db: Floats
    snr_db: Floats
    closing_speed_m_s: Floats
    range_std_m: Floats
    bearing_std_rad: Floats
    may_vote: Flags
    flags: NDArray[np.int_]
    beep_flags: Flag


def nothing_measured(flag: Flag, start_s: float = 0.0) -> Measurement:
    """A beep without candidates."""
    none, no = np.empty(0), np.empty(0, dtype=bool)
    return Measurement(start_s, none, none, none, none, none, none, none, none, none, none, no, np.empty(0, int), flag)
