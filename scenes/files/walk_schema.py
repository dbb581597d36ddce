"""The walk and the phone of a scene file, and what they become."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, field_validator, model_validator

from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.support.arrays import Floats
from scenes.files.field_types import FARTHEST_PLAN_M, Length, NotNegative, Number, Plan, Positive, Strict
from scenes.obstacles import walker_body
from scenes.walks.gait_walk import Gait, GaitWalk, Holding
from scenes.walks.routes import Pace, Route, RouteWalk, Stop, time_to_walk
from simulator.phone.phone import Phone
from simulator.phone.presets import list_phones
from simulator.phone.transducers import StructureBorne
from simulator.render import LONGEST_S

Point = tuple[Number, Number, Number]
STRAIGHT_S = 4.0
"""How long a straight walk lasts if the file does not say."""
FASTEST_M_S = 100.0
PHONE_M = 0.05, 1.0
"""Least and greatest distance of a phone's microphones. From watches to tablets: 150 is in millimetres."""
CLOSEST_M = 1e-3
"""From the speaker to a microphone: the sound that passes between them grows without bound as they meet."""
Time = Annotated[Number, Field(ge=-LONGEST_S, le=LONGEST_S)]
Speed = Annotated[NotNegative, Field(le=FASTEST_M_S)]


class ArcSpec(Strict):
    """A turn of so many degrees, positive to the left."""

    radius_m: Length
    turn_deg: Annotated[Number, Field(ge=-360.0, le=360.0)]


class StopSpec(Strict):
    """A pause."""

    at_s: Time
    for_s: Annotated[Positive, Field(le=LONGEST_S)]


class WalkerSpec(Strict):
    """The body behind the phone."""

    stature_m: Positive = 1.75
    girth: Positive = 1.0
    phone_distance_m: Positive = 0.35


class VarySpec(Strict):
    """Half ranges, drawn evenly by the seed of a run; the phase of the step is drawn with them."""

    lateral_m: Annotated[NotNegative, Field(le=FARTHEST_PLAN_M)] = 0.0
    heading_deg: Annotated[NotNegative, Field(le=360.0)] = 0.0
    speed_m_s: NotNegative = 0.0


class WalkSpec(Strict):
    """A straight walk, one along waypoints, or one along an arc; with or without stops."""

    start_m: Plan | None = None
    heading_deg: Number | None = None
    waypoints_m: tuple[Plan, ...] | None = None
    rounding_m: Length = 0.8
    arc: ArcSpec | None = None
    stops: tuple[StopSpec, ...] = ()
    speed_m_s: Speed = 1.3
    duration_s: Positive | None = None
    height_m: Positive = 1.3
    pitch_deg: Annotated[Number, Field(ge=-90.0, le=90.0)] = 30.0
    roll_deg: Annotated[Number, Field(ge=-180.0, le=180.0)] = 0.0
    holding: Holding = "vertical"
    gait: Literal["natural", "none"] = "natural"
    walker: WalkerSpec = WalkerSpec()
    vary: VarySpec | None = None

    @model_validator(mode="after")
    def _one_route(self) -> WalkSpec:
        placed = self.start_m is not None or self.heading_deg is not None or self.arc is not None
        if self.waypoints_m is not None and placed:
            raise ValueError("a walk with waypoints_m must have no start_m, heading_deg or arc")
        # Counted here: pydantic counts only the points that it accepted, and would name a second mistake.
        if self.waypoints_m is not None and len(self.waypoints_m) < 2:
            raise ValueError(f"waypoints_m must be at least two points, got {list(self.waypoints_m)}")
        if self.vary is not None and 0.0 < self.vary.speed_m_s >= self.speed_m_s:
            raise ValueError(f"vary must leave the speed {self.speed_m_s:g} positive, got {self.vary.speed_m_s:g}")
        return self


class PhoneSpec(Strict):
    """A preset, changed where the file says so.

    With `length_m` the microphones sit at the ends of the middle line and the speaker as far below the top one as in
    the preset; `speaker_m` and `mics_m` place them in the phone frame. The microphones are 5 cm to 1 m apart, the
    speaker 1 mm to 1 m from each.
    """

    preset: str = "galaxy-s5"
    name: str | None = None
    length_m: Annotated[Number, Field(ge=PHONE_M[0], le=PHONE_M[1])] | None = None
    speaker_m: Point | None = None
    mics_m: tuple[Point, Point] | None = None
    level_spl_db: Number | None = None
    noise_spl_db: Number | None = None

    @field_validator("preset")
    @classmethod
    def _known(cls, preset: str) -> str:
        Phone.named(preset)
        return preset

    @model_validator(mode="after")
    def _one_geometry(self) -> PhoneSpec:
        if (self.speaker_m is None) != (self.mics_m is None):
            raise ValueError(f"speaker_m and mics_m must both be given; presets are {list_phones()}")
        if self.length_m is not None and self.mics_m is not None:
            raise ValueError("a phone must have either length_m or speaker_m and mics_m, got both")
        if self.speaker_m is not None and self.mics_m is not None:
            _check_phone(PhoneGeometry("", np.array(self.speaker_m), np.array(self.mics_m)))
        return self


def _check_phone(geometry: PhoneGeometry) -> None:
    """Refuse millimetres given for metres, and a speaker in a microphone.

    Raises:
        ValueError: the message gives field, rule and value.
    """
    apart, near, far = geometry.mic_separation_m, geometry.speaker_to_mic_m.min(), geometry.speaker_to_mic_m.max()
    if not PHONE_M[0] <= apart <= PHONE_M[1]:
        raise ValueError(f"mics_m must be {PHONE_M[0]:g} to {PHONE_M[1]:g} m apart, got {apart:g} m")
    if not (near >= CLOSEST_M and far <= PHONE_M[1]):
        raise ValueError(
            f"speaker_m must be {CLOSEST_M:g} to {PHONE_M[1]:g} m from each microphone, got {near:g} and {far:g} m"
        )


class Drawn(NamedTuple):
    """What a seed changes about a walk."""

    left_m: float = 0.0
    turn_rad: float = 0.0
    faster_m_s: float = 0.0
    phase_rad: float = 0.0


def walk_of(spec: WalkSpec, seed: int) -> GaitWalk | RouteWalk:
    """The walk of a file; a seed changes it only within what `vary` allows.

    Raises:
        ValueError: a route or stops that cannot be walked.
    """
    drawn = _drawn(spec.vary, seed)
    speed = spec.speed_m_s + drawn.faster_m_s
    gait = Gait() if spec.gait == "none" else Gait.at_speed(speed, drawn.phase_rad)
    route = _route(spec, speed)
    walk = _straight(spec, speed, gait, drawn) if route is None else _routed(spec, route, speed, gait, drawn)
    if walk.duration_s > LONGEST_S:
        raise ValueError(f"a walk must last at most {LONGEST_S:g} s, got {walk.duration_s:.3g} s")
    return walk


def _straight(spec: WalkSpec, speed_m_s: float, gait: Gait, drawn: Drawn) -> GaitWalk:
    start = _moved(np.array([spec.start_m or (0.0, 0.0)]), _heading(spec), drawn)[0]
    return GaitWalk(
        np.append(start, spec.height_m), _heading(spec) + drawn.turn_rad, speed_m_s, spec.duration_s or STRAIGHT_S,
        np.deg2rad(spec.pitch_deg), np.deg2rad(spec.roll_deg), gait, spec.holding,
    )  # fmt: skip


def _routed(spec: WalkSpec, route: Route, speed_m_s: float, gait: Gait, drawn: Drawn) -> RouteWalk:
    first = np.diff(route.waypoints_m[:2], axis=0)[0]
    route = Route(_moved(route.waypoints_m, float(np.arctan2(first[1], first[0])), drawn), route.rounding_m)
    pace = Pace(speed_m_s, [Stop(stop.at_s, stop.for_s) for stop in spec.stops])
    duration = time_to_walk(route, pace) if spec.duration_s is None else spec.duration_s
    return RouteWalk(
        route, pace, duration, spec.height_m,
        np.deg2rad(spec.pitch_deg), np.deg2rad(spec.roll_deg), gait, spec.holding,
    )  # fmt: skip


def _drawn(vary: VarySpec | None, seed: int) -> Drawn:
    if vary is None:
        return Drawn()
    rng = np.random.default_rng(np.random.SeedSequence(seed))
    ranges = vary.lateral_m, np.deg2rad(vary.heading_deg), vary.speed_m_s
    left, turn, faster = (float(half * rng.uniform(-1.0, 1.0)) for half in ranges)
    return Drawn(left, turn, faster, float(rng.uniform(0.0, 4.0 * np.pi)))


def _heading(spec: WalkSpec) -> float:
    return float(np.deg2rad(spec.heading_deg or 0.0))


def _route(spec: WalkSpec, speed_m_s: float) -> Route | None:
    """The route of a walk that is not simply straight."""
    if spec.waypoints_m is not None:
        return Route(np.array(spec.waypoints_m), spec.rounding_m)
    start = np.array(spec.start_m or (0.0, 0.0))
    if spec.arc is not None:
        return Route.arc(start, _heading(spec), spec.arc.radius_m, np.deg2rad(spec.arc.turn_deg))
    if not spec.stops:
        return None
    reach = max(1.0, speed_m_s * (spec.duration_s or STRAIGHT_S))
    return Route(np.stack([start, start + reach * np.array([np.cos(_heading(spec)), np.sin(_heading(spec))])]))


def _moved(points_m: Floats, heading_rad: float, drawn: Drawn) -> Floats:
    """Points shifted to the left of a heading, then rotated about the first of them."""
    shifted = points_m + drawn.left_m * np.array([-np.sin(heading_rad), np.cos(heading_rad)])
    cos, sin = np.cos(drawn.turn_rad), np.sin(drawn.turn_rad)
    moved: Floats = (shifted - shifted[0]) @ np.array([[cos, sin], [-sin, cos]]) + shifted[0]
    return moved


def phone_of(spec: PhoneSpec, walk: WalkSpec) -> Phone:
    """The phone of a file in the hands of its walker.

    Raises:
        ValueError: a walker or a geometry out of range.
    """
    phone = Phone.named(spec.preset)
    phone = replace(
        phone,
        level_spl_db=phone.level_spl_db if spec.level_spl_db is None else spec.level_spl_db,
        noise_spl_db=phone.noise_spl_db if spec.noise_spl_db is None else spec.noise_spl_db,
    )
    if spec.length_m is not None or spec.mics_m is not None:
        phone = _rebuilt(phone, _geometry(spec, phone.geometry))
    elif spec.name is not None:
        phone = replace(phone, geometry=replace(phone.geometry, name=spec.name))
    who = walk.walker
    return phone.held_by(walker_body(who.phone_distance_m, walk.height_m, who.stature_m, who.girth))


def _geometry(spec: PhoneSpec, base: PhoneGeometry) -> PhoneGeometry:
    name = spec.name or f"changed {base.name}"
    if spec.mics_m is not None and spec.speaker_m is not None:
        return PhoneGeometry(name, np.array(spec.speaker_m), np.array(spec.mics_m))
    end = np.array([0.0, 0.5 * float(spec.length_m or 0.0), 0.0])
    return PhoneGeometry(name, end + base.speaker_m - base.mics_m[0], np.stack([end, -end]))


def _rebuilt(phone: Phone, geometry: PhoneGeometry) -> Phone:
    """The same transducers elsewhere; sound through the case takes longer and is weaker, as its path is longer."""
    case = phone.structure_borne
    if case is not None:
        stretch = geometry.speaker_to_mic_m / phone.geometry.speaker_to_mic_m
        case = StructureBorne(case.delay_s * stretch, case.gain / stretch)
    return replace(phone, geometry=geometry, structure_borne=case)
