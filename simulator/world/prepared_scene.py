"""Scenes made ready for tracing: what does not depend on where the phone is, worked out once and kept.

A mesh is read once a process, whatever scenes it stands in: its planes, smooth surface and edges are kept by its
content. What a scene makes of its meshes together is kept by its `PreparedScene`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from hashlib import blake2b
from typing import Any

import numpy as np

from obstaclewatch.support.argument_types import check_types
from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.vectors import norm
from simulator.phone.phone import Phone
from simulator.scene.air import Air
from simulator.scene.pose import Pose
from simulator.scene.scene import Obstacle, Scene
from simulator.surfaces.cracks import closed, cracks, down_to_others
from simulator.surfaces.reflectors import (
    MeshReading,
    PlanarPatches,
    SmoothSurface,
    merge_patches,
    read_mesh,
    reflectors_in,
)
from simulator.surfaces.wedges import Wedges, merge_wedges, no_wedges, wedges_of
from simulator.waves.band import HIGH_HZ, LOW_HZ
from simulator.world.clearance import check_poses
from simulator.world.contacts import exposed
from simulator.world.corners import corner_wedges
from simulator.world.frames import Carrier, Frames, rest_frames
from simulator.world.mirrors import Planes
from simulator.world.rounded_parts import corners_of, loose, rounded_facets, rounded_parts
from simulator.world.visibility import Blocker, blocker
from simulator.world.world import Tracing, World

KEPT_MESHES = 32  # of 10,000 facets each they take 270 MB; the campus has 25 and the walker
KEPT_WORLDS = 8  # of one scene: with and without a body, by other mechanisms, about other origins
ORIGIN_GRID_M = 64.0  # a walk's origin is rounded to this, so that walks in one street share what is prepared


@dataclass(frozen=True, eq=False)
class PreparedScene:
    """A scene whose reflectors, edges and shadows are worked out once and kept, for calls without number.

    `trace_paths`, `trace_rejected` and `render_walk` take it in place of the scene and give the same answer. Worth it
    where they are called again and again, as a pose at a time. Nothing goes stale: meshes are recognised by their
    content at each call, so one that was changed in place is read again, and each set of mechanisms and each walker's
    body has its own preparation. In another process it is prepared anew.

    Attributes:
        scene: obstacles and air.

    Raises:
        ValueError: no scene.

    Example:
        >>> import trimesh
        >>> from simulator import Material, Obstacle, Phone, Pose, PreparedScene, Scene, held_rotation, trace_paths
        >>> wall = trimesh.creation.box(bounds=[[2.0, -2.0, 0.0], [2.1, 2.0, 3.0]])
        >>> street = PreparedScene(Scene([Obstacle(wall, Material.named("brick"), "wall")]))
        >>> phone, ahead = Phone.named("ideal"), held_rotation(heading_rad=0.0)
        >>> [len(trace_paths(street, phone, Pose([x, 0.0, 1.3], ahead))) for x in (0.0, 0.5, 1.0)]
        [20, 14, 12]
    """

    scene: Scene
    _worlds: dict[tuple[Any, ...], World] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_types(scene=(self.scene, Scene))

    def __reduce__(self) -> tuple[type[PreparedScene], tuple[Scene]]:
        return PreparedScene, (self.scene,)  # Embree's scenes belong to their process

    @property
    def air(self) -> Air:
        """The scene's air."""
        return self.scene.air

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The scene's obstacles."""
        return tuple(self.scene.obstacles)

    def world_at(self, position_m: Floats, phone: Phone, mechanisms: tuple[str, ...]) -> World:
        """The prepared world for poses at (N, 3) positions, about an origin near them."""
        origin = ORIGIN_GRID_M * np.round(position_m.mean(axis=0) / ORIGIN_GRID_M)
        shapes = tuple(_Shape.of(obstacle, origin) for obstacle in self.obstacles)
        body = () if phone.body is None else (_Shape.of(phone.body, np.zeros(3)), id(phone.body))
        key = (shapes, body, mechanisms)
        if key not in self._worlds:
            if len(self._worlds) == KEPT_WORLDS:
                del self._worlds[next(iter(self._worlds))]
            self._worlds[key] = prepare(self.scene, phone, origin, mechanisms)
        return self._worlds[key]

    def tracing(
        self, phone: Phone, pose: Pose, time_s: Floats, mechanisms: tuple[str, ...], carrier: Carrier
    ) -> Tracing:
        """Poses in the prepared world, each of which leaves the phone room; `carrier` says where the walker is."""
        position = np.atleast_2d(pose.position_m)
        world = self.world_at(position, phone, mechanisms)
        pose = replace(pose, position_m=position - world.origin_m)

        def about_origin(index: Ints, instant_s: Floats) -> tuple[Floats, Floats]:
            there, heading = carrier(index, instant_s)
            return there - world.origin_m, heading

        frames = Frames(velocities(world.obstacles), world.carried, about_origin)
        source, mics = pose.to_world(phone.geometry.speaker_m), pose.to_world(phone.geometry.mics_m)
        if (norm(mics - source[:, None]) == 0.0).any():
            raise ValueError("speaker and microphone must be apart, got the same point for both")
        tracing = Tracing(world, frames, pose, time_s, source, mics, frames.at(np.arange(len(pose)), time_s))
        check_poses(tracing)
        return tracing


def as_prepared(scene: Scene | PreparedScene) -> PreparedScene:
    """The scene, prepared if it is not yet."""
    return scene if isinstance(scene, PreparedScene) else PreparedScene(scene)


@dataclass(frozen=True)
class _Shape:
    """What the reading of a mesh depends on, and the obstacle to read where it is not known yet."""

    content: bytes
    surface: str
    origin_m: tuple[float, ...]
    obstacle: Obstacle = field(compare=False, repr=False)

    @classmethod
    def of(cls, obstacle: Obstacle, origin_m: Floats) -> _Shape:
        content = blake2b(digest_size=16)
        for array in (obstacle.mesh.vertices, obstacle.mesh.faces):
            content.update(len(array).to_bytes(8, "little") + np.ascontiguousarray(array).tobytes())
        return cls(content.digest(), obstacle.surface, tuple(origin_m.tolist()), obstacle)


@dataclass(frozen=True)
class Parts:
    """A mesh read as the first obstacle of a world: its facets told apart, planes and smooth surface."""

    reading: MeshReading
    patches: PlanarPatches
    surface: SmoothSurface | None

    @cached_property
    def edges(self) -> Wedges:
        """Its sharp edges."""
        return wedges_of(self.reading)


def parts_of(obstacle: Obstacle, origin_m: Floats) -> Parts:
    """An obstacle's mesh as it is read about an origin, once a process."""
    return _parts_of(_Shape.of(obstacle, origin_m))


@lru_cache(KEPT_MESHES)
def _parts_of(shape: _Shape) -> Parts:
    reading = read_mesh(_shifted(shape.obstacle, np.array(shape.origin_m)))
    return Parts(reading, *reflectors_in(reading))


def velocities(obstacles: tuple[Obstacle, ...]) -> Floats:
    """(O, 3) constant velocities."""
    return np.array([o.velocity_m_s for o in obstacles]).reshape(-1, 3)


def _shifted(obstacle: Obstacle, origin_m: Floats) -> Obstacle:
    """The obstacle about another origin; the mesh is copied only if it has to move."""
    if not origin_m.any():
        return obstacle
    mesh = obstacle.mesh.copy()
    mesh.vertices = np.asarray(mesh.vertices) - origin_m
    return replace(obstacle, mesh=mesh)


def prepare(scene: Scene, phone: Phone, origin_m: Floats, mechanisms: tuple[str, ...]) -> World:
    """Find the reflectors of a scene and build its visibility, about `origin_m`."""
    _check_body(phone.body, scene)
    obstacles = tuple(scene.obstacles) + (() if phone.body is None else (phone.body,))
    _check_materials(obstacles)
    carried = np.array([o is phone.body for o in obstacles], dtype=bool)
    shifts = [np.zeros(3) if own else origin_m for own in carried]
    parts = [parts_of(o, s) for o, s in zip(obstacles, shifts, strict=True)]
    first = np.cumsum([0] + [len(part.patches) for part in parts])
    faces = _patches(parts)
    drift = velocities(obstacles)
    frame = rest_frames(drift, carried)
    crack, strip = cracks(faces, frame)
    patches = down_to_others(closed(faces, crack, strip), frame) if "specular" in mechanisms else merge_patches([])
    at_rest = Planes.of(patches, frame)
    surfaces = [replace(part.surface, obstacle=i) for i, part in enumerate(parts) if part.surface is not None]
    meshes = [(np.asarray(part.reading.mesh.vertices), np.asarray(part.reading.mesh.faces)) for part in parts]
    together = [np.flatnonzero(frame == number) for number in np.unique(frame)]
    blockers = _blockers(meshes, together, faces.obstacle[crack], strip)
    wedges = no_wedges()
    if "edges" in mechanisms:
        every = merge_wedges([_numbered(part.edges, i, int(first[i])) for i, part in enumerate(parts)])
        corners = corner_wedges(patches, at_rest, drift, carried)
        wedges = exposed(merge_wedges([every, *corners]), blockers, drift, carried, patches, at_rest)
    readings = [part.reading for part in parts]
    own = rounded_facets(readings if "curved" in mechanisms else [], wedges)
    rounded, sharp = rounded_parts(readings, own), blockers
    if len(rounded):
        left = [loose(corners_of(r, ~o)) if o.any() else mesh for r, o, mesh in zip(readings, own, meshes, strict=True)]
        sharp = _blockers(left, together, faces.obstacle[crack], strip)
    return World(
        obstacles, carried, origin_m, patches, at_rest,
        tuple(surfaces if "curved" in mechanisms else []), wedges,
        tuple((part.reading, part.surface) for part in parts), blockers, rounded, sharp,
    )  # fmt: skip


def _check_materials(obstacles: Sequence[Obstacle]) -> None:
    """Refuse tables that leave out a part of the band over which gains are kept."""
    for obstacle in obstacles:
        table_hz = obstacle.material.frequency_hz
        if table_hz[0] > LOW_HZ or table_hz[-1] < HIGH_HZ:
            raise ValueError(
                f"frequency_hz of '{obstacle.material.name}' must span {LOW_HZ:g} to {HIGH_HZ:g}, over which gains are "
                f"kept, got {table_hz[0]:g} to {table_hz[-1]:g}"
            )


def _check_body(body: Obstacle | None, scene: Scene) -> None:
    """Refuse a walker's body that paths could not tell from an obstacle, or that moves by itself."""
    if body is not None and body.name in [obstacle.name for obstacle in scene.obstacles]:
        raise ValueError(f"the walker's body must have a name that no obstacle of the scene has, got '{body.name}'")
    if body is not None and body.moves:
        raise ValueError(
            f"the walker's body must have no velocity, it moves with the phone: got {body.velocity_m_s.tolist()} m/s "
            f"for '{body.name}'"
        )


def _patches(parts: list[Parts]) -> PlanarPatches:
    """The planes of all obstacles in turn."""
    owner = np.repeat(np.arange(len(parts)), [len(part.patches) for part in parts])
    return replace(merge_patches([part.patches for part in parts]), obstacle=owner.astype(np.int64))


def _numbered(wedges: Wedges, obstacle: int, first_patch: int) -> Wedges:
    """The edges of a mesh as those of an obstacle of the world, whose first patch has that number."""
    return replace(wedges, patch=wedges.patch + first_patch, obstacle=np.full(len(wedges), obstacle))


def _blockers(
    meshes: list[tuple[Floats, Ints]], together: list[Ints], cracked: Ints, strip_m: Floats
) -> tuple[Blocker, ...]:
    """What casts shadows: (vertices, faces) of all obstacles, and strips (K, 4, 3) that close cracks of some (K,)."""
    found = []
    for group in together:
        own = np.isin(cracked, group)
        corner = 4 * np.arange(np.count_nonzero(own))[:, None]
        strips = strip_m[own].reshape(-1, 3), np.concatenate([corner + [0, 1, 2], corner + [0, 2, 3]])
        faces = [len(meshes[i][1]) for i in group]
        if sum(faces):
            owner = np.concatenate([np.repeat(group, faces), np.tile(cracked[own], 2)])
            found.append(blocker([meshes[i] for i in group] + [strips], owner))
    return tuple(found)
