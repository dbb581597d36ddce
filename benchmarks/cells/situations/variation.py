"""What a cell changes about a situation that was drawn: the air, how the phone is held and walks, its levels."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np

from benchmarks.cells.situations.situation import Situation, until_contact
from benchmarks.cells.spec import Cell, PhoneChange, SceneChange, WalkChange, check_known
from scenes import Gait, GaitWalk, RouteWalk
from simulator import Air, Material, Obstacle, Phone, Scene
from simulator.phone.transducers import Transducer
from simulator.scene.pose import Walk


def varied(setting: Situation, cell: Cell) -> Situation:
    """The situation with the cell's changes.

    Raises:
        ValueError: a change that the walk does not know, or a number out of range.
    """
    scene = changed_scene(setting, cell.scene_change)
    scene = replace(scene, air=air_of(cell)) if cell.air else scene
    walk = changed_walk(setting.walk, cell.walk, cell.beep.period_s)
    if walk is not setting.walk:
        walk = until_contact(walk, scene, setting.targets)
    phone = changed_phone(setting.phone, cell.phone_change)
    return replace(setting, scene=scene, walk=walk, phone=phone, gated=_gated(scene, cell.scene_change))


def air_of(cell: Cell) -> Air:
    """The cell's air.

    Raises:
        ValueError: an unknown name or a number out of range.
    """
    check_known("air", cell.air, [each.name for each in fields(Air)])
    return Air(**cell.air)


def changed_scene(setting: Situation, change: SceneChange) -> Scene:
    """The scene with other materials, or with nothing but ground and targets.

    Raises:
        ValueError: an unknown material.
    """
    if change == SceneChange():
        return setting.scene
    kept = [o for o in setting.scene.obstacles if change.surroundings or _stays(o, setting.targets)]
    return replace(setting.scene, obstacles=tuple(_of_material(o, change, setting.targets) for o in kept))


def changed_walk(walk: Walk, change: WalkChange, period_s: float) -> Walk:
    """The walk with another speed, pitch, gait or holding; its path stays as long, or up to two beeps longer.

    Raises:
        ValueError: the walk is not a straight one with gait; a route takes another holding alone.
    """
    if change == WalkChange():
        return walk
    if isinstance(walk, RouteWalk) and change.holding and change == WalkChange(holding=change.holding):
        return replace(walk, holding=change.holding)
    if isinstance(walk, GaitWalk):
        return replace(walk, **_gait_fields(walk, change, period_s))
    raise ValueError(f"walk changes need a straight walk with gait, got {type(walk).__name__}")


def changed_phone(phone: Phone, change: PhoneChange) -> Phone:
    """The phone with other levels or microphones, or without the walker's body behind it."""
    louder = replace(phone, **change.model_dump(exclude={"body", "mic_level_db"}, exclude_none=True))
    first, second = (_louder(mic, level) for mic, level in zip(phone.mics, change.mic_level_db, strict=True))
    better = replace(louder, mics=(first, second))
    return better if change.body else better.held_by(None)


def _louder(mic: Transducer, level_db: float) -> Transducer:
    return mic if level_db == 0.0 else replace(mic, response_db=mic.response_db + level_db)


def _gated(scene: Scene, change: SceneChange) -> tuple[str, ...]:
    return () if change.ground_echo else tuple(o.name for o in scene.obstacles if o.category == "ground")


def _stays(obstacle: Obstacle, targets: tuple[str, ...]) -> bool:
    return obstacle.category == "ground" or obstacle.name in targets


def _of_material(obstacle: Obstacle, change: SceneChange, targets: tuple[str, ...]) -> Obstacle:
    name = change.target_material if obstacle.name in targets else None
    name = change.ground_material if obstacle.category == "ground" else name
    material = obstacle.material if name is None else Material.named(name)
    if obstacle.category == "pedestrian" and change.person_level_db != 0.0:
        material = _louder_material(material, change.person_level_db)
    return obstacle if material is obstacle.material else replace(obstacle, material=material)


def _louder_material(material: Material, level_db: float) -> Material:
    """A material that reflects so much more, but never more than all."""
    wanted = np.array(material.normal_reflection) * 10.0 ** (level_db / 20.0)
    return replace(material, normal_reflection=tuple(wanted / np.maximum(np.abs(wanted), 1.0)))


def _gait_fields(walk: GaitWalk, change: WalkChange, period_s: float) -> dict[str, Any]:
    fields: dict[str, Any] = change.model_dump(include={"pitch_rad", "roll_rad", "holding"}, exclude_none=True)
    gait = walk.motion
    speed_m_s = walk.speed_m_s if change.speed_m_s is None else change.speed_m_s
    if walk.speed_m_s > 0.0 and (change.speed_m_s is not None or change.gait_scale != 1.0):
        # one beep more than the path takes: another gait oscillates otherwise, and contact must not fall off the end
        beeps = 1 + math.ceil(walk.duration_s * walk.speed_m_s / speed_m_s / period_s - 1e-9)
        fields |= {"speed_m_s": speed_m_s, "duration_s": beeps * period_s}
    if change.speed_m_s is not None and walk.walk_ratio_m_min is not None:
        gait = Gait.at_speed(speed_m_s, gait.phase_rad, walk.walk_ratio_m_min)
    amplitudes = ("bob_m", "sway_m", "fore_aft_m", "pitch_wobble_rad", "roll_wobble_rad")
    return fields | {"gait": replace(gait, **{name: change.gait_scale * getattr(gait, name) for name in amplitudes})}
