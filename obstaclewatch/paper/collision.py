"""From angle and size to an alert: Eq. 4, the vote of five in nine, and the dangerous distance (paper section 3.6)."""

from __future__ import annotations

from collections import deque

import numpy as np

from obstaclewatch.detection import Decision
from obstaclewatch.support.arrays import Flags, Floats


class CollisionVote:
    """Counts the collision votes of the last beeps.

    Args:
        needed: votes for an alert.
        of: beeps that are remembered.
    """

    def __init__(self, needed: int, of: int) -> None:
        self.needed = needed
        self._votes: deque[bool] = deque(maxlen=of)

    def cast(self, collides: bool) -> int:
        """Add a beep's vote; returns how many of the remembered ones are for a collision."""
        self._votes.append(collides)
        return sum(self._votes)

    def clear(self) -> None:
        """Forget all votes."""
        self._votes.clear()


def on_collision_course(range_m: Floats, bearing_rad: Floats, radius_m: Floats, half_width_m: float) -> Flags:
    """(n,) whether the walker would meet the obstacle (Eq. 4, corrected): D1 sin(bearing) <= radius + half width.

    An unknown radius (NaN) counts as 0, an unknown bearing as no collision. What lies behind cannot be met.
    """
    miss_m = range_m * np.sin(bearing_rad)
    return (miss_m <= np.where(np.isnan(radius_m), 0.0, radius_m) + half_width_m) & (bearing_rad < np.pi / 2)


def on_collision_course_printed(bearing_rad: Floats, collision_angle_rad: Floats) -> Flags:
    """(n,) Eq. 4 as printed: bearing <= delta; NaN is no collision."""
    return bearing_rad <= collision_angle_rad


def decide(
    vote: CollisionVote, time_s: float, range_m: Floats, closing_speed_m_s: Floats, collides: Flags, danger_m: float
) -> Decision:
    """Cast this beep's vote and decide; the n candidates come nearest first."""
    votes = vote.cast(bool(collides.any()))
    if not collides.any():
        return Decision(False, time_s, np.nan, np.nan, votes)
    nearest = int(np.flatnonzero(collides)[np.argmin(range_m[collides])])
    distance = float(range_m[nearest])
    alert = votes >= vote.needed and distance <= danger_m
    return Decision(alert, time_s, distance, distance / float(closing_speed_m_s[nearest]), votes)
