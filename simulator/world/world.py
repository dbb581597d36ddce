"""A scene made ready for tracing: reflectors, blockers and frames about an origin near the phone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.phone.phone import Phone
from simulator.scene.pose import Pose
from simulator.scene.scene import Obstacle, Scene
from simulator.surfaces.reflectors import (
    MeshReading,
    PlanarPatches,
    SmoothSurface,
    merge_patches,
    read_mesh,
    reflectors_in,
)
from simulator.surfaces.surface_borders import Border, border_of
from simulator.surfaces.wedges import Wedges, merge_wedges, no_wedges, wedges_of
from simulator.world.contacts import exposed
from simulator.world.corners import corner_wedges
from simulator.world.frames import Carrier, Frames
from simulator.world.interactions import Numbering
from simulator.world.mirrors import Mirrors, facing, placed_mirrors
from simulator.world.visibility import Blocker, blocker


@dataclass(frozen=True)
class World:
    """Everything that does not depend on where the phone is.

    Attributes:
        obstacles: the scene's, then the walker's body if there is one.
        origin_m: (3,) subtracted from all coordinates: far from the origin of a map, float64 keeps its micrometres.
        patches: planar patches of all obstacles.
        follows: (P, P) whether one patch may follow another.
        surfaces: smooth surfaces of all obstacles.
        wedges: sharp edges of all obstacles.
        skins: what the facets of each obstacle are, and its smooth surface, to hear it as a whole.
        blockers: what casts shadows; obstacles at rest in one, every moving one in its own.
    """

    obstacles: tuple[Obstacle, ...]
    origin_m: Floats
    patches: PlanarPatches
    follows: Flags
    surfaces: tuple[SmoothSurface, ...]
    wedges: Wedges
    skins: tuple[tuple[MeshReading, SmoothSurface | None], ...]
    blockers: tuple[Blocker, ...]

    @cached_property
    def borders(self) -> tuple[Border, ...]:
        """Where each smooth surface ends: asked for only where integrals may take over from rays."""
        return tuple(border_of(self.skins[surface.obstacle][0], surface) for surface in self.surfaces)

    @cached_property
    def numbering(self) -> Numbering:
        """The numbers of all reflectors."""
        counts = len(self.patches), len(self.surfaces), len(self.wedges)
        return Numbering(np.cumsum([0, *counts]))

    @cached_property
    def _owner(self) -> Ints:
        """(R + 1,) obstacle of every reflector, and -1 at the end."""
        surfaces = np.array([s.obstacle for s in self.surfaces], dtype=np.int64)
        bodies = np.arange(len(self.obstacles))
        owners = [self.patches.obstacle, surfaces, self.wedges.obstacle, bodies, np.array([-1])]
        return np.concatenate(owners).astype(np.int64)

    def obstacle_of(self, number: Ints) -> Ints:
        """The obstacles of reflectors by their numbers; -1 for -1."""
        return self._owner[number]


@dataclass(frozen=True)
class Tracing:
    """One call's poses in a prepared world.

    Attributes:
        world: reflectors and blockers.
        frames: where the obstacles are at any instant.
        pose: N poses about the world's origin.
        time_s: (N,) when they are taken.
        source_m, mics_m: (N, 3) speaker and (N, 2, 3) microphones.
        placed: (N, O, 4) frames of the obstacles at those instants.
    """

    world: World
    frames: Frames
    pose: Pose
    time_s: Floats
    source_m: Floats
    mics_m: Floats
    placed: Floats

    @cached_property
    def mirrors(self) -> Mirrors:
        """The patches where they stand at each pose."""
        return placed_mirrors(self.world.patches, self.world.follows, self.placed)


def velocities(obstacles: tuple[Obstacle, ...]) -> Floats:
    """(O, 3) constant velocities."""
    return np.array([o.velocity_m_s for o in obstacles]).reshape(-1, 3)


def prepare(scene: Scene, phone: Phone, origin_m: Floats, mechanisms: tuple[str, ...]) -> World:
    """Find the reflectors of a scene and build its visibility, about `origin_m`."""
    body = () if phone.body is None else (phone.body,)
    obstacles = tuple(scene.obstacles) + body
    shifts = [origin_m if o is not phone.body else np.zeros(3) for o in obstacles]
    moves = np.array([o.moves or o is phone.body for o in obstacles], dtype=bool)
    readings = [read_mesh(_shifted(o, s)) for o, s in zip(obstacles, shifts, strict=True)]
    found = [reflectors_in(reading, i) for i, reading in enumerate(readings)]
    patches = merge_patches([planar for planar, _ in found] if "specular" in mechanisms else [])
    surfaces = tuple(s for _, s in found if s is not None and "curved" in mechanisms)
    blockers = _blockers(obstacles, shifts, moves)
    wedges = no_wedges()
    if "edges" in mechanisms:
        first = np.cumsum([0] + [len(planar) for planar, _ in found])
        every = merge_wedges([wedges_of(reading, i, int(first[i])) for i, reading in enumerate(readings)])
        carried = np.array([o is phone.body for o in obstacles], dtype=bool)
        corners = corner_wedges(patches, velocities(obstacles), carried)
        wedges = exposed(merge_wedges([every, *corners]), blockers, carried, patches)
    return World(
        obstacles, origin_m, patches, facing(patches, moves), surfaces, wedges,
        tuple((reading, surface) for reading, (_, surface) in zip(readings, found, strict=True)), blockers,
    )  # fmt: skip


def _shifted(obstacle: Obstacle, origin_m: Floats) -> Obstacle:
    """The obstacle about another origin; the mesh is copied only if it has to move."""
    if not origin_m.any():
        return obstacle
    mesh = obstacle.mesh.copy()
    mesh.vertices = np.asarray(mesh.vertices) - origin_m
    return Obstacle(mesh, obstacle.material, obstacle.name, obstacle.surface, obstacle.velocity_m_s, obstacle.category)


def _blockers(obstacles: tuple[Obstacle, ...], shifts: list[Floats], moves: Flags) -> tuple[Blocker, ...]:
    meshes = [
        (np.asarray(o.mesh.vertices) - s, np.asarray(o.mesh.faces)) for o, s in zip(obstacles, shifts, strict=True)
    ]
    resting = np.flatnonzero(~moves)
    groups = [list(resting)] if len(resting) else []
    groups += [[index] for index in np.flatnonzero(moves)]
    return tuple(blocker([meshes[i] for i in group], int(group[0])) for group in groups)


def frames_for(world: World, phone: Phone, carrier: Carrier) -> Frames:
    """The motion of a world's obstacles, given the walker's."""
    carried = np.array([o is phone.body for o in world.obstacles], dtype=bool)
    return Frames(velocities(world.obstacles), carried, carrier)
