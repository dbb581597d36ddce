"""How fast a walker goes, by their steps: speed = step length x cadence = walk ratio x cadence^2.

The walk ratio, step length over cadence, is a person's own and hardly depends on the speed. It differs between people
by 12 %, and in one person from one test to the next by some 3 %: a phone that knows its walker knows their speed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.argument_types import as_number, as_numbers

WALKER_M_S, WALKER_STD_M_S = 1.25, 0.2
"""Of all walkers."""
RATIO_LIMITS_M_MIN = (0.003, 0.012)
"""Within which people's walk ratios lie: five deviations about their mean. Whoever counts one foot's steps alone
measures four times their own."""


class WalkRatio(NamedTuple):
    """A walk ratio and how well it is known.

    Attributes:
        m_min: metres that a step is long for each step a minute.
        spread: its relative deviation.
    """

    m_min: float
    spread: float


ANYONE = WalkRatio(0.00646, 0.12)
"""The same at all usual speeds (Murakami and Otaka 2017, J. Phys. Ther. Sci. 29); people differ, 0.60 +- 0.07 cm per
step a minute (Bogen et al. 2018, Gait Posture 61)."""
OWN_SPREAD = 0.03
"""From one test to the next of 40 people step length differed by 2.1 % and cadence by 2.1 % (standard errors of
measurement, jkema.org 9-2-208, table 1)."""
TINY = float(np.finfo(np.float64).tiny)
CADENCE_SPREAD = 0.02
"""Relative deviation of the cadence, as the ground's echo gives it."""


class WalkingSpeed(NamedTuple):
    """What is known of a walker's speed: its mean and its deviation, m/s."""

    mean_m_s: float
    std_m_s: float


USUAL = WalkingSpeed(WALKER_M_S, WALKER_STD_M_S)
"""Of a walker whose steps are not known."""


def walk_ratio(own_m_min: float | None) -> WalkRatio:
    """That of a walker who has measured it; that of people for None.

    Raises:
        ValueError: a ratio that no person has.
    """
    if own_m_min is None:
        return ANYONE
    own_m_min = as_number("walk_ratio_m_min", own_m_min)
    least, most = RATIO_LIMITS_M_MIN
    if not least <= own_m_min <= most:
        raise ValueError(
            f"walk_ratio_m_min must be from {least} to {most}, as people's is by the steps of both feet, "
            f"got {own_m_min:.4g}"
        )
    return WalkRatio(own_m_min, OWN_SPREAD)


def measured_walk_ratio(distance_m: float, duration_s: float, steps: float) -> float:
    """A walker's own ratio, m per step a minute, by one walk on level ground: `TrackingDetector(walk_ratio_m_min=...)`.

    Args:
        distance_m, duration_s: of the walk, a few tens of metres at a usual speed.
        steps: how many of both feet.

    Raises:
        ValueError: a number that is not positive and finite, or a ratio that no person has.

    >>> from obstaclewatch import measured_walk_ratio
    >>> print(f"{measured_walk_ratio(distance_m=50.0, duration_s=38.0, steps=71):.5f}")
    0.00628
    """
    distance_m, duration_s, steps = as_numbers(distance_m=distance_m, duration_s=duration_s, steps=steps)
    for name, value in (("distance_m", distance_m), ("duration_s", duration_s), ("steps", steps)):
        if not 0.0 < value < np.inf:
            raise ValueError(f"{name} must be positive and finite, got {value}")
    return walk_ratio(distance_m * duration_s / max(60.0 * (steps * steps), TINY)).m_min


def walking_speed(step_hz: float, ratio: WalkRatio = ANYONE) -> WalkingSpeed:
    """What is known of the speed: of all walkers, and given their steps a second. 0 stands for not known."""
    if step_hz == 0.0:
        return USUAL
    by_steps = ratio.m_min * (60.0 * step_hz) ** 2 / 60.0
    usual, received = 1.0 / WALKER_STD_M_S**2, 1.0 / ((ratio.spread**2 + (2.0 * CADENCE_SPREAD) ** 2) * by_steps**2)
    return WalkingSpeed((usual * WALKER_M_S + received * by_steps) / (usual + received), (usual + received) ** -0.5)
