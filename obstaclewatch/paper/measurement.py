"""What one beep says, before any decision: handed from the pipeline to the detectors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.detection import COLUMNS, Candidates, Decision, Detection, Flag
from obstaclewatch.support.arrays import Flags, Floats


@dataclass(frozen=True, kw_only=True)
class Measurement(Candidates):
    """What one beep says about n candidates, nearest first.

    Attributes:
        start_s: emission, relative to the block's first sample.
        collision_angle_rad: (n,) delta of section 3.6.
        may_vote: (n,) comes nearer, as section 3.6 demands of what can be collided with.
        flags, beep_flags: as in `Detection`.
    """

    start_s: float
    collision_angle_rad: Floats
    may_vote: Flags
    flags: NDArray[np.int_]
    beep_flags: Flag

    def detection(self, index: int, time_s: float, collides: Flags, decision: Decision) -> Detection:
        """What is handed out of it, once it is decided."""
        return Detection(
            **self.columns(),
            index=index,
            time_s=time_s,
            collides=collides,
            flags=self.flags,
            beep_flags=self.beep_flags,
            decision=decision,
        )


def nothing_measured(flag: Flag, start_s: float = 0.0) -> Measurement:
    """A beep without candidates."""
    none = np.empty(0)
    return Measurement(
        **dict.fromkeys(COLUMNS, none),
        start_s=start_s,
        collision_angle_rad=none,
        may_vote=np.empty(0, dtype=bool),
        flags=np.empty(0, dtype=int),
        beep_flags=flag,
    )
