"""A run on disk: one atomic file per cell, named after the cell's digest, and what it cost beside it."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any


def cell_path(run: Path, digest: str) -> Path:
    """Where the record of a cell is kept: cells/ab/<digest>.json."""
    return run / "cells" / digest[:2] / f"{digest}.json"


def cost_path(run: Path, digest: str) -> Path:
    """Where times and memory of a cell are kept: costs/ab/<digest>.json. They differ from run to run."""
    return run / "costs" / digest[:2] / f"{digest}.json"


def read_cell(path: Path, digest: str) -> dict[str, Any] | None:
    """The record of a cell; None if it was not computed yet.

    Raises:
        ValueError: the file is damaged, or holds another cell.
    """
    if not path.is_file():
        return None
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except json.JSONDecodeError as error:
        raise ValueError(f"'{path}' must be JSON: {error}; delete it to compute the cell again") from error
    if record.get("digest") != digest:
        raise ValueError(f"'{path}' must hold cell {digest}, got {record.get('digest')}")
    return record


def to_json(value: Any) -> str:
    """Text of nested numbers; what is not finite becomes null, which JSON has instead of NaN."""
    return json.dumps(_nulled(value), indent=1, allow_nan=False) + "\n"


def write_atomically(path: Path, text: str) -> None:
    """Write a text file and its folders; it appears whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with partial.open("w", encoding="utf-8", newline="") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def _nulled(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _nulled(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_nulled(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
