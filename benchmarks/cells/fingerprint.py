"""Which version of the source computes the cells."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HASHED_FOLDERS = ("obstaclewatch", "simulator", "scenes", "benchmarks/cells")
SUFFIXES = (".py", ".csv", ".json", ".npz", ".ply", ".yaml")


@cache
def source_fingerprint() -> str:
    """SHA-256 over the source and tables of everything that decides a cell's numbers, hexadecimal."""
    total = hashlib.sha256()
    for path in sorted(p for part in HASHED_FOLDERS for p in (ROOT / part).rglob("*") if p.suffix in SUFFIXES):
        total.update(f"{path.relative_to(ROOT).as_posix()}\0".encode())
        total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()
