"""Scenes that cannot be: each must be refused with an error that says why."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from benchmarks.cells.probes.extremes.mirrors import AHEAD, MICS_M, SPEAKER_M, echoes, slab, wall
from benchmarks.cells.probes.extremes.verdict import Errors, accepted
from obstaclewatch import BeepDesign
from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, StraightWalk, render_walk

HERE = Pose(np.zeros(3), AHEAD)


def impossible(case: str) -> Errors:
    """Build and trace one; whoever comes back has been taken for possible."""
    CASES[case]()
    return accepted()


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
CASES: dict[str, Callable[[], None]] = {
    "phone inside a box": lambda: _traced(_box(0.5)),
    "phone in a small box": lambda: _traced(_box(0.09)),
    "speaker in a wall": lambda: _traced(slab([0.03, -1, -1], [0.05, 1, 1])),
    "microphone in a wall": lambda: _traced(wall(0.06)),
    "sheet through the phone": lambda: _traced(_sheet()),
    "walk into a wall": lambda: _walked(wall(1.0)),
    "wall driven through the phone": lambda: _walked(_box(0.2, 1.0, (-1, 0, 0)), 0.0),
    "infinite vertex": lambda: _mesh([[1.0, 0.0, 0.0], [1.0, np.inf, 0.0], [1.0, 0.0, 1.0]], [[0, 1, 2]]),
    "no triangles": lambda: _mesh(TRIANGLE, np.zeros((0, 3), dtype=int)),
    "two obstacles of a name": lambda: _traced(wall(1.0), wall(2.0)),
    "infinite place": lambda: (echoes([wall(1.0)], Pose(np.array([np.inf, 0.0, 0.0]), AHEAD), 5.0), None)[1],
    "infinite speed": lambda: _walked(wall(1.0), np.inf),
    "speed of sound of zero": lambda: (echoes([wall(1.0)], HERE, 5.0, air=Air.lossless(0.0)), None)[1],
    "air of -100 degrees": lambda: (Air(temperature_c=-100.0), None)[1],
    "air of 20 times its vapour": lambda: (Air(relative_humidity=20.0), None)[1],
    "pressure of nothing": lambda: (Air(pressure_pa=0.0), None)[1],
}
