"""What a scene will ask of the simulator: mirrors, smooth surfaces and sharp edges, obstacle by obstacle, and time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.beep import BeepDesign
from simulator.phone.phone import Phone
from simulator.render import render_walk
from simulator.scene.fidelity import Fidelity
from simulator.scene.pose import Pose, Walk
from simulator.scene.scene import Obstacle, Scene
from simulator.surfaces.reflectors import read_mesh, reflectors_in
from simulator.surfaces.wedges import wedges_of
from simulator.trace import trace_paths

Step = Callable[[], object]
TIMED_BEEPS = 4
TIMED_RENDERINGS = 3
"""The first of them compiles, the other two are timed."""
INSTANTS = 5


def _silent() -> None:
    """Shows no progress."""


@dataclass(frozen=True)
class Need:
    """What one obstacle is to the simulator.

    Attributes:
        name, category: of the obstacle.
        triangles: of its mesh.
        size_m: (3,) extents.
        closed: watertight and consistently wound, so that only its outside reflects.
        planes: mirrors, found by "specular".
        curved: facets of smooth surfaces, searched by "curved".
        edges: sharp edges that diffract, summed by "edges".
        moves: has a velocity, and so a shadow of its own.
    """

    name: str
    category: str
    triangles: int
    size_m: tuple[float, float, float]
    closed: bool
    planes: int
    curved: int
    edges: int
    moves: bool

    @property
    def mechanisms(self) -> tuple[str, ...]:
        """Those of `simulator.Fidelity` that the obstacle needs."""
        asked = {"specular": self.planes, "curved": self.curved, "edges": self.edges}
        return tuple(name for name, count in asked.items() if count)


@dataclass(frozen=True)
class Cost:
    """Time to render on this machine, by one processor.

    Attributes:
        prepare_s: once for a walk.
        per_beep_s: for every beep.
        beeps: of the walk.
    """

    prepare_s: float
    per_beep_s: float
    beeps: int

    @property
    def walk_s(self) -> float:
        """For the walk."""
        return self.prepare_s + self.beeps * self.per_beep_s


def needs_of(scene: Scene) -> list[Need]:
    """One entry an obstacle, in the scene's order."""
    return [_need(obstacle) for obstacle in scene.obstacles]


def _need(obstacle: Obstacle) -> Need:
    reading = read_mesh(obstacle)
    patches, surface = reflectors_in(reading, 0)
    x, y, z = (float(extent) for extent in obstacle.mesh.extents)
    return Need(
        obstacle.name, obstacle.category, len(obstacle.mesh.faces), (x, y, z), reading.closed, len(patches),
        0 if surface is None else len(surface), len(wedges_of(reading, 0, 0)), obstacle.moves,
    )  # fmt: skip


def integrals_needed(scene: Scene, phone: Phone, walk: Walk, step: Step = _silent) -> list[str]:
    """Obstacles for some of whose echoes the level "auto" takes Kirchhoff's integral, at `INSTANTS` of a walk.

    Rays alone, as the level "standard" takes them, err by more than half a decibel there. `step` is called after each
    instant: in a street of two dozen things one may take a minute or two.
    """
    named: set[str] = set()
    for time_s in np.linspace(0.0, walk.duration_s, INSTANTS):
        paths = trace_paths(scene, phone, walk.pose([time_s]), Fidelity(level="auto"), time_s)
        named |= {str(name) for name in paths.obstacle[paths.kind == "kirchhoff"]}
        step()
    return [obstacle.name for obstacle in scene.obstacles if obstacle.name in named]


@dataclass(frozen=True)
class _Opening:
    """The first part of a walk."""

    walk: Walk
    duration_s: float

    def pose(self, time_s: ArrayLike) -> Pose:
        return self.walk.pose(time_s)


def rendering_cost(
    scene: Scene, phone: Phone, walk: Walk, fidelity: Fidelity | None = None, step: Step = _silent
) -> Cost:
    """Measured on the walk's first beeps; `step` is called after each of `TIMED_RENDERINGS`.

    Raises:
        ValueError: the walk is shorter than one beep.
    """
    beep = BeepDesign()
    beeps = int(np.floor(walk.duration_s / beep.period_s + 1e-9))
    some = min(TIMED_BEEPS, beeps)

    def seconds(count: int) -> float:
        begin = perf_counter()
        render_walk(scene, phone, _Opening(walk, count * beep.period_s), beep, fidelity)
        taken = perf_counter() - begin
        step()
        return taken

    seconds(min(some, 1))  # compiles and warms caches
    one, all_ = seconds(1), seconds(some)
    per_beep = all_ / some if some == 1 else max(0.0, all_ - one) / (some - 1)
    return Cost(max(0.0, one - per_beep), per_beep, beeps)
