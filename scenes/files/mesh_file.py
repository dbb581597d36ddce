"""Meshes that a scene file names: from its own folder, of a bounded size, and triangles alone.

A scene may come from someone else. Its mesh is therefore looked for in the folder of the file and below, in formats
that hold shapes and no programs. Other folders must be allowed by the environment variable `OBSTACLEWATCH_MESHES`, a
list as in `PATH`, which workers inherit.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

import numpy as np
import trimesh

FORMATS = (".obj", ".ply", ".stl", ".off", ".gltf", ".glb")
MOST_BYTES = 1 << 28
MOST_TRIANGLES = 2_000_000
ALLOWED = "OBSTACLEWATCH_MESHES"
Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""From axes with y up, as in glTF, to axes with z up."""


def mesh_path(folder: Path, name: str) -> Path:
    """Where a mesh lies that a scene file in `folder` names.

    Raises:
        ValueError: outside that folder and of those allowed, or a format that is not read.
        FileNotFoundError: there is no such file.
    """
    try:
        path = (folder / name).resolve()
        found = path.is_file()
    except (ValueError, OSError, RuntimeError) as error:  # a null in the name, a name too long, links in a ring
        raise ValueError(f"mesh must name a file, got {name!r}: {error}") from error
    allowed = [folder, *(Path(entry) for entry in os.environ.get(ALLOWED, "").split(os.pathsep) if entry)]
    if not any(path.is_relative_to(each.resolve()) for each in allowed):
        raise ValueError(f"mesh file must lie in the scene file's folder, got '{name}'; {ALLOWED} allows another")
    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"mesh file must be one of {', '.join(FORMATS)}, got '{name}'")
    if not found:
        raise FileNotFoundError(f"mesh file must exist, got {folder / name}")
    return path


def read_mesh(path: Path, unit_m: float, up: Literal["z", "y"]) -> trimesh.Trimesh:
    """The triangles of a file, in metres, z up.

    Args:
        path: from `mesh_path`.
        unit_m: metres a unit of the file.
        up: the axis of the file that points up.

    Raises:
        ValueError: too large, or no finite triangles that trimesh can read.
    """
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise ValueError(f"mesh file must have at most {MOST_BYTES} bytes, got {size} in {path.name}")
    try:
        mesh: trimesh.Trimesh = trimesh.load_mesh(path, process=False)  # which would drop points that are not finite
        vertices, faces = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces)
    except Exception as error:  # readers of half a dozen formats raise whatever they like on a damaged file
        raise ValueError(f"mesh file must be one that trimesh reads, got {path.name}: {error}") from error
    if not 0 < len(faces) <= MOST_TRIANGLES:
        raise ValueError(f"mesh file must hold 1 to {MOST_TRIANGLES} triangles, got {len(faces)} in {path.name}")
    if faces.min() < 0 or faces.max() >= len(vertices) or not np.isfinite(vertices).all():
        raise ValueError(f"mesh file must hold triangles between finite points, got others in {path.name}")
    if up == "y":
        vertices = vertices @ Y_UP.T
    return trimesh.Trimesh(unit_m * vertices, faces, process=False)
