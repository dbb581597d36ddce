"""Crest width to radius (paper Eq. 3)."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.paper.size import size_from_crest
from tests.obstaclewatch.synthetic import C

NO = np.zeros(1, dtype=bool)


def test_twenty_centimetres_at_three_metres_are_7_5_samples():
    extra = 7.46 / 192_000.0 * C / 2.0
    size = size_from_crest(np.array([3.0]), np.array([extra]), NO)
    assert size.radius_m[0] == pytest.approx(0.2, rel=1e-3)
    assert np.cos(size.collision_angle_rad[0]) == pytest.approx(3.0 / (3.0 + extra))


def test_limits():
    """No excess, or less than none, is no radius; unknown stays unknown."""
    size = size_from_crest(np.full(3, 2.0), np.array([0.0, -0.01, np.nan]), np.zeros(3, bool))
    assert size.radius_m[:2].tolist() == [0.0, 0.0]
    assert np.isnan(size.radius_m[2])


def test_printed_angle_has_no_value():
    """Erratum `rim_angle`: Df / D1 > 1."""
    size = size_from_crest(np.array([3.0]), np.array([0.01]), NO, rim_angle=False)
    assert np.isnan(size.collision_angle_rad[0])
