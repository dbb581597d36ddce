"""What a scene will ask of the simulator: mirrors, smooth surfaces and sharp edges, obstacle by obstacle, and time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numba.core.event import install_timer
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from obstaclewatch.beep import BeepDesign
from obstaclewatch.recording import Recording
from simulator.phone.phone import Phone
from simulator.render import render_walk
from simulator.scene.fidelity import Fidelity
from simulator.scene.pose import Pose, Walk
from simulator.scene.scene import Obstacle, Scene
from simulator.trace import trace_paths
from simulator.world.prepared_scene import PreparedScene, parts_of

Step = Callable[[], object]
TIMED_BEEPS = 4
TIMED_STEPS = 3
"""Preparation, the first beep, and `TIMED_BEEPS` of them."""
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
        prepare_s: once for a scene: its meshes are read, and bodies cut into facets.
        per_beep_s: for every beep after that.
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
    read = parts_of(obstacle, np.zeros(3))
    x, y, z = (float(extent) for extent in obstacle.mesh.extents)
    return Need(
        obstacle.name, obstacle.category, len(obstacle.mesh.faces), (x, y, z), read.reading.closed, len(read.patches),
        0 if read.surface is None else len(read.surface), len(read.edges), obstacle.moves,
    )  # fmt: skip


def integrals_needed(scene: Scene, phone: Phone, walk: Walk, step: Step = _silent) -> list[str]:
    """Obstacles for some of whose echoes the level "auto" takes Kirchhoff's integral, at `INSTANTS` of a walk.

    Rays alone would err by more than half a decibel there. `step` is called after each instant: in a street of two
    dozen things one may take a minute or two.
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


def rendering_cost(scene: Scene, phone: Phone, walk: Walk, step: Step = _silent) -> Cost:
    """Measured on the walk's first beeps, whatever is compiled for them apart; `step` is called after `TIMED_STEPS`.

    Meshes that this process has read before cost nothing again. Linear algebra keeps to the one processor: small
    matrices take up to half as long again where several threads wait for each other.

    Raises:
        ValueError: the walk is shorter than one beep.
    """
    beep, fidelity, street = BeepDesign(), Fidelity(), PreparedScene(scene)
    beeps = beep.beeps_in(walk.duration_s)
    some = min(TIMED_BEEPS, beeps)

    def render(count: int) -> Recording:
        return render_walk(street, phone, _Opening(walk, count * beep.period_s), beep, fidelity)

    def seconds(work: Callable[[], object]) -> float:
        compiling: list[float] = []
        begin = perf_counter()
        with install_timer("numba:compile", compiling.append), threadpool_limits(1, "blas"):
            work()
        step()
        return perf_counter() - begin - sum(compiling)

    reading = seconds(lambda: street.world_at(walk.pose([0.0]).position_m, phone, fidelity.mechanisms))
    first = seconds(lambda: render(min(some, 1)))
    per_beep = seconds(lambda: render(some)) / max(some, 1)
    return Cost(reading + max(0.0, first - per_beep), per_beep, beeps)
