"""Pedestrians with the shapes of real people: two sexes, three builds, standing, reading a phone, or walking.

The meshes come from the base mesh of MakeHuman (CC0); `docs/studies/make_people.py` made them and says how.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import as_file, files
from typing import Literal

import numpy as np
import trimesh

from scenes.obstacles.measures import measured
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle

Sex = Literal["female", "male"]
Build = Literal["slim", "average", "heavy"]
Pose = Literal["stand", "read", "walk-0", "walk-15", "walk-30"]

STEP_M = 1e-4  # of the stored vertices
SEXES: tuple[Sex, ...] = ("female", "male")
BUILDS: tuple[Build, ...] = ("slim", "average", "heavy")
STANDING: tuple[Pose, ...] = ("stand", "read")
WALKING: tuple[Pose, ...] = ("walk-0", "walk-15", "walk-30")


@dataclass(frozen=True)
class Statures:
    """Heights of the adults of one sex: a normal distribution cut off at both ends, m."""

    mean_m: float
    deviation_m: float
    low_m: float
    high_m: float


STATURES: dict[Sex, Statures] = {"female": Statures(1.64, 0.07, 1.50, 1.80), "male": Statures(1.77, 0.07, 1.60, 1.95)}
BUILD_SHARES = (0.3, 0.5, 0.2)
CLOTHES = {"clothed-person": 0.5, "light-clothing": 0.25, "coat": 0.25}


@measured
def pedestrian(
    stature_m: float = 1.75, sex: Sex = "male", build: Build = "average", pose: Pose = "stand", mirrored: bool = False
) -> trimesh.Trimesh:
    """A clothed adult facing -x, on the ground, one closed surface of 3,000 to 4,000 triangles.

    Args:
        stature_m: height when standing upright, 1.0 to 2.3 m; a stride makes it less.
        sex: "female" or "male".
        build: "slim", "average" or "heavy".
        pose: "stand", "read" (a phone before the chest) or "walk-PHASE", the right leg's phase after heel strike in
            percent of the gait cycle.
        mirrored: left and right changed, which is half a gait cycle later.

    Raises:
        ValueError: a stature outside 1.0-2.3 m, or an unknown sex, build or pose.
    """
    if not 1.0 <= stature_m <= 2.3:
        raise ValueError(f"stature_m must lie between 1.0 and 2.3, got {stature_m}")
    for label, value, known in (("sex", sex, SEXES), ("build", build, BUILDS), ("pose", pose, STANDING + WALKING)):
        if value not in known:
            raise ValueError(f"{label} must be one of {', '.join(known)}, got {value!r}")
    upright, _ = _stored(sex, build, "stand")
    vertices, faces = _stored(sex, build, pose)
    scaled = vertices * (stature_m / upright[:, 2].max())
    if mirrored:
        scaled, faces = scaled * [1.0, -1.0, 1.0], faces[:, ::-1]
    return trimesh.Trimesh(scaled, faces, process=False)


def random_person(rng: np.random.Generator, name: str = "person", walking: bool | None = None) -> Obstacle:
    """A clothed adult, 1.50-1.95 m tall, in mid-stride if walking; None draws standing or walking evenly."""
    drawn = bool(rng.random() < 0.5)
    poses = WALKING if (drawn if walking is None else walking) else STANDING
    sex = SEXES[rng.integers(len(SEXES))]
    heights = STATURES[sex]
    stature = float(np.clip(rng.normal(heights.mean_m, heights.deviation_m), heights.low_m, heights.high_m))
    build = BUILDS[rng.choice(len(BUILDS), p=BUILD_SHARES)]
    mesh = pedestrian(stature, sex, build, poses[rng.integers(len(poses))], mirrored=bool(rng.random() < 0.5))
    clothes = str(rng.choice(list(CLOTHES), p=list(CLOTHES.values())))
    return Obstacle(mesh, Material.named(clothes), name, category="pedestrian")


@cache
def _stored(sex: Sex, build: Build, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
    """(V, 3) vertices, m, and (T, 3) faces; read-only."""
    with as_file(files("scenes.data") / "people.npz") as path, np.load(path) as people:
        vertices = people[f"{sex}_{build}_{pose}_vertices"] * STEP_M
        faces = people[f"{sex}_{build}_{pose}_faces"].astype(np.int64)
    vertices.setflags(write=False)
    faces.setflags(write=False)
    return vertices, faces
