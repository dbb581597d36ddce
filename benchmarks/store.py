"""Cells on disk: one file each, named by content, written whole or not at all.

A cell's file holds only what its inputs decide, so it is the same byte for byte whoever computes it; what it cost
lies beside it in a file of its own.
"""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any


def cell_path(run: Path, digest: str) -> Path:
    """Where a cell lies: cells/ab/abcdef....json."""
    return run / "cells" / digest[:2] / f"{digest}.json"


def cost_path(run: Path, digest: str) -> Path:
    """Where its cost lies."""
    return run / "costs" / digest[:2] / f"{digest}.json"


def write_atomically(path: Path, text: str) -> None:
    """Write a file so that it is there whole or not at all, also after a crash.

    Raises:
        OSError: the folder cannot be written; nothing is left behind.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with partial.open("w", encoding="utf-8", newline="") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def to_json(value: Any) -> str:
    """JSON with sorted keys; NaN, which JSON lacks, is null."""
    return json.dumps(_nan_to_none(value), sort_keys=True, indent=1, allow_nan=False) + "\n"


def read_cell(path: Path, digest: str) -> dict[str, Any] | None:
    """A stored cell, or None where there is none, or only a damaged one, which is then to be computed again."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, json.JSONDecodeError, UnicodeDecodeError):
        return None
    if not isinstance(record, dict) or record.get("digest") != digest or record.get("status") not in ("ok", "failed"):
        return None
    return record


def _nan_to_none(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _nan_to_none(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_nan_to_none(item) for item in value]
    return value
