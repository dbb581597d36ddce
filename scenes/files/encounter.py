"""A scene file that can be walked through: scene, walk, phone, and the obstacle that it is about."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from obstaclewatch.support.argument_types import check_seed
from scenes.files.mesh_file import mesh_path
from scenes.files.schema import SceneSpec, scene_of
from scenes.files.walk_schema import PhoneSpec, phone_of, walk_of
from scenes.files.yaml_file import YamlFile
from scenes.truth.truth import NOT_IN_THE_WAY, Contact, contact
from simulator.phone.phone import Phone
from simulator.scene.pose import Walk
from simulator.scene.scene import Obstacle, Scene


@dataclass(frozen=True)
class Encounter:
    """One walk through a user's scene.

    Attributes:
        scene: with its obstacles.
        walk: of the phone.
        phone: held by the walker's body.
        targets: name of the obstacle that the walk is about: the one that the file names, else the one that the
            walker meets first, else the one passed most closely.

    Example:
        >>> import trimesh
        >>> from scenes import Encounter, GaitWalk
        >>> from simulator import Material, Obstacle, Phone, Scene
        >>> post = trimesh.creation.cylinder(radius=0.1, segment=[[4.0, 0.0, 0.0], [4.0, 0.0, 2.0]])
        >>> scene = Scene([Obstacle(post, Material.named("metal"), "post")])
        >>> Encounter(scene, GaitWalk([0.0, 0.0, 1.3]), Phone.named("galaxy-s5"), ("post",)).target.name
        'post'
    """

    scene: Scene
    walk: Walk
    phone: Phone
    targets: tuple[str, ...]

    @property
    def target(self) -> Obstacle:
        """The obstacle that the walk is about."""
        return self.scene.obstacle(self.targets[0])


def load_encounter(path: str | Path, seed: int = 0, phone: str | None = None) -> Encounter:
    """The scene, walk, phone and target of a YAML file (see `scenes.files.schema` for its fields).

    Args:
        path: of the file; meshes are looked for beside it.
        seed: draws what the walk's `vary` leaves open; without `vary` it changes nothing.
        phone: name of a preset to use instead of the file's phone.

    Raises:
        ValueError: a seed that is no whole number from 0 on, or the file does not fit the schema, has no walk, or
            nothing to walk to; with file, line and field. Or an unknown phone was asked for.
        FileNotFoundError: the file or one of its meshes is missing.

    Example:
        >>> import tempfile
        >>> from pathlib import Path
        >>> from scenes import load_encounter
        >>> post, walk = "{kind: bollard, name: post, at_m: [4, 0]}", "{waypoints_m: [[0, 0], [6, 0]]}"
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = Path(folder) / "street.yaml"
        ...     _ = path.write_text(f"name: yard\\nobstacles: [{post}]\\nwalk: {walk}")
        ...     encounter = load_encounter(path)
        >>> encounter.targets, round(encounter.walk.duration_s, 2)
        (('post',), 4.62)
    """
    check_seed(seed=seed)
    source = YamlFile.read(path)
    spec = source.as_model(SceneSpec)
    scene = scene_of(spec, source)
    if spec.walk is None:
        raise ValueError(source.message((), "walk: is missing, and without one nothing can be simulated"))
    with source.at("walk"):
        walk = walk_of(spec.walk, seed)
    chosen = spec.phone or PhoneSpec()
    if phone is not None:
        Phone.named(phone)  # in no line of the file, and without pydantic's words
        chosen = PhoneSpec(preset=phone)
    with source.at("phone"):
        held = phone_of(chosen, spec.walk)
    with source.at("target" if spec.target is not None else "obstacles"):
        return Encounter(scene, walk, held, (_target(scene, walk, spec.target),))


def _target(scene: Scene, walk: Walk, wanted: str | None) -> str:
    """The obstacle wanted, or the one met first, or passed most closely."""
    candidates = [obstacle for obstacle in scene.obstacles if obstacle.category not in NOT_IN_THE_WAY]
    names = [obstacle.name for obstacle in candidates]
    if not candidates:
        raise ValueError("a scene to walk through must have an obstacle other than its ground, got none")
    if wanted is not None:
        if wanted not in names:
            raise ValueError(f"target must be an obstacle of the scene, got '{wanted}'; there are {names}")
        return wanted
    return min(zip([contact(o, walk) for o in candidates], names, strict=True), key=lambda item: _order(item[0]))[1]


def _order(met: Contact) -> tuple[float, float]:
    """Earliest contact first, then the smallest gap."""
    return (np.inf if np.isnan(met.contact_time_s) else met.contact_time_s), met.clearance_m


def has_walk(name: str | Path) -> bool:
    """Whether that is a scene file that can be walked through.

    Raises:
        ValueError, FileNotFoundError: as `load_encounter`.
    """
    if Path(name).suffix not in (".yaml", ".yml"):
        return False
    return YamlFile.read(name).as_model(SceneSpec).walk is not None


def scene_files(path: str | Path) -> list[Path]:
    """The scene file and the meshes it names, in its order.

    Raises:
        ValueError, FileNotFoundError: as `load_encounter`.
    """
    source = YamlFile.read(path)
    meshes = [one.mesh for one in source.as_model(SceneSpec).obstacles if one.mesh is not None]
    files = [source.path, *(mesh_path(source.path.parent, mesh) for mesh in meshes)]
    return files
