"""What stands in the world: obstacles with meshes and materials, and the air between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, cast

import numpy as np
import trimesh

from obstaclewatch.support.argument_types import as_floats, as_several, check_types
from obstaclewatch.support.arrays import Flags, Floats
from simulator.scene.air import Air
from simulator.scene.materials import Material
from simulator.scene.pose import FARTHEST_M

Surface = Literal["auto", "flat", "smooth"]
CASE = "case"  # in place of an obstacle: what paths through the phone's case have
MOST_PARTS = 1000  # into which a mesh is split
LEAST_AREA = 1e-9
"""Of a triangle, over the square of its longest side."""


@dataclass(frozen=True, eq=False, repr=False)
class Obstacle:
    """One named body: a mesh in world coordinates, its material, and how its facets are to be read.

    A closed mesh, watertight and wound alike, reflects on the side its normals point to: outside, or inside if it is
    wound inwards, as a room is. Both sides of any other mesh reflect.

    Attributes:
        mesh: trimesh.Trimesh, m, world frame, at time 0; copied, so that what is moved later stays here where it was.
        material: reflection of its whole surface.
        name: unique within a scene, without " > ", which joins the names of those that a path meets.
        surface: "auto" reads nearly tangent neighbours (below 35 degrees of dihedral angle) as one smooth surface, but
            not two planes so broad that rounding would raise both by more than 2.5 cm, nor the two halves of a wall
            that is bent once (wider than 0.1 m, raised by more than 0.5 mm), "flat" takes every facet as the true
            surface, "smooth" rounds every edge but the sharp ones (60 degrees).
        velocity_m_s: (3,) constant velocity of the whole body.
        category: free label ("wall", "dustbin", ...), carried through to scores.

    Raises:
        ValueError: no trimesh.Trimesh (a file of several parts loads as a trimesh.Scene), no triangles or none with an
            area, NaN vertices, indices out of range, no Material, no name, an unknown surface, a wrong velocity.

    Example:
        >>> import trimesh
        >>> from simulator import Material, Obstacle
        >>> post = trimesh.creation.cylinder(radius=0.1, height=2.0)
        >>> Obstacle(post, Material.named("concrete"), "post", velocity_m_s=[-1.0, 0.0, 0.0]).moves
        True
    """

    mesh: trimesh.Trimesh
    material: Material
    name: str
    surface: Surface = "auto"
    velocity_m_s: Floats = field(default_factory=lambda: np.zeros(3))
    category: str = ""

    def __repr__(self) -> str:
        return f"Obstacle({self.name!r}, {len(self.mesh.faces)} triangles of {self.material.name})"

    def __post_init__(self) -> None:
        if not (isinstance(self.name, str) and self.name.strip()):
            raise ValueError(f"name of an obstacle must be a word or more, got {self.name!r}")
        if self.name == CASE:
            raise ValueError(f"name of an obstacle must not be '{CASE}', which paths through the phone's case have")
        check_types(category=(self.category, str))
        if " > " in f" {self.name} ":
            raise ValueError(f"name of an obstacle must not hold ' > ', which joins names, got {self.name!r}")
        if not isinstance(self.mesh, trimesh.Trimesh):
            hint = "; its to_mesh() is one" if isinstance(self.mesh, trimesh.Scene) else ""
            raise ValueError(f"mesh of '{self.name}' must be a trimesh.Trimesh, got {type(self.mesh).__name__}{hint}")
        if not isinstance(self.material, Material):
            raise ValueError(
                f"material of '{self.name}' must be a Material, as Material.named(...), got {self.material!r}"
            )
        _check_mesh(self.mesh, self.name)
        object.__setattr__(self, "mesh", self.mesh.copy(include_cache=True))
        check_types(surface=(self.surface, str))
        if self.surface not in ("auto", "flat", "smooth"):
            raise ValueError(f"surface of '{self.name}' must be auto, flat or smooth, got {self.surface!r}")
        velocity = as_floats(f"velocity_m_s of '{self.name}'", self.velocity_m_s)
        if velocity.shape != (3,) or not np.isfinite(velocity).all():
            raise ValueError(f"velocity_m_s of '{self.name}' must be three finite numbers, got {self.velocity_m_s}")
        velocity.setflags(write=False)
        object.__setattr__(self, "velocity_m_s", velocity)

    @property
    def moves(self) -> bool:
        """Whether the obstacle has a velocity."""
        return bool(np.any(self.velocity_m_s != 0.0))

    def split(self) -> tuple[Obstacle, ...]:
        """The parts of the mesh that share no point, each an obstacle of its own, the largest surface first.

        A whole street in one mesh echoes as it should only in parts: the curved surfaces of an obstacle are not seen in
        its own planes as mirrors, so that a bin would lack its echo over the ground. Parts are called "street-1",
        "street-2" and so on, without the triangles that have no area; an obstacle in one piece is returned as it is.

        Raises:
            ValueError: more than `MOST_PARTS` parts, as of triangles that share no corners.

        Example:
            >>> import trimesh
            >>> from simulator import Material, Obstacle
            >>> ground = trimesh.creation.box(bounds=[[-9.0, -9.0, -0.1], [9.0, 9.0, 0.0]])
            >>> bin_ = trimesh.creation.cylinder(0.3, 0.9).apply_translation([2.0, 0.0, 0.45])
            >>> yard = Obstacle(ground + bin_, Material.named("concrete"), "yard")
            >>> [(part.name, len(part.mesh.faces)) for part in yard.split()]
            [('yard-1', 12), ('yard-2', 128)]
        """
        kept = np.flatnonzero(with_area(self.mesh))
        joined = welded(trimesh.Trimesh(self.mesh.vertices, self.mesh.faces[kept], process=False))
        point = trimesh.graph.connected_component_labels(joined.edges, len(joined.vertices))
        _, part = np.unique(point[joined.faces[:, 0]], return_inverse=True)
        area_m2 = np.bincount(part, joined.area_faces)
        if len(area_m2) == 1:
            return (self,)
        if len(area_m2) > MOST_PARTS:
            raise ValueError(f"'{self.name}' must have at most {MOST_PARTS} parts to be split, got {len(area_m2)}")
        rows = [kept[part == each] for each in np.argsort(-area_m2, kind="stable")]
        meshes = cast(list[trimesh.Trimesh], self.mesh.submesh(rows))
        return tuple(replace(self, mesh=mesh, name=f"{self.name}-{n}") for n, mesh in enumerate(meshes, 1))


@dataclass(frozen=True, eq=False, repr=False)
class Scene:
    """Obstacles and air. The ground is an obstacle like any other.

    Raises:
        ValueError: two obstacles share a name, or something is no obstacle or no air.

    Example:
        >>> import trimesh
        >>> from simulator import Air, Material, Obstacle, Scene
        >>> wall = Obstacle(trimesh.creation.box((0.2, 8.0, 3.0)), Material.named("brick"), "wall", category="wall")
        >>> Scene([wall], air=Air(temperature_c=5.0)).obstacle("wall").category
        'wall'
        >>> Scene([wall])
        Scene('scene', Obstacle('wall', 12 triangles of brick), 20 C)
    """

    obstacles: Sequence[Obstacle]
    air: Air = field(default_factory=Air)
    name: str = "scene"

    def __repr__(self) -> str:
        return f"Scene({self.name!r}, {', '.join(map(repr, self.obstacles))}, {self.air.temperature_c:g} C)"

    def __post_init__(self) -> None:
        check_types(air=(self.air, Air), name=(self.name, str))
        object.__setattr__(self, "obstacles", as_several("obstacles", self.obstacles))
        for obstacle in self.obstacles:
            check_types(obstacle=(obstacle, Obstacle))
        names = [obstacle.name for obstacle in self.obstacles]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"obstacle names must be unique, got {twice} more than once")

    def obstacle(self, name: str) -> Obstacle:
        """The obstacle of that name.

        Raises:
            KeyError: there is none; the message lists the names there are.
        """
        for candidate in self.obstacles:
            if candidate.name == name:
                return candidate
        raise KeyError(f"no obstacle named '{name}'; there are {[o.name for o in self.obstacles]}")


def _check_mesh(mesh: trimesh.Trimesh, name: str) -> None:
    """Refuse what Embree would silently drop (NaN vertices, bad indices)."""
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    if len(faces) == 0:
        raise ValueError(f"mesh of '{name}' must have triangles, got none")
    bad = int((~np.isfinite(vertices).all(axis=1)).sum())
    if bad:
        raise ValueError(
            f"mesh of '{name}' must have finite vertices, got {bad} of {len(vertices)} with NaN or infinity"
        )
    if np.abs(vertices).max() > FARTHEST_M:
        far = f"{np.abs(vertices).max():g}"
        raise ValueError(f"mesh of '{name}' must lie within {FARTHEST_M:g} m of the origin, got a vertex at {far} m")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise ValueError(f"mesh of '{name}' must index its {len(vertices)} vertices, got {faces.min()}..{faces.max()}")
    if not with_area(mesh).any():
        raise ValueError(f"mesh of '{name}' must have a triangle with an area, got {len(faces)} without")


def welded(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy with equal vertices merged: in many files each triangle has points of its own."""
    copy = trimesh.Trimesh(np.array(mesh.vertices, float), np.array(mesh.faces), process=False)
    copy.merge_vertices(merge_tex=True, merge_norm=True)
    return copy


def with_area(mesh: trimesh.Trimesh) -> Flags:
    """(T,) triangles that have a plane: whose area is not lost beside the square of their longest side."""
    corners = np.asarray(mesh.vertices, dtype=np.float64)[mesh.faces]
    along = np.roll(corners, -1, axis=1) - corners
    area = 0.5 * np.linalg.norm(np.cross(along[:, 0], along[:, 1]), axis=1)
    found: Flags = area > LEAST_AREA * np.linalg.norm(along, axis=2).max(axis=1) ** 2
    return found
