"""Echo levels of categories: walls by the image formula, repeatable, silent obstacles counted."""

import numpy as np
import pytest

from docs.studies.echo_levels import EchoLevels, echo_levels
from simulator import Phone

PHONE = Phone.ideal(speaker_m=[0.0, 0.05, 0.0], mics_m=[[0.0, 0.15, 0.0], [0.0, -0.05, 0.0]])


@pytest.mark.parametrize("distance_m", [1.5, 3.0])
def test_walls_follow_the_image_formula(distance_m: float) -> None:
    """Direct sound over 10 cm, the echo over twice the distance and 0.54 dB/m of air; brick takes up to 1.3 dB of it.

    Oblique walls are met at their nearest point by part of their face only: 3 dB are left for edges.
    """
    level = echo_levels("wall", distance_m, PHONE, count=4, seed=1).level_db
    assert level.shape == (12,)
    nearest = distance_m - 0.10 * np.cos(np.deg2rad(30.0))  # speaker and microphone lie ahead of the origin
    expected = 20.0 * np.log10(0.1 / (2.0 * nearest)) - 0.54 * 2.0 * distance_m
    assert np.median(level) == pytest.approx(expected, abs=3.0)


def test_levels_repeat_and_fall_with_distance() -> None:
    near, again, far = (echo_levels("pedestrian", d, PHONE, count=3, seed=2).level_db for d in (1.5, 1.5, 5.0))
    np.testing.assert_array_equal(near, again)
    assert np.median(near) - np.median(far) > 8.0  # spreading alone gives 10.5 dB of amplitude, a sphere 21 dB


def test_no_echo_counts_as_the_quietest() -> None:
    levels = EchoLevels("sign", 3.0, np.array([-np.inf, -60.0, -40.0]))
    assert levels.percentile_db(0.0) == -np.inf
    assert levels.percentile_db(50.0) == -60.0
    assert levels.percentile_db(100.0) == -40.0


def test_bad_arguments_are_refused() -> None:
    with pytest.raises(ValueError, match="category must be one of"):
        echo_levels("dragon", 3.0, PHONE, count=1)
