"""Radii from the kind of echo: against sampling, and what follows from the table's own meaning."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch import TrackingDetector
from obstaclewatch.trajectories.prior import hypotheses
from obstaclewatch.trajectories.width_prior import (
    EDGES_M,
    NARROW,
    OF_BETWEEN,
    OF_CORNER,
    OF_LEVEL,
    OF_WALL,
    narrow_radius,
    radius_shares,
)
from tests.obstaclewatch.synthetic import BEEP, PHONE, Point, recording

COURSES = hypotheses(0.25)
RADII = radius_shares(COURSES)
LEVEL = ~COURSES.is_wall & (COURSES.height_m == 0.0)
CORNER = np.isinf(COURSES.height_m)
BETWEEN = ~COURSES.is_wall & (COURSES.height_m > 0.0) & ~CORNER
WALL = COURSES.is_wall & (COURSES.height_m == 0.0) & (COURSES.tilt_rad == 0.0)
LEANING = COURSES.tilt_rad > 0.0


def _shared(which, probability=1.0):
    """(H,) a probability, evenly over some trajectories."""
    return probability * which / which.sum()


def test_every_kind_of_echo_has_its_distribution():
    for which, table in ((LEVEL, OF_LEVEL), (CORNER, OF_CORNER), (BETWEEN | LEANING, OF_BETWEEN), (WALL, OF_WALL)):
        assert which.any()
        assert RADII[which] == pytest.approx(np.tile(table / table.sum(), (which.sum(), 1)))
    assert np.all(LEVEL | CORNER | BETWEEN | WALL | LEANING)
    assert RADII.sum(axis=1) == pytest.approx(np.ones(len(RADII)))


@pytest.mark.parametrize(("corner", "level"), [(1.0, 0.0), (0.0, 1.0), (0.6, 0.3)])
def test_median_and_deviation_are_those_of_a_sampled_posterior(corner, level):
    """A million radii drawn class by class. Their median's own deviation is below 0.2 mm."""
    share = _shared(CORNER, corner) + _shared(LEVEL, level) + _shared(WALL, 1.0 - corner - level)
    rng = np.random.default_rng(7)
    drawn = rng.choice(len(EDGES_M) - 1, 1_000_000, p=share @ RADII)
    radius = rng.uniform(EDGES_M[drawn], EDGES_M[drawn + 1])
    radius_m, std_m = narrow_radius(share, RADII)
    assert radius_m == pytest.approx(np.median(radius[radius < EDGES_M[NARROW]]), abs=1e-3)
    assert np.mean(np.abs(radius - radius_m) <= std_m) == pytest.approx(0.6827, abs=2e-3)


def test_no_radius_is_told_of_what_is_thought_broad():
    for which in (WALL, BETWEEN, LEANING):
        assert np.isnan(narrow_radius(_shared(which), RADII)).all()


def test_surer_of_a_narrow_thing_is_a_smaller_deviation():
    found = np.array([narrow_radius(_shared(CORNER, p) + _shared(WALL, 1.0 - p), RADII) for p in (0.4, 0.7, 1.0)])
    assert np.isfinite(found).all()
    assert np.all(np.diff(found[:, 1]) < 0.0)
    assert np.all((found[:, 0] > 0.26) & (found[:, 0] < 0.31))


def test_a_detection_carries_radius_and_deviation_together():
    """A point as high as the phone: narrow or not, but never one number without the other."""
    ground = Point(1.3, gain=0.3, carried=True, bob_m=0.02)
    received = recording([ground, Point(5.0, gain=0.1)], beeps=34, noise=0.02, speed_m_s=1.3)
    found = [d for d in TrackingDetector(BEEP, PHONE).stream(received) if len(d)]
    radius, std = (np.concatenate([getattr(d, name) for d in found]) for name in ("radius_m", "radius_std_m"))
    assert np.isfinite(radius).any()
    assert np.array_equal(np.isnan(radius), np.isnan(std))
    assert np.all(std[np.isfinite(std)] > 0.1)
