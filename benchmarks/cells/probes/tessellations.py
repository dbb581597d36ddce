"""What the segments of a round body cost and buy: echoes of cylinders and spheres against those of many segments.

The finest body stands for the round one: its echo is within 0.013 dB of the exact series (docs/accuracy.md).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh

from benchmarks.cells.probes.fidelities import compared, priced, timed_paths
from benchmarks.cells.spec import Cell
from simulator import Air, Material, Obstacle, Phone, Pose, Scene
from simulator.scene.pose import held_rotation

SEGMENTS = (8, 12, 16, 24, 32, 48)
FINEST = 192
HEIGHT_M = 1.3
POSES = 6
BODIES = ("cylinder", "sphere")


def segments_named(segments: int) -> str:
    """The name of a point."""
    return f"{segments} segments"


def tessellation_result(cell: Cell) -> dict[str, Any]:
    """Errors by number of segments as `result["fidelity"]`, shaped as `fidelities.fidelity_result` has them.

    The phone looks at the body from `POSES` directions, so that vertices, edges and faces all come to lie ahead.

    Raises:
        ValueError: an unknown body, or a radius or distance that is not positive.
    """
    pose, phone = _around(cell.seed, **cell.probe), Phone.named(cell.phone)
    time_s = np.zeros(POSES)

    def traced(segments: int) -> tuple[Any, float]:
        body = Obstacle(_mesh(cell.category, segments, **cell.probe), Material.rigid(), "body")
        rays = {"level": "standard", "tolerance_db": np.inf}  # Kirchhoff's integral cuts facets of its own
        return timed_paths(Scene([body], Air()), phone, pose, time_s, rays)

    exact, cost = traced(FINEST)
    found: dict[str, Any] = {"reference": {"level_db": [0.0] * (2 * POSES)}}
    costs = {"reference": cost}
    for segments in SEGMENTS:
        name = segments_named(segments)
        paths, costs[name] = traced(segments)
        found[name] = compared(paths, exact, "body")
    return priced(found, costs)


def _around(seed: int, radius_m: float, distance_m: float) -> Pose:
    """Phones that look at the body's middle from so far off its surface."""
    if not (radius_m > 0.0 and distance_m > 0.0):
        raise ValueError(f"radius_m and distance_m must be positive, got {radius_m} and {distance_m}")
    turn = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, POSES)
    away = np.stack([np.cos(turn), np.sin(turn), np.zeros(POSES)], axis=1)
    place = (radius_m + distance_m) * away + [0.0, 0.0, HEIGHT_M]
    return Pose(place, held_rotation(turn + np.pi, 0.5), turn + np.pi)


def _mesh(body: str, segments: int, radius_m: float, distance_m: float) -> trimesh.Trimesh:
    if body not in BODIES:
        raise ValueError(f"a tessellation probe must be one of {BODIES}, got '{body}'")
    if body == "cylinder":
        mesh = trimesh.creation.cylinder(radius=radius_m, height=2.0, sections=segments)
        mesh.apply_translation([0.0, 0.0, 1.0])
    else:
        mesh = trimesh.creation.uv_sphere(radius=radius_m, count=[segments // 2, segments])
        mesh.apply_translation([0.0, 0.0, HEIGHT_M])
    return mesh
