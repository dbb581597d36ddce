"""How probable bearings are by the posterior over trajectories, apart for each kind of thing that reflects."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints, Singles
from obstaclewatch.trajectories.prior import Hypotheses

EDGES_RAD = np.deg2rad([0.0, 2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 17.5, 20.0, 25.0, 30.0, 35.0, 40.0, 50.0, 60.0, 90.0])
"""Of the bins of bearings."""
BINS = len(EDGES_RAD) - 1
KINDS = "as high as the phone", "corner with the ground", "between", "wall"
SHARES = len(KINDS) * BINS


def kinds_of(trajectories: Hypotheses) -> Ints:
    """(H,) which of the `KINDS` each trajectory leads to."""
    of_things = np.where(trajectories.height_m == 0.0, 0, np.where(np.isinf(trajectories.height_m), 1, 2))
    return np.where(trajectories.is_wall, 3, of_things)


def bearing_shares(share: Floats, ahead_m: Singles, miss_m: Floats, angle_rad: Floats, kind: Ints) -> Floats:
    """(SHARES,) probabilities of the reflecting point's bearing, kind by kind.

    Args:
        share: (H,) of the trajectories.
        ahead_m: (H,) distances ahead, positive.
        miss_m, angle_rad: (H,) miss distances, 0 for walls, and angles of walls, 0 for other things.
        kind: (H,) see `kinds_of`.
    """
    within = np.digitize(angle_rad + np.arctan2(miss_m, ahead_m), EDGES_RAD[1:-1])
    found = np.zeros(SHARES)
    np.add.at(found, BINS * kind + within, share)
    return found
