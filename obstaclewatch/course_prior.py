"""Which courses are thought possible before anything is heard, and which of them are collisions.

What is tested is where the echo comes from, while what decides is where the obstacle's near edge is. The reflecting
point lies within the edge by up to the obstacle's half breadth, so the two hypotheses overlap: collisions have it
mostly within 0.6 m of the walker's line (0.25 m of walker, and the obstacle), misses beyond.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

Array = NDArray[np.float64]

MISS_M = np.sqrt(np.concatenate([[0.0, 0.02, 0.05, 0.09, 0.14, 0.2, 0.27, 0.35], np.arange(0.44, 3.2, 0.1)]))
"""Evenly in the square, as bearing's cosine and path difference see it: 0.1 m^2 at 1.5 m are 3 mm of path, 65 degrees
of carrier."""
HEIGHTS_M = np.array([0.0, 0.2, 0.35, 0.5, 0.65, 0.8, np.inf])
"""Phone above reflecting point; the last stands for the corner with the ground. Those between are bonnets, doors and
the edges of signs; 20 cm more or less at 1.5 m would be taken for 15 cm of miss distance."""
HEIGHT_PRIOR = np.array([0.38, 0.06, 0.06, 0.06, 0.05, 0.04, 0.35])
RADIUS_M = 0.15
WALL_ANGLES_RAD = np.deg2rad(np.arange(0.0, 81.0, 2.5))
WALL_HEIGHTS_M = np.array([0.0, 0.25, 0.5, np.inf])
"""What mirrors below the phone are the flanks of cars, whose nearest point slides along as the walker passes."""
WALL_HEIGHT_PRIOR = np.array([0.48, 0.12, 0.12, 0.28])
WALL_PRIOR = 0.3
WALL_HIT_RAD = np.deg2rad(20.0)
"""Deviation of the angle at which walls are met. A wall that is hit lies across the way, but so does one whose end is
passed: of 40 walls of the development walks, 14 of the 21 hit and 6 of the 19 missed lay within 25 degrees."""
WALL_MISS_RAD, WALL_MISS_STD_RAD = np.deg2rad(25.0), np.deg2rad(8.0)
FRONT_M = 0.10
"""How far hands and phone reach ahead of the phone's middle."""
BODY_M = 0.07
"""Deviation of half an obstacle's breadth, by which collisions spread beyond the walker's half width: the reflecting
point of a collision has a deviation of 0.25 + 0.07 m, and a miss begins at 0.25 + 5 x 0.07 m, give or take 0.12 m."""
EDGE_STD_M = 0.12
FAR_M, FAR_DECAY_M = 1.2, 0.6

WALKER_M_S, WALKER_STD_M_S = 1.25, 0.2
WALK_RATIO_M_MIN = 0.00646
"""Step length over steps a minute, the same at all usual speeds (Murakami and Otaka 2017, J. Phys. Ther. Sci. 29)."""
WALK_RATIO_SPREAD = 0.12
"""How people differ in it: 0.60 +- 0.07 cm per step a minute (Bogen et al. 2018, Gait Posture 61)."""
ONCOMING_M_S = (0.3, 1.9)
"""What an obstacle that comes the other way adds to the walker's speed."""
ONCOMING_PRIOR = 0.12
ANY_SPEED = 1e-3


@dataclass(frozen=True)
class Hypotheses:
    """H courses.

    Attributes:
        miss_m: (H,) miss distance of a round body's middle; 0 for walls.
        height_m: (H,) phone above the reflecting point; infinite stands for the corner with the ground.
        angle_rad: (H,) of a wall's normal to the course; 0 for other things.
        radius_m: (H,) radius of curvature in plan; 0 for walls.
        is_wall: (H,) whether it mirrors.
        log_prior: (H,) up to a constant.
        collision: (H,) share of the prior that is a collision.
        contact_m: (H,) distance ahead of the phone's middle at which the walker's body meets it.
    """

    miss_m: Array
    height_m: Array
    angle_rad: Array
    radius_m: Array
    is_wall: NDArray[np.bool_]
    log_prior: Array
    collision: Array
    contact_m: Array


def hypotheses(half_width_m: float) -> Hypotheses:
    """Round things at all miss distances and heights, then walls at all angles; half of all collide."""
    misses, angles = len(MISS_M), len(WALL_ANGLES_RAD)
    things, walls = misses * len(HEIGHTS_M), angles * len(WALL_HEIGHTS_M)
    across = np.exp(-0.5 * (WALL_ANGLES_RAD / WALL_HIT_RAD) ** 2)
    alongside = ndtr((WALL_ANGLES_RAD - WALL_MISS_RAD) / WALL_MISS_STD_RAD)
    hit = _both(_of_hits(half_width_m), across / across.sum())
    passed = _both(_of_misses(half_width_m), alongside / alongside.sum())
    is_wall = np.arange(things + walls) >= things
    return Hypotheses(
        miss_m=np.concatenate([np.tile(MISS_M, len(HEIGHTS_M)), np.zeros(walls)]),
        height_m=np.concatenate([np.repeat(HEIGHTS_M, misses), np.repeat(WALL_HEIGHTS_M, angles)]),
        angle_rad=np.concatenate([np.zeros(things), np.tile(WALL_ANGLES_RAD, len(WALL_HEIGHTS_M))]),
        radius_m=np.where(is_wall, 0.0, RADIUS_M),
        is_wall=is_wall,
        log_prior=np.log(0.5 * (hit + passed)),
        collision=hit / (hit + passed),
        contact_m=_contacts(half_width_m),
    )


@numba.njit(cache=True, error_model="numpy")
def walking_speed(step_hz: float) -> tuple[float, float]:
    """Expected walking speed and its deviation, m/s: of all walkers, and given their steps a second if they are known.

    speed = step length x cadence = walk ratio x cadence^2. 0 stands for not known.
    """
    if step_hz == 0.0:
        return WALKER_M_S, WALKER_STD_M_S
    told = WALK_RATIO_M_MIN * (60.0 * step_hz) ** 2 / 60.0
    usual, heard = WALKER_STD_M_S**-2, (WALK_RATIO_SPREAD * told) ** -2
    return (usual * WALKER_M_S + heard * told) / (usual + heard), (usual + heard) ** -0.5


@numba.njit(cache=True, error_model="numpy")
def speed_density(speed_m_s: Array, step_hz: float) -> Array:
    """Density of speeds of approach (H,), s/m: walkers', and one in eight that something comes the other way."""
    own, std = walking_speed(step_hz)
    slowest, fastest = ONCOMING_M_S
    density = np.empty(len(speed_m_s))
    for course in range(len(speed_m_s)):
        faster = speed_m_s[course] - own
        walking = np.exp(-0.5 * (faster / std) ** 2) / (np.sqrt(2.0 * np.pi) * std)
        oncoming = 1.0 / (fastest - slowest) if slowest < faster < fastest else 0.0
        density[course] = (1.0 - ONCOMING_PRIOR) * walking + ONCOMING_PRIOR * oncoming + ANY_SPEED
    return density


def _of_hits(half_width_m: float) -> Array:
    """(M,) shares of `MISS_M` among collisions."""
    share = np.exp(-0.5 * (MISS_M / (half_width_m + BODY_M)) ** 2) * np.gradient(MISS_M)
    return share / share.sum()


def _of_misses(half_width_m: float) -> Array:
    """(M,) shares of `MISS_M` among misses: from an edge on, evenly, then ever fewer that are heard."""
    edge = ndtr((MISS_M - half_width_m - 5.0 * BODY_M) / EDGE_STD_M)
    share = edge * np.exp(-np.maximum(MISS_M - FAR_M, 0.0) / FAR_DECAY_M) * np.gradient(MISS_M)
    return share / share.sum()


def _contacts(half_width_m: float) -> Array:
    """(H,) distances ahead at which a body with a round front, `FRONT_M` before the phone's middle, is touched.

    A round thing lies between the front and abreast of it; what a miss distance beyond its reach says to be a collision
    is broader than the reflecting point tells, and is taken to be met abreast. A wall is met where its normal touches.
    """
    round_m = np.sqrt(np.maximum((RADIUS_M + half_width_m) ** 2 - MISS_M**2, 0.0))
    wall_m = half_width_m / np.cos(WALL_ANGLES_RAD)
    touched = [np.tile(round_m, len(HEIGHTS_M)), np.tile(wall_m, len(WALL_HEIGHTS_M))]
    return np.concatenate(touched) + FRONT_M - half_width_m


def _both(things: Array, walls: Array) -> Array:
    """(H,) shares of round things by miss distance and of walls by angle, at all their heights."""
    return np.concatenate(
        [
            (1.0 - WALL_PRIOR) * np.outer(HEIGHT_PRIOR / HEIGHT_PRIOR.sum(), things).ravel(),
            WALL_PRIOR * np.outer(WALL_HEIGHT_PRIOR, walls).ravel(),
        ]
    )
