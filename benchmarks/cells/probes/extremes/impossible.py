"""Scenes that cannot be: each must be refused with an error that says why."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from benchmarks.cells.probes.extremes.mirrors import AHEAD, MICS_M, SPEAKER_M, echoes, slab, wall
from benchmarks.cells.probes.extremes.verdict import Errors, Refusal, must_refuse
from obstaclewatch import BeepDesign
from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, StraightWalk, render_walk

HERE = Pose(np.zeros(3), AHEAD)


def impossible(case: str) -> Errors | Refusal:
    """Build and trace one; whoever comes back has been taken for possible."""
    build, *named = CASES[case]
    return must_refuse(build, *named)


def _traced(*obstacles: Obstacle) -> None:
    echoes(obstacles, HERE, 5.0)


def _walked(obstacle: Obstacle, speed_m_s: float = 1.0) -> None:
    scene = Scene([obstacle], Air.lossless())
    walk = StraightWalk(np.zeros(3), 0.0, speed_m_s, 2.0)
    render_walk(scene, Phone.ideal(SPEAKER_M, MICS_M), walk, BeepDesign(), Fidelity(mechanisms=("specular",)))


def _box(half_m: float, x_m: float = 0.0, velocity_m_s: ArrayLike = (0, 0, 0)) -> Obstacle:
    return slab([x_m - half_m, -half_m, -half_m], [x_m + half_m, half_m, half_m], "box", velocity_m_s)


def _sheet() -> Obstacle:
    """Across the phone, between speaker and microphone 0, open on both sides."""
    square = np.array([[0.055, -1.0, -1.0], [0.055, 1.0, -1.0], [0.055, 1.0, 1.0], [0.055, -1.0, 1.0]])
    mesh = trimesh.Trimesh(square, [[0, 1, 2], [0, 2, 3]], process=False)
    return Obstacle(mesh, Material.rigid(), "sheet")


def _mesh(vertices: ArrayLike, faces: ArrayLike) -> None:
    _traced(Obstacle(trimesh.Trimesh(vertices, faces, process=False), Material.rigid(), "mesh"))


TRIANGLE = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 1.0]]
INSIDE = "the phone must be outside of all closed bodies, got "
CASES: dict[str, tuple[Callable[[], object], str] | tuple[Callable[[], object], str, str]] = {
    "phone inside a box": (lambda: _traced(_box(0.5)), INSIDE, "inside 'box' at pose 0"),
    "phone in a small box": (lambda: _traced(_box(0.09)), INSIDE, "inside 'box' at pose 0"),
    "speaker in a wall": (lambda: _traced(slab([0.03, -1, -1], [0.05, 1, 1])), INSIDE, "the speaker inside 'wall'"),
    "microphone in a wall": (lambda: _traced(wall(0.06)), INSIDE, "microphone 0 inside 'wall'"),
    "sheet through the phone": (lambda: _traced(_sheet()), "got 'sheet' between the speaker and microphone 0"),
    "walk into a wall": (lambda: _walked(wall(1.0)), INSIDE, "inside 'wall' at pose 11"),
    "wall driven through the phone": (lambda: _walked(_box(0.2, 1.0, (-1, 0, 0)), 0.0), INSIDE, "inside 'box'"),
    "infinite vertex": (
        lambda: _mesh([[1.0, 0.0, 0.0], [1.0, np.inf, 0.0], [1.0, 0.0, 1.0]], [[0, 1, 2]]),
        "mesh of 'mesh' must have finite vertices, got 1 of 3",
    ),
    "no triangles": (lambda: _mesh(TRIANGLE, np.zeros((0, 3), dtype=int)), "mesh of 'mesh' must have triangles"),
    "two obstacles of a name": (lambda: _traced(wall(1.0), wall(2.0)), "must be unique, got ['wall']"),
    "infinite place": (lambda: echoes([wall(1.0)], Pose(np.array([np.inf, 0.0, 0.0]), AHEAD), 5.0), "got [inf"),
    "infinite speed": (lambda: _walked(wall(1.0), np.inf), "speed_m_s must be finite", "got inf"),
    "speed of sound of zero": (
        lambda: echoes([wall(1.0)], HERE, 5.0, air=Air.lossless(0.0)), "fixed_sound_speed_m_s must", "got 0.0",
    ),
    "air of -100 degrees": (lambda: Air(temperature_c=-100.0), "temperature_c must", "got -100.0"),
    "air of 20 times its vapour": (lambda: Air(relative_humidity=20.0), "relative_humidity must", "got 20.0"),
    "pressure of nothing": (lambda: Air(pressure_pa=0.0), "pressure_pa must", "got 0.0"),
}  # fmt: skip
"""What cannot be: how it is made, and what its error must say."""
