"""What a beep's evidence takes from tracks and from sums."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.tracking.approach_picture import Carrier
from obstaclewatch.tracking.approach_sums import ApproachSums
from obstaclewatch.tracking.evidence import (
    FRONT_M,
    MOST_LOGIT,
    NEW_SHARE,
    NO_EVIDENCE,
    NOISE_HIT,
    OF_TRACKS,
    USUAL_LOGIT,
    evidence_of,
)
from obstaclewatch.tracking.tracks import Track
from obstaclewatch.trajectories.posterior_grid import Expectation

SUMS = ApproachSums(20.0, 5.0, 3.0, 4.0, 0.9)
CARRIER = Carrier(1.2, 1.3, 0.14, 0.5, 11.0)


def _track(collision, left_m=1.0, peaks=8, slope_db=-30.0):
    track = Track(1.0, 1.3, np.eye(2), 0.9, 12.0)
    track.trajectory = Expectation(collision, left_m, 1.3, 0.1, 0.1, 0.9, 0.1, 0.0, 0.9)
    for k in range(peaks):
        range_m = 2.5 * 0.9**k
        track.past.append((0.09 * k, range_m, 0.01))
        track.levels_db.append(-50.0 + slope_db * np.log10(range_m))
    return track


def test_without_a_track_the_sums_speak():
    found = evidence_of([], SUMS, CARRIER, NO_EVIDENCE)
    assert np.isnan(found[:OF_TRACKS]).all()
    assert found[-5:] == CARRIER
    assert (found.hit, found.hit_over_passing, found.oncoming_over_passing) == (20.0, 15.0, -1.0)
    assert found.distance_left_m == pytest.approx(0.9 - FRONT_M)
    assert found.mean_log_odds == pytest.approx(NEW_SHARE * USUAL_LOGIT)
    assert found.mean_over_passing == pytest.approx(NEW_SHARE * 15.0)
    assert (
        evidence_of([Track(1.0, 1.3, np.eye(2), 0.9, 12.0)], SUMS, CARRIER, NO_EVIDENCE)[4:9] == found[4:9]
    )  # never judged


def test_beside_a_far_track_that_passes_the_sums_say_what_is_left():
    """Cause: a track of something else, 4 m away, kept the detector from an alert at what was met within a second."""
    found = evidence_of([_track(0.3, left_m=4.0)], SUMS, CARRIER, NO_EVIDENCE)
    assert found.left_m == 4.0
    assert found.distance_left_m == pytest.approx(0.9 - FRONT_M)
    assert evidence_of([_track(0.7, left_m=4.0)], SUMS, CARRIER, NO_EVIDENCE).distance_left_m == 4.0


def test_sums_that_noise_reaches_as_well_do_not_say_what_is_left():
    faint = evidence_of([], SUMS._replace(hit=NOISE_HIT), CARRIER, NO_EVIDENCE)
    assert faint.distance_left_m == NO_EVIDENCE.distance_left_m > SUMS.ahead_m
    assert faint._replace(hit=NOISE_HIT + 0.1).distance_left_m == pytest.approx(SUMS.ahead_m - FRONT_M)
    assert evidence_of([_track(0.7)], SUMS._replace(hit=0.0), CARRIER, NO_EVIDENCE).distance_left_m == 1.0


def test_the_likeliest_track_that_is_near_and_long_counts():
    likely, far, short = _track(0.7), _track(0.9, left_m=2.5), _track(0.9, peaks=4)
    found = evidence_of([far, likely, short], SUMS, CARRIER, NO_EVIDENCE)
    assert found.log_odds == pytest.approx(np.log(0.7 / 0.3))
    assert found.left_m == found.distance_left_m == 1.0
    assert evidence_of([_track(1.0)], SUMS, CARRIER, NO_EVIDENCE).log_odds == pytest.approx(MOST_LOGIT)


def test_level_and_its_growth():
    found = evidence_of([_track(0.7)], SUMS, CARRIER, NO_EVIDENCE)
    assert found.level_slope_db == pytest.approx(-30.0)
    assert found.level_db == pytest.approx(np.mean([-50.0 - 30.0 * np.log10(2.5 * 0.9**k) for k in range(2, 8)]))
