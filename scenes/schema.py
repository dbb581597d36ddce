"""Scenes as YAML files: what may stand in one, and how it becomes a `Scene`.

A file names a scene, its air, its ground and its obstacles. An obstacle is one of the kinds below with its measures
in metres, or a mesh file with its unit. Angles are in degrees, as people write them. Example:

    name: back-yard
    air: {temperature_c: 12, relative_humidity: 0.7}
    ground: {material: asphalt, size_m: [40, 40]}
    obstacles:
      - {kind: wall, name: garage, at_m: [6, 0], parameters: {length_m: 8, height_m: 3}, material: brick}
      - {kind: litter_bin, name: bin, at_m: [3, 1], parameters: {radius_m: 0.3}}
      - {mesh: statue.ply, units: mm, name: statue, at_m: [4, -2], material: concrete, category: clutter}
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import trimesh
import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from scenes.obstacles import (
    a_frame,
    bench,
    bollard,
    car,
    donation_box,
    dumpster,
    ground,
    lamp_post,
    litter_bin,
    person,
    pole_sign,
    tree,
    wall,
    wheeled_bin,
)
from scenes.placing import placed
from scenes.solids import box, cylinder
from simulator.air import Air
from simulator.materials import Material
from simulator.scene import Obstacle, Scene

UNITS_M = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}


@dataclass(frozen=True)
class Kind:
    """A kind of obstacle: the function that makes its mesh, its category and its usual material."""

    mesh: Callable[..., trimesh.Trimesh]
    category: str
    material: str


KINDS: dict[str, Kind] = {
    "wall": Kind(wall, "wall", "brick"),
    "litter_bin": Kind(litter_bin, "dustbin", "metal"),
    "wheeled_bin": Kind(wheeled_bin, "dustbin", "plastic"),
    "dumpster": Kind(dumpster, "dustbin", "metal"),
    "donation_box": Kind(donation_box, "dustbin", "metal"),
    "car": Kind(car, "car", "metal"),
    "pole_sign": Kind(pole_sign, "sign", "sign-sheet"),
    "a_frame": Kind(a_frame, "sign", "sign-sheet"),
    "person": Kind(person, "pedestrian", "clothed-person"),
    "tree": Kind(tree, "clutter", "wood"),
    "bollard": Kind(bollard, "clutter", "metal"),
    "lamp_post": Kind(lamp_post, "clutter", "metal"),
    "bench": Kind(bench, "clutter", "wood"),
    "box": Kind(box, "clutter", "metal"),
    "cylinder": Kind(cylinder, "clutter", "metal"),
}


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class AirSpec(_Strict):
    """Weather."""

    temperature_c: float = 20.0
    relative_humidity: float = 0.5
    pressure_pa: float = 101_325.0


class GroundSpec(_Strict):
    """A level patch of ground in z = 0, centred at the origin."""

    material: str = "asphalt"
    size_m: tuple[float, float] = (60.0, 60.0)


class ObstacleSpec(_Strict):
    """One obstacle: a kind with parameters, or a mesh file with its unit."""

    name: str
    kind: str | None = None
    parameters: dict[str, Any] = Field(default_factory=dict)
    mesh: str | None = None
    units: Literal["m", "cm", "mm", "in", "ft"] = "m"
    at_m: tuple[float, float] = (0.0, 0.0)
    yaw_deg: float = 0.0
    velocity_m_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    material: str | None = None
    category: str | None = None
    surface: Literal["auto", "flat", "smooth"] = "auto"

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
        if self.mesh is not None and (self.parameters or self.material is None):
            raise ValueError(f"obstacle '{self.name}' with a mesh must have a material and no parameters")
        if self.kind is not None:
            known = list(inspect.signature(KINDS[self.kind].mesh).parameters)
            unknown = sorted(set(self.parameters) - set(known))
            if unknown:
                raise ValueError(f"parameters of kind '{self.kind}' must be among {known}, got {unknown}")
        return self


class SceneSpec(_Strict):
    """A whole scene."""

    name: str
    air: AirSpec = AirSpec()
    ground: GroundSpec | None = GroundSpec()
    obstacles: list[ObstacleSpec]


def read_scene(path: str | Path) -> Scene:
    """The scene in a YAML file; mesh files are looked for beside it.

    Raises:
        ValueError: a file that is not YAML or does not fit the schema; the message says where and why.
        FileNotFoundError: the file or one of its meshes is missing.
    """
    path = Path(path)
    try:
        spec = SceneSpec.model_validate(yaml.safe_load(path.read_text(encoding="utf-8")))
    except yaml.YAMLError as error:
        raise ValueError(f"scene file must be YAML, got {path}: {error}") from error
    except ValidationError as error:
        problems = "; ".join(f"{'.'.join(map(str, e['loc']))}: {e['msg']}" for e in error.errors())
        raise ValueError(f"scene file {path} must fit the schema: {problems}") from error
    return scene_of(spec, path.parent)


def scene_of(spec: SceneSpec, folder: Path) -> Scene:
    """The scene that a specification describes; mesh files are relative to the folder."""
    obstacles = [_obstacle(one, folder) for one in spec.obstacles]
    if spec.ground is not None:
        floor = ground(spec.ground.size_m)
        material = Material.named(spec.ground.material)
        obstacles.insert(0, Obstacle(floor, material, "ground", surface="flat", category="ground"))
    return Scene(obstacles, air=Air(**spec.air.model_dump()), name=spec.name)


def _obstacle(spec: ObstacleSpec, folder: Path) -> Obstacle:
    if spec.kind is not None:
        kind = KINDS[spec.kind]
        mesh, material, category = kind.mesh(**spec.parameters), spec.material or kind.material, kind.category
    else:
        mesh, material, category = _mesh_file(folder / str(spec.mesh), spec.units), str(spec.material), ""
    obstacle = Obstacle(
        mesh,
        Material.named(material),
        spec.name,
        surface=spec.surface,
        category=category if spec.category is None else spec.category,
    )
    return placed(obstacle, spec.at_m, np.deg2rad(spec.yaw_deg), spec.velocity_m_s)


def _mesh_file(path: Path, units: str) -> trimesh.Trimesh:
    """The mesh of a file, in metres.

    Raises:
        FileNotFoundError: there is no such file.
    """
    if not path.is_file():
        raise FileNotFoundError(f"mesh file must exist, got {path}")
    mesh: trimesh.Trimesh = trimesh.load_mesh(path)
    mesh.apply_scale(UNITS_M[units])
    return mesh
