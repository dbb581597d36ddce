"""Which trajectories are thought possible before anything is received, and which of them are collisions.

What is tested is where the echo comes from, while what decides is where the obstacle's near edge is. The reflecting
point lies within the edge by up to the obstacle's half width, so the two hypotheses overlap. How far follows from the
height that the echo comes from: what has a corner with the ground is mostly narrow, what is received between is mostly
a car.

Shares and spreads of heights, gaps, angles and kinds were fitted on rendered development walks; no script derives them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.support.compiled import inlined

MISS_M = np.sqrt(np.concatenate([[0.0, 0.02, 0.05, 0.09, 0.14, 0.2, 0.27, 0.35], np.arange(0.44, 3.2, 0.1)]))
"""Evenly in the square, as bearing's cosine and path difference see it: 0.1 m^2 at 1.5 m are 3 mm of path, 65 degrees
of carrier."""
HEIGHTS_M = np.array([0.0, 0.2, 0.35, 0.5, 0.65, 0.8, np.inf])
"""Phone above reflecting point; the last stands for the corner with the ground. Those between are bonnets, doors and
the edges of signs; 20 cm more or less at 1.5 m would be taken for 15 cm of miss distance."""
HEIGHT_PRIOR = np.array([0.25, 0.115, 0.12, 0.13, 0.055, 0.01, 0.32])
"""Where the nearest echoes of 193 development walks came from, 0.95 to 1.7 m away: three in four of dustbins from their
corner with the ground, half of people and three in four of signs from the phone's height, all of cars from between."""
HIT_SPREAD_M = np.array([0.05, 0.2, 0.2, 0.2, 0.2, 0.2, 0.0])
MISS_GAP_M = np.array([0.35, 0.45, 0.45, 0.45, 0.45, 0.45, 0.30])
"""By height, beyond the walker's half width: the deviation of a collision's reflecting point, and where misses begin,
give or take `EDGE_STD_M`. What has a corner is narrow; cars are broad, and their nearest point lies far aside: in nine
of ten collisions of those walks within 0.34 m of the walker's line with dustbins, and within 1.05 m with cars."""
EDGE_STD_M = 0.12
FAR_M, FAR_DECAY_M = 1.2, 0.6
RADIUS_M = 0.15
FRONT_M = 0.10
"""How far hands and phone reach ahead of the phone's middle."""

WALL_ANGLES_RAD = np.deg2rad(np.arange(0.0, 81.0, 2.5))
WALL_HEIGHTS_M = np.array([0.0, np.inf, 0.0, 0.0])
WALL_TILTS_RAD = np.arctan([0.0, 0.0, 0.12, 0.28])
"""How far below the level the normal of what mirrors points: walls and their corners with the ground stand upright; the
panels of cars are received where they lean, and stay at that direction like walls. Taken for upright, a panel at 20
degrees that leans by 12 seems to be at 37."""
WALL_KIND_PRIOR = np.array([0.48, 0.28, 0.12, 0.12])
WALL_PRIOR = 0.3
WALL_HIT_RAD = np.deg2rad(30.0)
"""Deviation of the angle at which walls are met. A wall that is hit lies across the walker's line; so does one whose
end is passed: of 40 walls of the development walks, 14 of the 21 hit and 6 of the 19 missed lay within 25 degrees."""
WALL_MISS_RAD, WALL_MISS_STD_RAD = np.deg2rad(25.0), np.deg2rad(8.0)

ONCOMING_M_S = (0.3, 1.9)
"""What an oncoming obstacle adds to the walker's speed."""
ONCOMING_PRIOR = 0.12
ANY_SPEED = 1e-3


@dataclass(frozen=True)
class Hypotheses:
    """H trajectories.

    Attributes:
        miss_m: (H,) miss distance of a round body's middle; 0 for walls.
        height_m: (H,) phone above the reflecting point; infinite stands for the corner with the ground.
        angle_rad: (H,) of a wall's normal to the trajectory, in plan; 0 for other things.
        tilt_rad: (H,) of a wall's normal below the level; 0 for other things.
        radius_m: (H,) radius of curvature in plan; 0 for walls.
        is_wall: (H,) whether it mirrors.
        log_prior: (H,) up to a constant.
        collision: (H,) share of the prior that is a collision.
        contact_m: (H,) distance ahead of the phone's middle at which the walker's body meets it.
    """

    miss_m: Floats
    height_m: Floats
    angle_rad: Floats
    tilt_rad: Floats
    radius_m: Floats
    is_wall: Flags
    log_prior: Floats
    collision: Floats
    contact_m: Floats


def hypotheses(half_width_m: float) -> Hypotheses:
    """Round things at all miss distances and heights, then walls at all angles; half of all collide."""
    misses, angles = len(MISS_M), len(WALL_ANGLES_RAD)
    things, walls = misses * len(HEIGHTS_M), angles * len(WALL_HEIGHTS_M)
    hit, passed = (
        np.concatenate([(1.0 - WALL_PRIOR) * thing, WALL_PRIOR * wall])
        for thing, wall in zip(_things(half_width_m), _walls(), strict=True)
    )
    is_wall = np.arange(things + walls) >= things
    return Hypotheses(
        miss_m=np.concatenate([np.tile(MISS_M, len(HEIGHTS_M)), np.zeros(walls)]),
        height_m=np.concatenate([np.repeat(HEIGHTS_M, misses), np.repeat(WALL_HEIGHTS_M, angles)]),
        angle_rad=np.concatenate([np.zeros(things), np.tile(WALL_ANGLES_RAD, len(WALL_HEIGHTS_M))]),
        tilt_rad=np.concatenate([np.zeros(things), np.repeat(WALL_TILTS_RAD, angles)]),
        radius_m=np.where(is_wall, 0.0, RADIUS_M),
        is_wall=is_wall,
        log_prior=np.log(0.5 * (hit + passed)),
        collision=hit / (hit + passed),
        contact_m=_contacts(half_width_m),
    )


@inlined
def speed_density(speed_m_s: Floats, own_m_s: float, std_m_s: float) -> Floats:
    """Density of speeds of approach (H,), s/m: the walker's own, and one in eight of an oncoming obstacle's."""
    slowest, fastest = ONCOMING_M_S
    density = np.empty(len(speed_m_s))
    for trajectory in range(len(speed_m_s)):
        faster = speed_m_s[trajectory] - own_m_s
        walking = np.exp(-0.5 * (faster / std_m_s) ** 2) / (np.sqrt(2.0 * np.pi) * std_m_s)
        oncoming = 1.0 / (fastest - slowest) if slowest < faster < fastest else 0.0
        density[trajectory] = (1.0 - ONCOMING_PRIOR) * walking + ONCOMING_PRIOR * oncoming + ANY_SPEED
    return density


def _things(half_width_m: float) -> tuple[Floats, Floats]:
    """(heights x M,) shares of miss distances among collisions, and among misses: from an edge on, then ever fewer."""
    spread, edge = (half_width_m + beyond[:, None] for beyond in (HIT_SPREAD_M, MISS_GAP_M))
    hit = np.exp(-0.5 * (MISS_M / spread) ** 2)
    passed = ndtr((MISS_M - edge) / EDGE_STD_M) * np.exp(-np.maximum(MISS_M - FAR_M, 0.0) / FAR_DECAY_M)
    return _of_kinds(HEIGHT_PRIOR, hit * np.gradient(MISS_M)), _of_kinds(HEIGHT_PRIOR, passed * np.gradient(MISS_M))


def _walls() -> tuple[Floats, Floats]:
    """(kinds x A,) shares of angles among the walls that are hit, and among those that are passed."""
    across = np.exp(-0.5 * (WALL_ANGLES_RAD / WALL_HIT_RAD) ** 2)
    alongside = ndtr((WALL_ANGLES_RAD - WALL_MISS_RAD) / WALL_MISS_STD_RAD)
    return _of_kinds(WALL_KIND_PRIOR, across), _of_kinds(WALL_KIND_PRIOR, alongside)


def _of_kinds(prior: Floats, weight: Floats) -> Floats:
    """(kinds x places,) shares: the kinds' by their prior, a kind's places by their weights (kinds or 1, places)."""
    rows = np.broadcast_to(weight, (len(prior), weight.shape[-1]))
    share: Floats = (prior / prior.sum() * (rows / rows.sum(axis=1, keepdims=True)).T).T.ravel()
    return share


def _contacts(half_width_m: float) -> Floats:
    """(H,) distances ahead at which a body with a round front, `FRONT_M` before the phone's middle, is touched.

    A round thing lies between the front and abreast of it; what a miss distance beyond its reach says to be a collision
    is broader than the reflecting point suggests, and is taken to be met abreast. A wall is met where its normal
    touches.
    """
    round_m = np.sqrt(np.maximum((RADIUS_M + half_width_m) ** 2 - MISS_M**2, 0.0))
    wall_m = half_width_m / np.cos(WALL_ANGLES_RAD)
    touched = [np.tile(round_m, len(HEIGHTS_M)), np.tile(wall_m, len(WALL_HEIGHTS_M))]
    return np.concatenate(touched) + FRONT_M - half_width_m
