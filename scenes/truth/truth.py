"""Ground truth from the meshes and the walk alone: where the obstacle is, and whether the walker meets it.

Nothing here uses paths or echoes, so that an error of the tracer cannot mark its own work.

Against dense sampling of 10,000 random walks past obstacles of all categories, a third of them moving
(tests/scenes/truth/test_against_brute_force.py): no verdict differs but for the 39 walks within 1 mm of contact; ranges
agree to 5 um, gaps to 0.33 mm, instants of contact to 1.4 ms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.argument_types import as_finite, check_types
from obstaclewatch.support.arrays import Flags, Floats, Strings
from scenes.truth.ground_corner import corner_points
from scenes.truth.nearest import facing, nearest_points
from scenes.truth.swept import Body, Slab
from simulator.phone.phone import Phone
from simulator.scene.pose import Pose, Walk
from simulator.scene.scene import Obstacle, Scene

NOT_IN_THE_WAY = ("ground",)
"""Categories that cannot be collided with."""

TRACK_STEP_S = 0.010
"""Spacing at which a walk is followed for contact, straight between two samples: gait departs by some 20 um."""

INSTANT_S = 1e-4
"""Over which a walk's velocity at its end is taken."""

FACING_RAD = float(np.deg2rad(25.0))
"""Between the direction to the phone and the normals of all faces at the nearest point of what faces it. A face that is
met square is at 0, a rim's top at 60 or more; between them lie the folds of finely meshed curved surfaces."""

LEVEL_M = 0.03
"""Lower than the phone by more than this is below it."""

UP_M = 0.05
UPRIGHT_RAD = float(np.deg2rad(8.0))
"""What leans by less over so much height above the corner is upright: bins lean by up to 5 degrees, boards by 15."""

PASSING_M = 0.05
"""Over the least distance of a walk, from which on the walker counts as passing."""

ROUNDING_S = 1e-6
"""By which an instant may lie outside of a walk: what sums of steps leave."""

LINE_M = 1000.0
"""Length of the line along which a walk is extended for the miss distance."""


@runtime_checkable
class HasMeanPath(Protocol):
    """A walk that knows its path without the gait."""

    def mean_plan_m(self, time_s: ArrayLike) -> Floats:
        """(N,) times, s, to (N, 2) places in plan."""


@dataclass(frozen=True)
class GroundTruth:
    """What is true of an obstacle at T instants of a walk, and of the walk.

    Attributes:
        time_s: (T,) the instants asked for.
        obstacle: (T,) name of the obstacle that the row is about: the target, or the nearest if none was named.
        nearest_point_m: (T, 3) nearest point of its mesh to the middle between speaker and microphone 0, world frame.
        range_m: (T,) distance from that middle to the nearest point.
        mic_range_m: (T, 2) distance from each microphone to the same nearest point (the paper's D1 and D2).
        ground_range_m: (T,) half the shortest path from that middle to the obstacle, to the ground at z = 0 and back,
            in either order: the echo of the corner that both make. To the foot of an upright obstacle it is the
            distance; where the obstacle leans, its point of reflection is higher up.
        mic_ground_range_m: (T, 2) from each microphone to that point, the mean of the straight path and that over
            the ground.
        by_ground: (T,) whether the corner is to be detected first: the nearest point lies lower than the phone
            and the surface there does not face it, as on the rim of a thing with a flat top, and what stands at the
            corner is upright, as hands, shoes and leaning boards are not. Judged by the phone's mean height over the
            walk: either echo fades over some 10 cm of height, a Fresnel zone, and a bob of 2-4 cm must not make the
            truth jump between them from beep to beep.
        bearing_rad: (T,) the paper's walking angle, 0 to pi: between the heading and the nearest point, in plan.
        signed_bearing_rad: (T,) the same, positive to the left.
        radius_m: (T,) half the obstacle's extent across the heading, of its part no higher than the walker;
            NaN if it has no such part.
        miss_distance_m: distance in plan between the obstacle and the line along which the phone walks on average
            (the route of a `RouteWalk`), from its start on and straight beyond its end unless it ends at a stand, as
            seen from the obstacle if that moves; 0 if the line meets it.
        clearance_m: smallest gap between the walker's body and the obstacle during the walk; 0 if they touch.
        collides: whether the walker's body meets the obstacle during the walk.
        line_collides: the paper's looser rule: whether the phone's line meets it.
        contact_time_s: when the body first touches it; NaN if it does not.
        contact_obstacle: name of what is touched first; None if nothing is.

    Example:
        >>> import trimesh
        >>> from scenes import GaitWalk, ground_truth
        >>> from simulator import Material, Obstacle, Phone, Scene
        >>> post = trimesh.creation.cylinder(radius=0.1, segment=[[4.0, 0.6, 0.0], [4.0, 0.6, 2.0]])
        >>> scene = Scene([Obstacle(post, Material.named("metal"), "post")])
        >>> truth = ground_truth(scene, GaitWalk([0.0, 0.0, 1.3]), Phone.named("galaxy-s5"), [0.0, 1.0])
        >>> print(truth.range_m.round(2), truth.collides, f"{truth.clearance_m:.2f} m")
        [3.9  2.61] False 0.24 m
    """

    time_s: Floats
    obstacle: Strings
    nearest_point_m: Floats
    range_m: Floats
    mic_range_m: Floats
    ground_range_m: Floats
    mic_ground_range_m: Floats
    by_ground: Flags
    bearing_rad: Floats
    signed_bearing_rad: Floats
    radius_m: Floats
    miss_distance_m: float
    clearance_m: float
    collides: bool
    line_collides: bool
    contact_time_s: float
    contact_obstacle: str | None


@dataclass(frozen=True)
class Contact:
    """How a walk passes one obstacle: see the fields of the same names in `GroundTruth`."""

    miss_distance_m: float
    clearance_m: float
    contact_time_s: float


def ground_truth(
    scene: Scene,
    walk: Walk,
    phone: Phone,
    time_s: ArrayLike,
    target: str | None = None,
    half_width_m: float = 0.25,
    body: Body | None = None,
) -> GroundTruth:
    """Where the target is at some instants of a walk, and whether the walker meets it.

    Args:
        scene: obstacles; those of category "ground" are never collided with.
        walk: poses of the phone.
        phone: for the places of its transducers.
        time_s: (T,) instants within the walk; for one beep, the instant at which its centre meets the obstacle, which
            may lie beyond the end of the walk by the time that sound takes to there.
        target: name of the obstacle asked about; None asks about the nearest, and about contact with any.
        half_width_m: half the width of the walker's body.
        body: all its measures, instead of the half width and the usual rest.

    Raises:
        ValueError: an argument of another type, an instant outside of the walk, an unknown target, no obstacle to ask
            about, or one that moves up or down.

    Example:
        >>> import trimesh
        >>> from scenes import GaitWalk, ground_truth
        >>> from simulator import Material, Obstacle, Phone, Scene
        >>> wall = trimesh.creation.box(bounds=[[4.0, -2.0, 0.0], [4.2, 2.0, 3.0]])
        >>> scene = Scene([Obstacle(wall, Material.named("brick"), "wall")])
        >>> walk = GaitWalk([0.0, 0.0, 1.3], speed_m_s=1.3, duration_s=4.0)
        >>> truth = ground_truth(scene, walk, Phone.named("galaxy-s5"), time_s=[0.0], target="wall")
        >>> truth.contact_obstacle, round(truth.contact_time_s, 2)
        ('wall', 3.0)
    """
    check_types(scene=(scene, Scene), walk=(walk, Walk), phone=(phone, Phone), body=(body, Body | None))
    times = np.atleast_1d(as_finite("time_s", time_s))
    if times.ndim != 1 or len(times) == 0:
        raise ValueError(f"time_s must have shape () or (T,), T > 0, got {np.shape(time_s)}")
    asked = _asked(scene, target)
    pose = walk.pose(times)
    candidates = [_nearest(obstacle, pose, phone, times) for obstacle in asked]
    distance = np.array([distance for _, distance in candidates])
    _check_within(times, walk, distance.min(axis=0) / scene.air.sound_speed_m_s)
    nearest = distance.argmin(axis=0), np.arange(len(times))
    point = np.stack([point for point, _ in candidates])[nearest]
    middle, heading, mics = _middle(pose, phone), pose.body_heading_rad(), pose.to_world(phone.geometry.mics_m)
    signed = _signed_bearing(point - middle, heading)
    corner = np.stack([_corner(obstacle, pose, phone, times) for obstacle in asked])[nearest]
    steady = _without_bob(walk, phone, middle)
    worn = Body(half_width_m) if body is None else body
    contacts = [contact(obstacle, walk, worn) for obstacle in asked]
    first = _first([c.contact_time_s for c in contacts])
    return GroundTruth(
        time_s=times,
        obstacle=np.array([obstacle.name for obstacle in asked])[nearest[0]],
        nearest_point_m=point,
        range_m=np.linalg.norm(point - middle, axis=1),
        mic_range_m=np.linalg.norm(point[:, None] - mics, axis=2),
        ground_range_m=_mean_range(corner, middle),
        mic_ground_range_m=_mean_range(corner[:, None], mics),
        by_ground=np.stack([_corner_first(obstacle, steady, times) for obstacle in asked])[nearest],
        bearing_rad=np.abs(signed),
        signed_bearing_rad=signed,
        radius_m=np.stack([_radius(obstacle, heading, worn) for obstacle in asked])[nearest],
        miss_distance_m=min(c.miss_distance_m for c in contacts),
        clearance_m=min(c.clearance_m for c in contacts),
        collides=first is not None,
        line_collides=any(c.miss_distance_m == 0.0 for c in contacts),
        contact_time_s=np.nan if first is None else contacts[first].contact_time_s,
        contact_obstacle=None if first is None else asked[first].name,
    )


def _check_within(time_s: Floats, walk: Walk, late_s: Floats) -> None:
    """Refuse (T,) instants before a walk, or after its end by more than (T,) s.

    Walks go on beyond their ends, so that a wrong instant would get an answer that looks right.
    """
    outside = (time_s < -ROUNDING_S) | (time_s > walk.duration_s + late_s + ROUNDING_S)
    if outside.any():
        raise ValueError(
            f"time_s must lie within the walk, 0 to {walk.duration_s:g} s, or after it by no more than sound takes to "
            f"the obstacle, got {time_s[outside][0]:g}"
        )


def target_range_m(scene: Scene, walk: Walk, phone: Phone, time_s: ArrayLike, target: str) -> Floats:
    """(T,) `GroundTruth.range_m` alone, without what else is true.

    Raises:
        ValueError: an unknown target.
    """
    times = np.atleast_1d(np.asarray(time_s, dtype=np.float64))
    (obstacle,) = _asked(scene, target)
    return _nearest(obstacle, walk.pose(times), phone, times)[1]


def contact(obstacle: Obstacle, walk: Walk, body: Body | None = None) -> Contact:
    """How a walker passes one obstacle, which may move.

    Args:
        obstacle: any, whatever its category.
        walk: followed from 0 to its duration in steps of 10 ms, straight between two.
        body: measures of the walker; None takes the usual ones.
    """
    worn = Body() if body is None else body
    slab = Slab.of(obstacle.mesh, 0.0, worn.height_m)
    time, phone, core = _track(obstacle, walk, worn)
    distance = slab.distance_where_near(core, worn.half_width_m)
    return Contact(
        miss_distance_m=float(slab.distance_where_near(_mean_line(obstacle, walk, time, phone)).min()),
        clearance_m=max(0.0, float(distance.min()) - worn.half_width_m),
        contact_time_s=_at_index(slab.first_contact(core, distance, worn.half_width_m), time),
    )


def comes_within(obstacle: Obstacle, walk: Walk, gap_m: float) -> bool:
    """Whether an obstacle ever comes within a gap of the walker's body; quicker than the exact clearance."""
    body = Body()
    _, _, core = _track(obstacle, walk, body)
    slab, within_m = Slab.of(obstacle.mesh, 0.0, body.height_m), body.half_width_m + gap_m
    return not slab.far_from(core, within_m) and bool(slab.distance_where_near(core).min() <= within_m)


def passing_time(obstacle: Obstacle, walk: Walk) -> float:
    """When the walker's body first is as near to an obstacle as it ever gets, within `PASSING_M`, s."""
    time, _, core = _track(obstacle, walk, Body())
    slab = Slab.of(obstacle.mesh, 0.0, Body().height_m)
    distance = slab.distance_where_near(core, beyond_least_m=PASSING_M)
    return _at_index(slab.first_contact(core, distance, float(distance.min()) + PASSING_M), time)


def _track(obstacle: Obstacle, walk: Walk, body: Body) -> tuple[Floats, Floats, Floats]:
    """Times (N,), phone (N, 2) and body cores (N, 2, 2) in plan, as seen from the obstacle, every 10 ms."""
    time = np.linspace(0.0, walk.duration_s, max(2, 1 + int(np.ceil(walk.duration_s / TRACK_STEP_S))))
    pose = walk.pose(time)
    drift = time[:, None] * obstacle.velocity_m_s[:2]
    core = body.core(pose.position_m, pose.body_heading_rad()) - drift[:, None]
    return time, pose.position_m[:, :2] - drift, core


def _at_index(index: float, time_s: Floats) -> float:
    return float(np.interp(index, np.arange(len(time_s)), time_s)) if np.isfinite(index) else np.nan


def _asked(scene: Scene, target: str | None) -> Sequence[Obstacle]:
    asked = _named(scene, target)
    for obstacle in asked:
        if obstacle.velocity_m_s[2] != 0.0:
            velocity = obstacle.velocity_m_s.tolist()
            raise ValueError(
                f"velocity_m_s of '{obstacle.name}' must be level: contact is judged in plan, got {velocity}"
            )
    return asked


def _named(scene: Scene, target: str | None) -> Sequence[Obstacle]:
    if target is None:
        asked = [obstacle for obstacle in scene.obstacles if obstacle.category not in NOT_IN_THE_WAY]
        if not asked:
            raise ValueError(f"scene '{scene.name}' must have an obstacle to collide with, got none")
        return asked
    names = [obstacle.name for obstacle in scene.obstacles]
    if target not in names:
        raise ValueError(f"target must be an obstacle of scene '{scene.name}', got '{target}'; there are {names}")
    return [scene.obstacle(target)]


def _middle(pose: Pose, phone: Phone) -> Floats:
    """(T, 3) middle between the speaker and microphone 0."""
    return pose.to_world(0.5 * (phone.geometry.speaker_m + phone.geometry.mics_m[0]))


def _nearest(obstacle: Obstacle, pose: Pose, phone: Phone, time_s: Floats) -> tuple[Floats, Floats]:
    """(T, 3) nearest points in the world and (T,) distances; the obstacle has moved, so the question moves back."""
    drift = time_s[:, None] * obstacle.velocity_m_s
    point, distance = nearest_points(obstacle.mesh, _middle(pose, phone) - drift)
    return point + drift, distance


def _corner(obstacle: Obstacle, pose: Pose, phone: Phone, time_s: Floats) -> Floats:
    """(T, 3) where the obstacle is touched on the shortest path to it, to the ground and back."""
    drift = time_s[:, None] * obstacle.velocity_m_s * [1.0, 1.0, 0.0]
    return corner_points(obstacle.mesh, _middle(pose, phone) - drift) + drift


def _without_bob(walk: Walk, phone: Phone, middle_m: Floats) -> Floats:
    """(T, 3) the same places, at the mean height over the walk."""
    time = np.linspace(0.0, walk.duration_s, max(2, 1 + int(np.ceil(walk.duration_s / TRACK_STEP_S))))
    height = _middle(walk.pose(time), phone)[:, 2].mean()
    return np.column_stack([middle_m[:, :2], np.full(len(middle_m), height)])


def _corner_first(obstacle: Obstacle, middle_m: Floats, time_s: Floats) -> Flags:
    """(T,) as `GroundTruth.by_ground`, for phones at given places."""
    mesh, place = obstacle.mesh, middle_m - time_s[:, None] * obstacle.velocity_m_s
    nearest, _ = nearest_points(mesh, place)
    low = nearest[:, 2] < place[:, 2] - LEVEL_M
    not_facing = ~facing(mesh, place, FACING_RAD)
    _, beside_m = nearest_points(mesh, corner_points(mesh, place) + [0.0, 0.0, UP_M])
    return low & not_facing & (beside_m < UP_M * np.sin(UPRIGHT_RAD))


def _mean_range(corner_m: Floats, place_m: Floats) -> Floats:
    """Mean of the distances to a place and to its image in the ground; the last axis is x, y, z."""
    straight = np.linalg.norm(corner_m - place_m, axis=-1)
    return 0.5 * (straight + np.linalg.norm(corner_m - place_m * [1.0, 1.0, -1.0], axis=-1))


def _signed_bearing(offset_m: Floats, heading_rad: Floats) -> Floats:
    """(T,) angle in plan from the heading to the offset, -pi to pi, positive to the left."""
    cos, sin = np.cos(heading_rad), np.sin(heading_rad)
    ahead = offset_m[:, 0] * cos + offset_m[:, 1] * sin
    left = offset_m[:, 1] * cos - offset_m[:, 0] * sin
    return np.arctan2(left, ahead)


def _radius(obstacle: Obstacle, heading_rad: Floats, body: Body) -> Floats:
    slab = Slab.of(obstacle.mesh, 0.0, body.height_m)
    if len(slab.triangle_m) == 0:
        return np.full(len(heading_rad), np.nan)
    headings, where = np.unique(heading_rad, return_inverse=True)
    across = slab.triangle_m.reshape(-1, 2) @ np.stack([-np.sin(headings), np.cos(headings)])
    return (0.5 * np.ptp(across, axis=0))[where]


def _mean_line(obstacle: Obstacle, walk: Walk, time_s: Floats, phone_m: Floats) -> Floats:
    """(L, 2, 2) segments of the phone's path without its gait, as seen from the obstacle, and straight on at the end.

    A walk that knows its mean path is asked for it; for any other it is a straight line by least squares.
    """
    if isinstance(walk, HasMeanPath):
        mean = walk.mean_plan_m(time_s) - time_s[:, None] * obstacle.velocity_m_s[:2]
        before, end = walk.mean_plan_m(time_s[-1] - np.array([INSTANT_S, 0.0]))
        velocity = (end - before) / INSTANT_S - obstacle.velocity_m_s[:2]
    else:
        centered = time_s - time_s.mean()
        velocity = centered @ phone_m / (centered @ centered)
        mean = (phone_m.mean(axis=0) + velocity * (time_s[0] - time_s.mean()))[None]
    speed = float(np.hypot(*velocity))
    ahead = velocity / speed if speed > 0.0 else np.zeros(2)
    points = np.concatenate([mean, mean[-1:] + LINE_M * ahead])
    return np.stack([points[:-1], points[1:]], axis=1)


def _first(contact_time_s: Sequence[float]) -> int | None:
    """Index of the earliest contact; None if there is none."""
    times = np.asarray(contact_time_s)
    return None if np.isnan(times).all() else int(np.nanargmin(times))
