"""What no detector may depend on: the level of a recording, its polarity, and at which sample it begins.

Two recordings a law by default; `OBSTACLEWATCH_FUZZ=10000` asks for 66.
"""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch import DistanceOnlyDetector, PaperDetector, Recording, StandingDetector, TrackingDetector
from obstaclewatch.detection import Detection
from tests.obstaclewatch.synthetic import BEEP, PHONE, C, Point, record

EXAMPLES = max(2, int(os.environ.get("OBSTACLEWATCH_FUZZ", "300")) // 150)
BEEPS = 8
DETECTORS: dict[str, Callable] = {
    "PaperDetector": lambda: PaperDetector(BEEP, PHONE, sound_speed_m_s=C),
    "DistanceOnlyDetector": lambda: DistanceOnlyDetector(BEEP, PHONE, sound_speed_m_s=C),
    "TrackingDetector": lambda: TrackingDetector(BEEP, PHONE, sound_speed_m_s=C),
    "StandingDetector": lambda: StandingDetector(BEEP, PHONE, sound_speed_m_s=C),
}
places = st.tuples(st.floats(2.0, 4.5), st.floats(-0.5, 0.5), st.floats(1.0, 1.5), st.integers(0, 1000))
law = settings(max_examples=EXAMPLES, deadline=None)


def _samples(place) -> np.ndarray:
    ahead, aside, speed, seed = place
    points = [Point(ahead, aside, 0.1), Point(1.3, gain=0.3, carried=True, bob_m=0.02)]
    return record(points, beeps=BEEPS, speed_m_s=speed, noise=0.01, seed=seed)


def _found(name: str, samples: np.ndarray) -> list[Detection]:
    return list(DETECTORS[name]().stream(Recording(samples.astype(np.float32), BEEP.sample_rate_hz)))


def _assert_alike(one: list[Detection], other: list[Detection]) -> None:
    assert len(one) == len(other) == BEEPS
    for first, second in zip(one, other, strict=True):
        assert len(first) == len(second)
        for name in ("range_m", "range2_m", "bearing_rad", "closing_speed_m_s", "snr_db"):
            np.testing.assert_allclose(getattr(second, name), getattr(first, name), rtol=1e-4, atol=1e-4, err_msg=name)
        np.testing.assert_array_equal(second.collides, first.collides)
        one_by, other_by = first.decision, second.decision
        assert (one_by.alert, one_by.votes) == (other_by.alert, other_by.votes)
        assert other_by.collision_probability == pytest.approx(one_by.collision_probability, abs=1e-3, nan_ok=True)


@pytest.mark.parametrize("name", DETECTORS)
def test_there_is_something_to_compare(name):
    assert sum(map(len, _found(name, _samples((3.0, 0.1, 1.0, 3))))) >= 2


@pytest.mark.parametrize("name", DETECTORS)
@law
@given(place=places, exponent=st.integers(-12, 2))
def test_the_level_of_a_recording_changes_nothing(name, place, exponent):
    """Powers of two: float32 rounds no sample."""
    samples = _samples(place)
    _assert_alike(_found(name, samples), _found(name, 2.0**exponent * samples))


@pytest.mark.parametrize("name", DETECTORS)
@law
@given(place=places)
def test_polarity_of_both_channels_changes_nothing(name, place):
    samples = _samples(place)
    _assert_alike(_found(name, samples), _found(name, -samples))


@pytest.mark.parametrize("name", DETECTORS)
@law
@given(place=places, late=st.integers(1, 4000))
def test_whole_samples_before_the_first_beep_change_nothing(name, place, late):
    samples = _samples(place)
    begun_earlier = np.concatenate([samples[:, -late:], samples], axis=1)
    _assert_alike(_found(name, samples), _found(name, begun_earlier))
