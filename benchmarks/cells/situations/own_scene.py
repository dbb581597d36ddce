"""A walk through a scene file of one's own."""

from __future__ import annotations

import hashlib

from benchmarks.cells.situations.situation import Situation, until_contact
from benchmarks.cells.spec import Cell
from scenes import load_encounter
from scenes.files.encounter import scene_files


def scene_situation(cell: Cell) -> Situation:
    """The scene, walk, phone and target of the cell's file; its seed draws what the file leaves open.

    A straight walk ends just after contact with a target.

    Raises:
        ValueError: the file does not fit the schema, or is no longer the one that was planned.
        FileNotFoundError: the file or one of its meshes is missing.
    """
    file = str(cell.approach["file"])
    if scene_digest(file) != cell.approach["sha256"]:
        raise ValueError(f"scene file '{file}' or one of its meshes must not change during a run, but it has")
    met = load_encounter(file, cell.seed, cell.approach["phone"])
    return Situation(met.scene, until_contact(met.walk, met.scene, met.targets), met.phone, met.targets)


def scene_digest(file: str) -> str:
    """SHA-256 over a scene file and its meshes, hexadecimal."""
    parts = [hashlib.sha256(part.read_bytes()).digest() for part in scene_files(file)]
    return hashlib.sha256(b"".join(parts)).hexdigest()
