"""Walks along routes of waypoints, with stops: curved, and stop-and-go.

Both the corners of a route and the stops of a pace are rounded by the same bell: a quantity that would jump from one
constant rate to another changes over a window, and all derivatives up to the third stay continuous in time, so that
delays can be followed inside a beep.

The paper's participants walk straight at obstacles (section 4.1), and so do all approaches of `streets.approaches`, the
phone held vertically; routes, stops and the horizontal holding are for scenes of one's own and for what-if suites.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from obstaclewatch.support.argument_types import as_floats, as_number, as_several, check_types, hold_numbers
from obstaclewatch.support.arrays import Floats
from scenes.walks.gait_walk import Gait, Holding, check_holding, grip
from simulator.scene.pose import Pose
from simulator.scene.walk_checks import hold_held, times_of

SHARPEST_RAD = float(np.deg2rad(150.0))
"""Greatest turn at one waypoint: at a hairpin the walker would come to a stand and face nowhere."""

STEPS_TO_STOP = 2.0
"""People start and stop within about two steps at any speed (Miff et al. 2005, J. Rehabil. Res. Dev. 42:175)."""


def rounded_step(x: Floats, half_window: float) -> Floats:
    """0 before -half_window, 1 after +half_window, and the integral of a raised cosine in between."""
    u = np.clip(x / half_window, -1.0, 1.0)
    return 0.5 * (1.0 + u + np.sin(np.pi * u) / np.pi)


def rounded_ramp(x: Floats, half_window: float) -> Floats:
    """The integral of `rounded_step`: 0 before the window, x after it."""
    u = np.clip(x / half_window, -1.0, 1.0)
    inside = 0.5 * half_window * (0.5 * (1.0 + u) ** 2 - (1.0 + np.cos(np.pi * u)) / np.pi**2)
    return inside + np.maximum(x - half_window, 0.0)


@dataclass(frozen=True)
class Route:
    """A polyline in plan with rounded corners.

    Attributes:
        waypoints_m: (K, 2) at least two, in plan. The route begins at the first and ends at the last; the others are
            cut at 0.15 x rounding x 2 sin(turn / 2): by 0.21 m at a right angle of 1 m.
        rounding_m: the turn at a waypoint begins this far before it and ends this far behind.

    Raises:
        ValueError: fewer than two waypoints, segments shorter than twice the rounding, a turn of more than 150 degrees.

    Example:
        >>> import numpy as np
        >>> from scenes import Route
        >>> corner = Route([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]])
        >>> corner.length_m, np.rad2deg(corner.heading_rad([4.0, 7.0])).round(1)
        (7.0, array([45., 90.]))
    """

    waypoints_m: Floats
    rounding_m: float = 0.8

    def __post_init__(self) -> None:
        points = as_floats("waypoints_m", self.waypoints_m)
        hold_numbers(self, "rounding_m")
        if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2 or not np.isfinite(points).all():
            raise ValueError(f"waypoints_m must be at least two finite points (x, y), got {self.waypoints_m}")
        points.setflags(write=False)
        object.__setattr__(self, "waypoints_m", points)
        if not 0.0 < self.rounding_m < np.inf:
            raise ValueError(f"rounding_m must be positive, got {self.rounding_m}")
        shortest = float(self._segment_m.min())
        if shortest == 0.0 or (len(points) > 2 and shortest < 2.0 * self.rounding_m * (1.0 - 1e-9)):
            raise ValueError(
                f"parts of a route must be at least twice rounding_m = {self.rounding_m:g}, got one of {shortest:g} m"
            )
        cosine = np.sum(self._direction[1:] * self._direction[:-1], axis=1)
        sharpest = float(np.arccos(np.clip(cosine, -1.0, 1.0)).max(initial=0.0))
        if sharpest > SHARPEST_RAD:
            raise ValueError(f"turns of a route must be below 150 degrees, got {np.rad2deg(sharpest):.0f}")

    @classmethod
    def arc(cls, start_m: ArrayLike, heading_rad: float, radius_m: float, turn_rad: float) -> Route:
        """About a circular arc: segments of at most 15 degrees whose rounded corners follow on each other.

        Args:
            start_m: (2,) where it begins.
            heading_rad: of its first segment.
            radius_m: of the arc.
            turn_rad: from the first segment to the last, positive to the left.
        """
        if not (0.0 < radius_m < np.inf and np.isfinite(turn_rad) and turn_rad != 0.0):
            raise ValueError(f"radius_m must be positive and turn_rad not 0, got {radius_m} and {turn_rad}")
        corners = max(1, int(np.ceil(abs(turn_rad) / np.deg2rad(15.0))))
        step = turn_rad / corners
        heading = heading_rad + step * np.arange(corners + 1)
        segment = abs(step) * radius_m * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        start = np.asarray(start_m, dtype=np.float64)
        points = start + np.concatenate([np.zeros((1, 2)), np.cumsum(segment, axis=0)])
        return cls(points, 0.5 * abs(step) * radius_m)

    @cached_property
    def _segment_m(self) -> Floats:
        return np.linalg.norm(np.diff(self.waypoints_m, axis=0), axis=1)

    @cached_property
    def _direction(self) -> Floats:
        return np.diff(self.waypoints_m, axis=0) / np.maximum(self._segment_m, 1e-300)[:, None]

    @property
    def length_m(self) -> float:
        """Length of the polyline, which is what distances along the route are counted on."""
        return float(self._segment_m.sum())

    def point(self, along_m: ArrayLike) -> Floats:
        """(N, 2) places at (N,) distances along the polyline; straight on before the start and beyond the end."""
        along = np.atleast_1d(np.asarray(along_m, dtype=np.float64))
        place = self.waypoints_m[0] + along[:, None] * self._direction[0]
        return place + rounded_ramp(self._past_corners(along), self.rounding_m) @ np.diff(self._direction, axis=0)

    def heading_rad(self, along_m: ArrayLike) -> Floats:
        """(N,) direction of travel there, counter-clockwise from +x."""
        along = np.atleast_1d(np.asarray(along_m, dtype=np.float64))
        turned = rounded_step(self._past_corners(along), self.rounding_m) @ np.diff(self._direction, axis=0)
        direction = self._direction[0] + turned
        return np.arctan2(direction[:, 1], direction[:, 0])

    def _past_corners(self, along_m: Floats) -> Floats:
        """(N, K - 2) distance beyond every corner."""
        return along_m[:, None] - np.cumsum(self._segment_m)[:-1]


class Stop(NamedTuple):
    """A pause: the speed falls around `at_s` and rises again around `at_s + for_s`.

    Example:
        >>> from scenes import Pace, Stop
        >>> Pace(1.2, stops=[Stop(at_s=3.0, for_s=2.5)]).stops
        (Stop(at_s=3.0, for_s=2.5),)
    """

    at_s: float
    for_s: float


def _stop(given: Any) -> Stop:
    """A stop from a pair of numbers."""
    pair = as_several("a stop", given)
    if len(pair) != 2:
        raise ValueError(f"a stop must be at_s and for_s, got {given!r}")
    return Stop(as_number("at_s of a stop", pair[0]), as_number("for_s of a stop", pair[1]))


@dataclass(frozen=True)
class Pace:
    """How fast one walks: at one speed, or with stops.

    Attributes:
        speed_m_s: when not stopping, positive.
        stops: in order of time; a stop at a negative time lets the walk begin at a stand.
        ramp_s: half the time it takes to stop or to start; None takes two steps in all.

    Raises:
        ValueError: a speed or ramp that is not positive, stops that are no pairs of numbers, overlap or are shorter
            than it takes to stop.

    Example:
        >>> import numpy as np
        >>> from scenes import Pace, Stop
        >>> pace = Pace(1.2, stops=[Stop(at_s=3.0, for_s=2.5)])
        >>> pace.distance(np.array([2.0, 8.5])).round(2), pace.speed(np.array([2.0, 4.2])).round(2)
        (array([2.4, 7.2]), array([1.2, 0. ]))
    """

    speed_m_s: float
    stops: Sequence[Stop] = ()
    ramp_s: float | None = None

    def __post_init__(self) -> None:
        hold_numbers(self, "speed_m_s")
        if not 0.0 < self.speed_m_s < np.inf:
            raise ValueError(f"speed_m_s of a pace must be positive, got {self.speed_m_s}")
        if self.ramp_s is not None:
            hold_numbers(self, "ramp_s")
        if not 0.0 < self.window_s < np.inf:
            raise ValueError(f"ramp_s must be positive, got {self.ramp_s}")
        object.__setattr__(self, "stops", tuple(map(_stop, as_several("stops", self.stops))))
        edges = np.array(self.stops).reshape(-1, 2).cumsum(axis=1).ravel()
        shortest = 2.0 * self.window_s
        if not np.isfinite(edges).all() or (np.diff(edges) < shortest * (1.0 - 1e-9)).any():
            raise ValueError(
                f"stops and the times between them must last at least {shortest:.2f} s, two steps, got {self.stops}"
            )

    @property
    def window_s(self) -> float:
        """Half the time it takes to stop or to start."""
        step_hz = Gait.at_speed(self.speed_m_s).step_hz
        return 0.5 * STEPS_TO_STOP / step_hz if self.ramp_s is None else self.ramp_s

    def distance(self, time_s: Floats) -> Floats:
        """(N,) distance walked, m, 0 at time 0 unless a stop reaches back to it."""
        return (
            self.speed_m_s * (time_s + self._changes(time_s) @ self._signs) if self.stops else self.speed_m_s * time_s
        )

    def speed(self, time_s: Floats) -> Floats:
        """(N,) speed, m/s."""
        lost = rounded_step(self._since(time_s), self.window_s) @ self._signs if self.stops else 0.0
        return self.speed_m_s * (np.ones_like(time_s) + lost)

    @property
    def _signs(self) -> Floats:
        return np.tile([-1.0, 1.0], len(self.stops))

    def _since(self, time_s: Floats) -> Floats:
        """(N, 2 S) time since every stop and every start."""
        return time_s[:, None] - np.array(self.stops).cumsum(axis=1).ravel()

    def _changes(self, time_s: Floats) -> Floats:
        """(N, 2 S) distance over speed that every stop and start has changed since time 0."""
        window = self.window_s
        return rounded_ramp(self._since(time_s), window) - rounded_ramp(self._since(np.zeros(1)), window)


@dataclass(frozen=True)
class RouteWalk:
    """A walk along a route at a pace, with gait.

    Steps keep their length: their phase follows the distance walked, and all wobble fades with the speed. In a corner
    the walker slows down, to cos(turn / 2) of the speed in its middle.

    Attributes:
        route: in plan.
        pace: distance walked over time.
        duration_s: length of the walk; `time_to_walk` gives that of the route, and it goes straight on after it.
        height_m: mean height of the phone over z = 0; negative where the ground lies below.
        pitch_rad, roll_rad, holding: see `scenes.walks.gait_walk.grip`.
        gait: motion around the mean path; None is the published one at the pace's speed, `Gait()` none at all.

    Raises:
        ValueError: a duration that is not positive, numbers that are not finite, another holding.

    Example:
        >>> from scenes import Pace, Route, RouteWalk
        >>> walk = RouteWalk(Route([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]]), Pace(1.3), duration_s=5.0)
        >>> walk.mean_plan_m([0.0, 5.0]).round(3)
        array([[0. , 0. ],
               [4. , 2.5]])
    """

    route: Route
    pace: Pace
    duration_s: float
    height_m: float = 1.3
    pitch_rad: float = float(np.deg2rad(30.0))
    roll_rad: float = 0.0
    gait: Gait | None = None
    holding: Holding = "vertical"

    def __post_init__(self) -> None:
        check_types(route=(self.route, Route), pace=(self.pace, Pace), gait=(self.gait, Gait | None))
        check_holding(self.holding)
        hold_held(self, "pitch_rad", "roll_rad")
        hold_numbers(self, "height_m")
        if not np.isfinite(self.height_m):
            raise ValueError(f"height_m must be finite, got {self.height_m}")

    @cached_property
    def motion(self) -> Gait:
        """The gait in use."""
        return Gait.at_speed(self.pace.speed_m_s) if self.gait is None else self.gait

    def mean_plan_m(self, time_s: ArrayLike) -> Floats:
        """(N, 2) places in plan without the gait."""
        return self.route.point(self.pace.distance(times_of(time_s)))

    def pose(self, time_s: ArrayLike) -> Pose:
        """(N,) times, s, to N poses; smooth in time, also before 0 and after the end."""
        time = times_of(time_s)
        gait, walked = self.motion, self.pace.distance(time)
        share = self.pace.speed(time) / self.pace.speed_m_s
        wobble = gait.wobble(2.0 * np.pi * gait.step_hz * walked / self.pace.speed_m_s + gait.phase_rad)
        heading = self.route.heading_rad(walked)
        cos, sin = np.cos(heading), np.sin(heading)
        ahead, left, up = (share * part for part in (wobble.ahead_m, wobble.left_m, wobble.up_m))
        offset = np.stack([cos * ahead - sin * left, sin * ahead + cos * left, up], axis=-1)
        mean = np.column_stack([self.route.point(walked), np.full(len(time), self.height_m)])
        pitch, roll = self.pitch_rad + share * wobble.pitch_rad, self.roll_rad + share * wobble.roll_rad
        return Pose(mean + offset, grip(heading, pitch, roll, self.holding), heading)


def time_to_walk(route: Route, pace: Pace) -> float:
    """When the end of a route is reached, s, stops included."""
    latest = route.length_m / pace.speed_m_s + sum(stop.for_s for stop in pace.stops) + 1.0
    return float(brentq(lambda t: pace.distance(np.array([t]))[0] - route.length_m, 0.0, latest, xtol=1e-9))
