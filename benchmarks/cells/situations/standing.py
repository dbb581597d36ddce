"""A phone held still in front of one obstacle at a set distance, with a wall beside it (paper section 4.6)."""

from __future__ import annotations

import numpy as np

from benchmarks.cells.situations.situation import Situation
from benchmarks.cells.spec import Cell
from scenes import GaitWalk, walker_body
from scenes.obstacles import ground, random_obstacle, wall
from scenes.streets.placing import placed
from simulator import Material, Obstacle, Phone, Scene

PHONE_HEIGHT_M = 1.3
BEEPS = 12
SIDE_WALL_M = 2.2  # the second obstacle: a wall along the path, so that several obstacles echo


def standing_situation(cell: Cell) -> Situation:
    """The obstacle at the cell's bearing, straight ahead by default, its front at the cell's distance from the phone.

    Raises:
        ValueError: no distance, an unknown category or phone.
    """
    if cell.range_m is None:
        raise ValueError("a standing measurement must have range_m, got none")
    rng = np.random.default_rng(np.random.SeedSequence(cell.seed, spawn_key=(cell.index,)))
    drawn = random_obstacle(cell.category, rng, "target")
    turned = placed(drawn, (0.0, 0.0), float(rng.uniform(-0.1, 0.1)), velocity_m_s=(0.0, 0.0, 0.0))
    front = float(np.asarray(turned.mesh.vertices)[:, 0].min())
    ahead = placed(turned, (cell.range_m - front, float(rng.uniform(-0.1, 0.1))))
    target = placed(ahead, (0.0, 0.0), cell.bearing_rad)
    side = placed(
        Obstacle(wall(6.0, 3.0), Material.named("concrete"), "side wall", category="wall"),
        (3.0, -SIDE_WALL_M if cell.bearing_rad > 0.0 else SIDE_WALL_M),  # away from the target
        np.pi / 2,
    )
    floor = Obstacle(ground(), Material.named("asphalt"), "ground", category="ground")
    pitch = float(rng.normal(np.deg2rad(30.0), np.deg2rad(4.0)))
    start = np.array([0.0, 0.0, PHONE_HEIGHT_M])
    walk = GaitWalk(start, speed_m_s=0.0, duration_s=BEEPS * cell.beep.period_s, pitch_rad=pitch)
    phone = Phone.named(cell.phone).held_by(walker_body(phone_height_m=PHONE_HEIGHT_M))
    scene = Scene([floor, target, side], name="standing")
    return Situation(scene, walk, phone, ("target",))
