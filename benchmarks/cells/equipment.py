"""The detector as it comes with a phone: given what a phone knows of itself, and no more."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from benchmarks.cells.detectors import build_detector, paper_settings, parse_detector, standing_form
from benchmarks.cells.situations.situation import Situation
from benchmarks.cells.situations.variation import air_of, changed_walk
from benchmarks.cells.spec import BeepSetting, Cell, WalkChange
from obstaclewatch import BeepDesign
from obstaclewatch.signal.direct_sound import measured_direct_delay_s
from obstaclewatch.sound_speed import assumed_sound_speed
from scenes import GaitWalk, load_encounter
from simulator import Air, Phone, Scene, StraightWalk, render_walk
from simulator.scene.pose import Walk

STREAM = (4, 2)
"""Of a walk's seed, for what was measured on another day; see `benchmarks.plan.unknowns`."""
FROM_DAY_TO_DAY = 0.03
"""Relative deviation of a person's walk ratio from one test to the next: 2.1 % each of step length and cadence (40
people, standard errors of measurement, jkema.org 9-2-208, table 1)."""


def detector_for(cell: Cell, name: str, setting: Situation, beep: BeepDesign) -> Any:
    """A detector of that name for the cell's phone, in its standing form for a phone held still.

    Raises:
        ValueError: there is no such detector, or a setting is unknown or out of range.
    """
    delay = {"direct_delay_s": _direct_delay_s(cell, setting)} if cell.knowledge.direct_delay else {}
    settings = paper_settings(delay | cell.settings)
    pitch = mean_pitch_rad(setting.walk) if cell.knowledge.pitch else None
    if pitch is not None:
        pitch += cell.knowledge.pitch_error_rad
    known = {
        "sound_speed_m_s": _sound_speed_m_s(cell, setting.scene.air),
        "walk_ratio_m_min": _walk_ratio_m_min(cell, setting.walk),
    }
    given = {name: value for name, value in known.items() if value is not None}
    return build_detector(_built_as(cell, name), beep, setting.phone.geometry, settings, pitch, given)


BUILT_FROM = {"kind", "detectors", "detector_sources", "phone", "beep", "settings", "knowledge", "air", "walk"}
"""What of a cell decides whether its detectors can be built; of a scene file's walk its `approach` as well."""


def equipment_key(cell: Cell) -> str:
    """The same text for cells whose detectors are built alike, but for what their own walks add."""
    return cell.model_dump_json(include={*BUILT_FROM, "approach"} if cell.kind == "scene" else BUILT_FROM)


def check_equipment(cell: Cell) -> None:
    """Build each detector of a cell once, so that its own rules judge its values before anything is rendered.

    What only a rendered or a drawn walk tells is left out: the direct sound is that of the air path, and where neither
    the cell nor a scene file says how the phone is pitched, it is level.

    Raises:
        ValueError: a value that a detector refuses, or a detector of a user's own that cannot be built at all.
    """
    phone, air, pitch_rad = _phone_air_and_pitch(cell)
    beep, settings, knowledge = cell.beep.design(), paper_settings(cell.settings), cell.knowledge
    pitch = pitch_rad + knowledge.pitch_error_rad if knowledge.pitch else None
    sound_speed_m_s = _sound_speed_m_s(cell, air)
    given = {} if sound_speed_m_s is None else {"sound_speed_m_s": sound_speed_m_s}
    for name in cell.detectors:
        try:
            build_detector(_built_as(cell, name), beep, phone.geometry, settings, pitch, given)
        except (Exception, SystemExit) as error:
            if isinstance(error, ValueError) or not parse_detector(name).module:
                raise
            said = f"{type(error).__name__}: {error}"  # a user's class may do anything
            raise ValueError(f"detector '{name}' cannot be made: {said}") from error


def _asked_pitch_rad(walk: WalkChange) -> float:
    """Of the phone's top edge, which is to the left and so level in a phone held horizontally."""
    return 0.0 if walk.pitch_rad is None or walk.holding == "horizontal" else walk.pitch_rad


def _built_as(cell: Cell, name: str) -> str:
    return standing_form(name) if cell.kind == "standing" else name


def _phone_air_and_pitch(cell: Cell) -> tuple[Phone, Air, float]:
    if cell.kind != "scene":
        return Phone.named(cell.phone), air_of(cell), _asked_pitch_rad(cell.walk)
    met = load_encounter(str(cell.approach["file"]), cell.seed, cell.approach["phone"])
    walk = changed_walk(met.walk, cell.walk, cell.beep.period_s)
    return met.phone, air_of(cell) if cell.air else met.scene.air, mean_pitch_rad(walk)


def _sound_speed_m_s(cell: Cell, air: Air) -> float | None:
    """What the weather makes the detector assume, by a formula of its own; None if it is not given.

    Air whose speed a scene fixes has no weather: that speed is given.
    """
    if not cell.knowledge.air:
        return None
    if air.fixed_sound_speed_m_s is not None:
        return air.fixed_sound_speed_m_s
    error_c = cell.knowledge.temperature_error_c
    try:
        return assumed_sound_speed(air.temperature_c + error_c, air.relative_humidity, air.pressure_pa)
    except ValueError as error:
        raise ValueError(f"knowledge.temperature_error_c of {error_c:g} and air at {air.temperature_c:g} C give what "
                         f"detectors cannot assume: {error}") from error  # fmt: skip


def _walk_ratio_m_min(cell: Cell, walk: Walk) -> float | None:
    """What the walker measured of their steps on another day; None if it is not given, or there are no steps."""
    own = walk.walk_ratio_m_min if cell.knowledge.walk_ratio and isinstance(walk, GaitWalk) else None
    if own is None:
        return None
    rng = np.random.default_rng(np.random.SeedSequence(cell.seed, spawn_key=STREAM))
    return own * (1.0 + FROM_DAY_TO_DAY * float(rng.standard_normal()))


def _direct_delay_s(cell: Cell, setting: Situation) -> float:
    """That of the preset which the cell names; a scene file may bring a phone of its own."""
    return phone_delay_s(setting.phone, cell.beep) if cell.kind == "scene" else direct_delay_s(cell.phone, cell.beep)


@lru_cache(maxsize=32)
def direct_delay_s(phone_name: str, beep: BeepSetting) -> float:
    """Delay of the direct peak at microphone 0 after emission, for a preset."""
    return phone_delay_s(Phone.named(phone_name), beep)


def phone_delay_s(phone: Phone, beep: BeepSetting) -> float:
    """Delay of the direct peak at microphone 0 after emission: the phone alone in free space, without noise."""
    alone = replace(phone, noise_spl_db=-np.inf, body=None)
    design = beep.design()
    still = StraightWalk(np.zeros(3), heading_rad=0.0, speed_m_s=0.0, duration_s=design.period_s)
    recording = render_walk(Scene(()), alone, still, design)
    return measured_direct_delay_s(recording.samples, design)


def mean_pitch_rad(walk: Walk) -> float:
    """Mean pitch of the phone's top edge over a walk."""
    pose = walk.pose(np.linspace(0.0, walk.duration_s, 101))
    edge = pose.to_world([0.0, 1.0, 0.0]) - pose.to_world([0.0, 0.0, 0.0])
    return float(np.arcsin(np.clip(edge[:, 2], -1.0, 1.0)).mean())
