"""Approaches: one walker, one target, one outcome that geometry decides.

An approach puts a target of a category into the setting of a scene, in or beside the path of a walker. Its outcome
is fixed by the lateral offset alone, drawn as the position of the target's near edge across the walker's line: for a
collision between a central hit and the least overlap of the recipe, else within its clearances.

Gait sways the walker by at most 3.5 cm, so neither is ever within a centimetre of the boundary; `ground_truth` has
the last word on every approach made here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from obstaclewatch.support.argument_types import as_number, check_seed, check_types
from obstaclewatch.support.arrays import Floats
from scenes.obstacles import random_obstacle, walker_body
from scenes.obstacles.pedestrian import random_person
from scenes.streets.placing import distance_along, extents, half_width_across, lateral_shift, moved_back, placed
from scenes.streets.surroundings import SETTINGS, Setting, ground_of, neighbours
from scenes.truth.swept import Body
from scenes.truth.truth import Contact, contact, passing_time
from scenes.walks.gait_walk import WALK_RATIO_M_PER_STEPS_MIN, WALK_RATIO_SPREAD, Gait, GaitWalk
from simulator.phone.phone import Phone
from simulator.scene.scene import Obstacle, Scene

SPEED_M_S = (0.8, 1.6)
MOST_DEVIATIONS = 2.5
"""Of a walk ratio from the usual one."""
START_M = (4.5, 6.0)
SHORTEST_S, LONGEST_S = 3.0, 6.0
AFTER_CONTACT_S = 0.010
BEHIND_M = 0.3
ALONGSIDE_S = 2.0
ATTEMPTS = 25


@dataclass(frozen=True)
class Recipe:
    """How surely walks hit or miss, and whom they meet.

    Recipes map the same random numbers: at equal seed and index the same walker meets the same target on the same
    side, but for the few that ground truth does not confirm and that are drawn again.

    Attributes:
        overlap_m: least overlap of the target's near edge with the walker's half width, as drawn.
        clearance_m: least and greatest gap of walks without a collision, as drawn.
        confirmed_m: least overlap and least clearance that ground truth must find.
        crossing: whether a pedestrian may cross the walker's path; who would cross comes towards the walker otherwise.
    """

    overlap_m: float
    clearance_m: tuple[float, float]
    confirmed_m: tuple[float, float]
    crossing: bool

    def confirms(self, met: Contact, collision: bool) -> bool:
        """Whether a walk has the outcome that was asked for, clearly enough."""
        overlap_m, clearance_m = self.confirmed_m
        if collision:
            return bool(np.isfinite(met.contact_time_s)) and Body().half_width_m - met.miss_distance_m >= overlap_m
        return bool(np.isnan(met.contact_time_s)) and met.clearance_m >= clearance_m


RECIPES = {
    "paper": Recipe(0.20, (0.54, 0.90), (0.20, 0.50), crossing=False),
    "mixed": Recipe(0.06, (0.10, 0.90), (-np.inf, 0.05), crossing=True),
}
"""`paper`: its field test, clear-cut, people stand or come the other way (its participants walk towards obstacles at
recorded angles, section 4.1). `mixed`: the street as it is, with close calls and people who cross."""


@dataclass(frozen=True)
class Approach:
    """A walk towards a target.

    Attributes:
        index: number of the approach within its study; with the seed, the key of its random stream.
        scene_name: setting, one of `scenes.list_scenes()`.
        category: of the target.
        phone_name: preset of the phone.
        collision: whether the walker's body meets the target, as `ground_truth` confirms.
        seed: of the study.
        scene: ground, target, and what stands around.
        target: name of the target in the scene.
        walk: of the phone; it ends 10 ms after contact, or past the target, after a whole number of beeps.
        phone: held by the walker's body.
        stretch: part of the route that it happens on.

    Example:
        >>> from scenes import make_approach
        >>> approach = make_approach("supermarket", "sign", index=7, collision=False)
        >>> approach.scene.obstacle(approach.target).category, approach.phone_name
        ('sign', 'galaxy-s5')
    """

    index: int
    scene_name: str
    category: str
    phone_name: str
    collision: bool
    seed: int
    scene: Scene
    target: str
    walk: GaitWalk
    phone: Phone
    stretch: str


@dataclass(frozen=True)
class SceneCollection:
    """What the paper collected in one scene.

    Attributes:
        cases: approaches by category of the obstacle.
        phones: presets used there.

    Example:
        >>> from scenes import DATA_COLLECTION
        >>> {name: sum(collected.cases.values()) for name, collected in DATA_COLLECTION.items()}
        {'supermarket': 821, 'campus': 478}
    """

    cases: dict[str, int]
    phones: tuple[str, ...]


DATA_COLLECTION: dict[str, SceneCollection] = {
    "supermarket": SceneCollection(
        {"wall": 108, "dustbin": 312, "car": 157, "sign": 136, "pedestrian": 108}, ("galaxy-s5", "galaxy-s8-plus")
    ),
    "campus": SceneCollection(
        {"wall": 48, "dustbin": 96, "car": 106, "pedestrian": 228}, ("galaxy-s5", "galaxy-note5")
    ),
}
"""The paper's 821 + 478 = 1299 cases (section 4.1)."""


def make_approach(
    scene_name: str,
    category: str,
    index: int,
    phone_name: str = "galaxy-s5",
    seed: int = 0,
    collision: bool = True,
    beep_period_s: float = 0.090,
    recipe: str = "mixed",
) -> Approach:
    """One approach, the same for the same arguments whatever was made before it.

    Phones see the same walk: the random stream depends on the seed and the index alone.

    Args:
        scene_name: "supermarket" or "campus".
        category: of the target: "wall", "dustbin", "car", "sign", "pedestrian" or "clutter".
        index: not negative.
        phone_name: preset of the phone.
        seed: of the study.
        collision: whether the walker is to meet the target.
        beep_period_s: the walk lasts a whole number of these.
        recipe: one of `RECIPES`.

    Raises:
        ValueError: an unknown scene, category, phone or recipe, an index or a seed that is no whole number, or a period
            outside 0-1 s.
        RuntimeError: no placement with the wanted outcome was found.

    Example:
        >>> from scenes import ground_truth, make_approach
        >>> approach = make_approach("campus", "car", index=3, collision=True)
        >>> truth = ground_truth(approach.scene, approach.walk, approach.phone, [0.0], approach.target)
        >>> truth.collides
        True
    """
    check_types(scene_name=(scene_name, str), category=(category, str), collision=(collision, bool | np.bool_))
    check_types(recipe=(recipe, str))
    beep_period_s = as_number("beep_period_s", beep_period_s)
    if scene_name not in SETTINGS:
        raise ValueError(f"approaches are drawn in scenes of {sorted(SETTINGS)}, got {scene_name!r}")
    if recipe not in RECIPES:
        raise ValueError(f"recipe must be one of {sorted(RECIPES)}, got {recipe!r}")
    check_seed(index=index, seed=seed)
    if not 0.0 < beep_period_s < 1.0:
        raise ValueError(f"beep_period_s must lie between 0 and 1, got {beep_period_s}")
    phone = Phone.named(phone_name)
    setting = SETTINGS[scene_name]
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))
    stature = rng.uniform(1.60, 1.88)
    height, distance = max(1.25, 0.745 * stature), rng.uniform(0.30, 0.40)
    walk, target = _encounter(rng, setting, RECIPES[recipe], category, collision, height, beep_period_s)
    stretch = setting.stretches[rng.integers(len(setting.stretches))]
    around = neighbours(rng, stretch, target, walk)
    scene = Scene((ground_of(stretch.ground), target, *around), name=scene_name)
    body = walker_body(distance, height, stature)
    return Approach(
        index, scene_name, category, phone_name, collision, seed, scene, target.name, walk, phone.held_by(body),
        stretch.name,
    )  # fmt: skip


def _encounter(
    rng: np.random.Generator,
    setting: Setting,
    recipe: Recipe,
    category: str,
    collision: bool,
    height_m: float,
    period_s: float,
) -> tuple[GaitWalk, Obstacle]:
    """A walk and a target with the wanted outcome."""
    for _ in range(ATTEMPTS):
        endless = _endless_walk(rng, height_m)
        target = _placed_target(rng, _target(rng, setting, recipe, category, collision), endless, recipe, collision)
        end = _end_s(target, endless, collision)
        if not np.isfinite(end):
            continue
        walk, target = _timed(endless, target, end, period_s)
        if recipe.confirms(contact(target, walk), collision):
            return walk, target
    raise RuntimeError(f"no {category} with collision={collision} could be placed in {ATTEMPTS} attempts")


def _endless_walk(rng: np.random.Generator, height_m: float) -> GaitWalk:
    """A walk from the origin, within 10 degrees of +x, longer than any approach."""
    speed = float(np.clip(rng.normal(1.25, 0.2), *SPEED_M_S))
    pitch = float(np.clip(rng.normal(np.deg2rad(30.0), np.deg2rad(4.0)), np.deg2rad(20.0), np.deg2rad(40.0)))
    return GaitWalk(
        start_m=np.array([0.0, 0.0, height_m]),
        heading_rad=rng.uniform(-1.0, 1.0) * np.deg2rad(10.0),
        speed_m_s=speed,
        duration_s=15.0,
        pitch_rad=pitch,
        gait=Gait.at_speed(speed, rng.uniform(0.0, 4.0 * np.pi), _walk_ratio_m_min(rng)),
    )


def _walk_ratio_m_min(rng: np.random.Generator) -> float:
    """A person's own, so that steps tell a walker's speed no better than they do; of a stream of its own."""
    departure = np.clip(rng.spawn(1)[0].standard_normal(), -MOST_DEVIATIONS, MOST_DEVIATIONS)
    return float(WALK_RATIO_M_PER_STEPS_MIN * (1.0 + WALK_RATIO_SPREAD * departure))


def _target(rng: np.random.Generator, setting: Setting, recipe: Recipe, category: str, collision: bool) -> Obstacle:
    """A target over the origin, rotated as such things stand to a walker along +x, with its velocity."""
    name = f"target-{category}"
    if category == "pedestrian":
        return _target_person(rng, setting, recipe, name)
    obstacle = random_obstacle(category, rng, name)
    alongside = category == "wall" and not collision and rng.random() < 0.4  # two in five of the missed are passed so
    return placed(obstacle, np.zeros(2), target_yaw(rng, category, alongside))


def target_yaw(rng: np.random.Generator, category: str, alongside: bool = False) -> float:
    """Yaw of an obstacle of a category against a walker along +x, rad; 0 faces the walker.

    Args:
        rng: to draw from.
        category: walls are faced within 40 degrees, signs are put up to be read, all else stands anyhow.
        alongside: of a wall, whether it runs along the path instead.
    """
    if category == "wall":
        low, high = (65.0, 90.0) if alongside else (0.0, 40.0)
        return float(rng.choice([-1.0, 1.0]) * np.deg2rad(rng.uniform(low, high)))
    if category == "sign":
        return float(rng.normal(0.0, np.deg2rad(15.0)) + np.pi * rng.integers(2))
    return float(rng.uniform(-np.pi, np.pi))


def _target_person(rng: np.random.Generator, setting: Setting, recipe: Recipe, name: str) -> Obstacle:
    """Someone who stands, comes towards the walker, or crosses."""
    kind = rng.choice(["stands", "comes", "crosses"], p=setting.pedestrian_kinds)
    if kind == "stands":
        return placed(random_person(rng, name, walking=False), np.zeros(2), rng.uniform(-np.pi, np.pi))
    if kind == "comes" or not recipe.crossing:
        heading = np.pi + rng.normal(0.0, np.deg2rad(8.0))
    else:
        heading = rng.choice([-1.0, 1.0]) * np.deg2rad(rng.uniform(75.0, 105.0))
    velocity = rng.uniform(0.8, 1.4) * np.array([np.cos(heading), np.sin(heading), 0.0])
    return placed(random_person(rng, name, walking=True), np.zeros(2), float(heading) - np.pi, velocity)


def _placed_target(
    rng: np.random.Generator, target: Obstacle, walk: GaitWalk, recipe: Recipe, collision: bool
) -> Obstacle:
    """The target at its distance ahead and its offset across the walker's line, both as seen by the target."""
    body = Body()
    relative = _velocity(walk) - target.velocity_m_s[:2]
    closing = float(np.hypot(*relative))
    ahead = relative / closing
    left = np.array([-ahead[1], ahead[0]])
    half_width, middle = half_width_across(body, walk.heading_rad, float(np.arctan2(ahead[1], ahead[0])))
    low, high = extents(target, left, body.height_m)
    if collision:
        edge = rng.uniform(min(-0.5 * (high - low), -0.01), half_width - recipe.overlap_m)
    else:
        edge = half_width + rng.uniform(*recipe.clearance_m)
    lateral = (middle + lateral_shift(edge, rng.choice([-1.0, 1.0]), (low, high))) * left
    wanted = max(rng.uniform(*START_M), closing * (SHORTEST_S + 0.3))
    along = distance_along(target, walk.start_m[:2], lateral, ahead, wanted)
    return placed(target, lateral + along * ahead)


def _end_s(target: Obstacle, walk: GaitWalk, collision: bool) -> float:
    """When the walk ends: just after contact; else once the target lies behind, or 2 s after coming alongside."""
    if collision:
        return contact(target, walk).contact_time_s + AFTER_CONTACT_S
    relative = _velocity(walk) - target.velocity_m_s[:2]
    closing = float(np.hypot(*relative))
    _, far = extents(target, relative / closing, Body().height_m)
    return max(SHORTEST_S, min((far + BEHIND_M) / closing, passing_time(target, walk) + ALONGSIDE_S))


def _timed(walk: GaitWalk, target: Obstacle, end_s: float, period_s: float) -> tuple[GaitWalk, Obstacle]:
    """The same encounter with its clock set so that it ends at `end_s` after a whole number of beeps, at most 6 s."""
    beeps = int(min(end_s, LONGEST_S) / period_s)
    skipped = end_s - beeps * period_s
    start = walk.start_m + skipped * np.append(_velocity(walk), 0.0)
    phase = walk.motion.phase_rad + 2.0 * np.pi * walk.motion.step_hz * skipped
    gait = replace(walk.motion, phase_rad=float(phase))
    return replace(walk, start_m=start, duration_s=beeps * period_s, gait=gait), moved_back(target, -skipped)


def _velocity(walk: GaitWalk) -> Floats:
    """(2,) mean velocity in plan."""
    return walk.speed_m_s * np.array([np.cos(walk.heading_rad), np.sin(walk.heading_rad)])
