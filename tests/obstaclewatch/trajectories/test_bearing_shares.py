"""Probabilities of bearings against trajectories of known place, one at a time and all together."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.trajectories.bearing_shares import BINS, EDGES_RAD, KINDS, SHARES, bearing_shares, kinds_of
from obstaclewatch.trajectories.prior import hypotheses

ALL = hypotheses(0.3)
KIND = kinds_of(ALL)


def _shares(share, ahead_m):
    return bearing_shares(share, np.full(len(share), ahead_m, dtype=np.float32), ALL.miss_m, ALL.angle_rad, KIND)


def test_one_trajectory_lies_in_the_bin_of_its_kind_and_bearing():
    for which in np.random.default_rng(3).integers(0, len(KIND), 50):
        found = _shares(np.eye(len(KIND))[which], 2.0)
        at = int(np.argmax(found))
        expected = ALL.angle_rad[which] if ALL.is_wall[which] else np.arctan(ALL.miss_m[which] / 2.0)
        assert found[at] == 1.0
        assert EDGES_RAD[at % BINS] - 1e-9 <= expected <= EDGES_RAD[at % BINS + 1] + 1e-9
        kind = KINDS[at // BINS]
        assert (kind == "wall") == ALL.is_wall[which]
        if not ALL.is_wall[which]:
            height = {"as high as the phone": ALL.height_m[which] == 0.0, "between": 0.0 < ALL.height_m[which] < 1.0}
            assert height.get(kind, np.isinf(ALL.height_m[which]))


def test_all_probability_is_somewhere_and_things_swing_aside_as_they_come_near():
    share = np.random.default_rng(4).dirichlet(np.ones(len(KIND)))
    far, near = _shares(share, 4.0), _shares(share, 0.05)
    assert far.shape == (SHARES,)
    assert far.sum() == pytest.approx(1.0)
    assert near.sum() == pytest.approx(1.0)
    things, walls = slice(0, 3 * BINS), slice(3 * BINS, SHARES)
    assert (near[walls] == far[walls]).all()
    middle = np.tile(0.5 * (EDGES_RAD[1:] + EDGES_RAD[:-1]), 3)
    assert middle @ near[things] > middle @ far[things] + 0.3
