"""What a track says of its bearing, in a few numbers: what `bearing_model` looks at.

Nothing of it depends on how loud a phone is, or on where its microphones are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.tracking.range_fit import TrackRange
from obstaclewatch.trajectories.bearing_shares import SHARES
from obstaclewatch.trajectories.posterior_grid import Expectation

LEAST_SHARE = 1e-5
"""Below which one bearing is as improbable as another."""


class TrackNumbers(NamedTuple):
    """One track's after one beep.

    Attributes:
        collision, left_m, speed_m_s, bearing_rad, bearing_std_rad, cosine, miss_m: see `Expectation`.
        range_m, closing_m_s, range_std_m: see `TrackRange`.
        peaks: how many were judged.
    """

    collision: float
    left_m: float
    speed_m_s: float
    bearing_rad: float
    bearing_std_rad: float
    cosine: float
    miss_m: float
    range_m: float
    closing_m_s: float
    range_std_m: float
    peaks: float


NUMBERS = len(TrackNumbers._fields) + SHARES


def bearing_evidence(trajectory: Expectation, found: TrackRange, peaks: int, shares: Floats) -> Floats:
    """(NUMBERS,) of a track: its `TrackNumbers`, and logarithms of how probable each bearing is.

    Args:
        trajectory: what is to be expected of it.
        found: where it is.
        peaks: how many were judged.
        shares: (SHARES,) see `bearing_shares`.
    """
    expected = (getattr(trajectory, name) for name in TrackNumbers._fields if name in Expectation._fields)
    numbers = TrackNumbers._make((*expected, *found, peaks))
    return np.concatenate([numbers, np.log(np.maximum(shares, LEAST_SHARE))])
