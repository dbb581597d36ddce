"""Scenes as YAML files: what may stand in one, and how it becomes a `Scene`.

A file names a scene, its air, its ground and its obstacles, and may hold a walk, a phone and a target (see
`encounter`). An obstacle is one of the kinds below with its measures in metres, or a mesh (OBJ, PLY, STL, OFF, glTF) in
the file's folder with its unit, which has no default: a mesh does not know it. Angles are in degrees, as people write
them:

    name: back-yard
    air: {temperature_c: 12, relative_humidity: 0.7}
    ground: {material: asphalt, size_m: [40, 40]}
    obstacles:
      - {kind: wall, name: garage, at_m: [6, 0], parameters: {length_m: 8, height_m: 3}, material: brick}
      - {kind: litter_bin, name: bin, at_m: [3, 1], parameters: {radius_m: 0.3}}
      - {mesh: statue.ply, units: mm, name: statue, at_m: [4, -2], material: concrete, category: clutter}
    walk: {start_m: [0, 0], heading_deg: 0, speed_m_s: 1.3, duration_s: 4}
    phone: {preset: galaxy-s5}
    target: bin
"""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Annotated, Any, Literal, get_type_hints

import numpy as np
import trimesh
from pydantic import AfterValidator, Field, field_validator, model_validator

from scenes.files.field_types import FASTEST_M_S, Number, Plan, Positive, Strict
from scenes.files.mesh_file import mesh_path, read_mesh
from scenes.files.obstacle_kinds import KINDS, Kind
from scenes.files.walk_schema import PhoneSpec, WalkSpec
from scenes.files.yaml_file import YamlFile
from scenes.obstacles import ground
from scenes.obstacles.solids import shifted
from scenes.streets.placing import placed
from simulator.scene.air import Air
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle, Scene

UNITS_M = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254, "ft": 0.3048}


class AirSpec(Strict):
    """Weather."""

    temperature_c: Number = 20.0
    relative_humidity: Number = 0.5
    pressure_pa: Number = 101_325.0

    @model_validator(mode="after")
    def _breathable(self) -> AirSpec:
        Air(**self.model_dump())
        return self


def _known_material(name: str) -> str:
    Material.named(name)
    return name


MaterialName = Annotated[str, AfterValidator(_known_material)]


class GroundSpec(Strict):
    """A level patch of ground in z = 0, centred at the origin."""

    material: MaterialName = "asphalt"
    size_m: tuple[Positive, Positive] = (60.0, 60.0)


class ObstacleSpec(Strict):
    """One obstacle: a kind with parameters, or a mesh file with its unit.

    Attributes:
        up: the axis of the mesh file that points up; glTF files have "y".
        lift_m: how far the obstacle is raised from where its mesh stands.
        split: each part of the mesh that is not connected to the others becomes an obstacle: name-1, name-2 ...
    """

    name: Annotated[str, Field(min_length=1)]
    kind: str | None = None
    parameters: dict[str, Any] = Field(default_factory=dict)
    mesh: str | None = None
    units: Literal["m", "cm", "mm", "in", "ft"] | None = None
    up: Literal["z", "y"] = "z"
    at_m: Plan = (0.0, 0.0)
    lift_m: Number = 0.0
    yaw_deg: Number = 0.0
    velocity_m_s: tuple[Number, Number, Number] = (0.0, 0.0, 0.0)
    material: MaterialName | None = None
    category: str | None = None
    surface: Literal["auto", "flat", "smooth"] = "auto"
    split: bool = False

    def _check_numbers(self, kind: str) -> None:
        """Refuse a text, a truth value or a list where the kind takes a number."""
        hints = get_type_hints(KINDS[kind].mesh)
        for name, value in self.parameters.items():
            if hints.get(name) in (int, float) and (isinstance(value, bool) or not isinstance(value, int | float)):
                hint = "; YAML reads 1.0e-3 as a number, 1e-3 as a text" if isinstance(value, str) else ""
                raise ValueError(f"{name} of kind '{kind}' must be a number, got {value!r}{hint}")

    @field_validator("velocity_m_s")
    @classmethod
    def _slow_enough(cls, velocity: tuple[float, float, float]) -> tuple[float, float, float]:
        speed = float(np.linalg.norm(velocity))
        if speed > FASTEST_M_S:
            raise ValueError(f"must be at most {FASTEST_M_S:g} m/s in size, got {speed:g} m/s, {list(velocity)}")
        return velocity

    @field_validator("kind")
    @classmethod
    def _known(cls, kind: str | None) -> str | None:
        if kind is not None and kind not in KINDS:
            raise ValueError(f"kind must be one of {sorted(KINDS)}, got '{kind}'")
        return kind

    @model_validator(mode="after")
    def _one_source(self) -> ObstacleSpec:
        if (self.kind is None) == (self.mesh is None):
            raise ValueError(f"obstacle '{self.name}' must have either a kind or a mesh")
        if self.mesh is not None:
            if self.parameters or self.material is None:
                raise ValueError(f"obstacle '{self.name}' with a mesh must have a material and no parameters")
            if self.units is None:
                raise ValueError(f"obstacle '{self.name}' with a mesh must have units, one of {list(UNITS_M)}")
        if self.kind is not None:
            if left := sorted({"units", "up", "split"} & self.model_fields_set):
                raise ValueError(
                    f"obstacle '{self.name}' of a kind must have no {' or '.join(left)}: these are of meshes"
                )
            self._check_numbers(self.kind)
            known = inspect.signature(KINDS[self.kind].mesh).parameters
            unknown = sorted(set(self.parameters) - set(known))
            if unknown:
                raise ValueError(f"parameters of kind '{self.kind}' must be among {list(known)}, got {unknown}")
            missing = [name for name in known if known[name].default is inspect.Parameter.empty]
            if left := sorted(set(missing) - set(self.parameters)):
                raise ValueError(f"parameters of kind '{self.kind}' must include {left}")
        return self


class SceneSpec(Strict):
    """A scene, and what a walk through it needs."""

    name: str
    air: AirSpec = AirSpec()
    ground: GroundSpec | None = GroundSpec()
    obstacles: list[ObstacleSpec]
    walk: WalkSpec | None = None
    phone: PhoneSpec | None = None
    target: str | None = None


def read_scene(path: str | Path) -> Scene:
    """The scene in a YAML file; mesh files are looked for beside it.

    Raises:
        ValueError: a file that is not YAML or does not fit the schema; the message has file, line and field.
        FileNotFoundError: the file or one of its meshes is missing.
    """
    source = YamlFile.read(path)
    return scene_of(source.as_model(SceneSpec), source)


def scene_of(spec: SceneSpec, source: YamlFile) -> Scene:
    """The scene that a specification describes, with the file it was read from."""
    obstacles: list[Obstacle] = []
    for number, one in enumerate(spec.obstacles):
        with source.at("obstacles", number):
            obstacle = _obstacle(one, source.path.parent)
            obstacles += obstacle.split() if one.split else [obstacle]
    if spec.ground is not None:
        with source.at("ground"):
            floor = ground(spec.ground.size_m)
        material = Material.named(spec.ground.material)
        obstacles.insert(0, Obstacle(floor, material, "ground", surface="flat", category="ground"))
    with source.at("obstacles"):
        return Scene(obstacles, air=Air(**spec.air.model_dump()), name=spec.name)


def _obstacle(spec: ObstacleSpec, folder: Path) -> Obstacle:
    if spec.kind is not None:
        kind = KINDS[spec.kind]
        mesh, material, category = _made(kind, spec), spec.material or kind.material, kind.category
    else:
        mesh = read_mesh(mesh_path(folder, str(spec.mesh)), UNITS_M[spec.units or "m"], spec.up)
        material, category = str(spec.material), ""
    if spec.lift_m:
        mesh = shifted(mesh, [0.0, 0.0, spec.lift_m])
    obstacle = Obstacle(
        mesh,
        Material.named(material),
        spec.name,
        surface=spec.surface,
        category=category if spec.category is None else spec.category,
    )
    return placed(obstacle, spec.at_m, np.deg2rad(spec.yaw_deg), spec.velocity_m_s)


def _made(kind: Kind, spec: ObstacleSpec) -> trimesh.Trimesh:
    """The mesh of a kind.

    Raises:
        ValueError: a parameter is missing, of another type, or refused by the kind.
    """
    try:
        return kind.mesh(**spec.parameters)
    except (TypeError, IndexError) as error:  # a word for a number, two numbers for three
        raise ValueError(f"parameters of kind '{spec.kind}' must fit it, got {spec.parameters}: {error}") from error
