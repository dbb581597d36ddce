"""Cells on disk: one file each, named by content, sealed by a checksum, written whole or not at all.

A cell's file holds only what its inputs decide, so it is the same byte for byte whoever computes it; what it cost
lies beside it in a file of its own.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.runs.stored import StoredCell, StoredCost, check_file, check_stored, json_mapping, read_json
from obstaclewatch.support.whole_file import whole_file


def cell_path(run: Path, digest: str) -> Path:
    """Where a cell lies: cells/ab/abcdef....json."""
    return run / "cells" / digest[:2] / f"{digest}.json"


def cost_path(run: Path, digest: str) -> Path:
    """Where its cost lies."""
    return run / "costs" / digest[:2] / f"{digest}.json"


def write_atomically(path: Path, text: str) -> None:
    """Write a file so that it is there whole or not at all, also after the machine crashed.

    Raises:
        OSError: the folder cannot be written; nothing is left behind.
    """
    write_bytes_atomically(path, text.encode(), lasting=True)


def write_bytes_atomically(path: Path, data: bytes, lasting: bool = False) -> None:
    """The same of bytes, as pictures are; the folder is made where it is missing."""
    with whole_file(path, lasting) as partial:
        try:
            partial.write_bytes(data)
        except FileNotFoundError:
            path.parent.mkdir(parents=True, exist_ok=True)
            partial.write_bytes(data)


def write_cell(path: Path, record: str) -> None:
    """Store a record, JSON text from `to_json`, with the checksum of that text as its first entry.

    Whole or not at all if the process is killed. A crash of the machine may leave it damaged, which the checksum
    finds: waiting for the disk would cost 4 ms a cell.

    Raises:
        OSError: as `write_atomically`.
    """
    write_bytes_atomically(path, (_seal(record) + record[1:]).encode())


def write_cost(path: Path, cost: str) -> None:
    """Store what a cell cost; nothing but statistics is lost with it."""
    write_bytes_atomically(path, cost.encode())


def read_cost(path: Path) -> dict[str, Any]:
    """What a cell cost, empty where that is not known."""
    try:
        cost = read_json(path)
        check_stored(cost, StoredCost, str(path))
    except (FileNotFoundError, ValueError):
        return {}
    return cost


def read_cell(path: Path, digest: str) -> dict[str, Any] | None:
    """A stored cell, or None where there is none, or only a damaged one, which is then to be computed again.

    Raises:
        ValueError: its checksum is right, but it is not what this version stores; with file, field and rule.
    """
    found = read_sealed(path, digest)
    if found is not None:
        check_stored(found, StoredCell, f"'{path}' must be a cell as this version stores it")
    return found


def read_sealed(path: Path, digest: str) -> dict[str, Any] | None:
    """A record of `write_cell` of any shape, or None where there is none, or only a damaged one.

    Raises:
        ValueError: a folder.
    """
    check_file(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (FileNotFoundError, UnicodeDecodeError):
        return None
    record = "{" + text[len(_seal("")) :]
    if not text.startswith(_seal(record)):
        return None
    try:
        found = json_mapping(record, str(path))
    except ValueError:
        return None
    return found if found.get("digest") == digest else None


def to_json(value: Any) -> str:
    """JSON with sorted keys; NaN, which JSON lacks, is null."""
    return json.dumps(_nan_to_none(value), sort_keys=True, indent=1, allow_nan=False) + "\n"


def point_to(folder: Path, link: Path) -> None:
    """Make `link` a symbolic link to a folder beside it, replacing an older one in one step."""
    partial = link.with_name(f".{link.name}.{os.getpid()}.partial")
    partial.unlink(missing_ok=True)
    try:
        partial.symlink_to(folder.name, target_is_directory=True)
        os.replace(partial, link)
    finally:
        partial.unlink(missing_ok=True)


@contextmanager
def only_one_process(run: Path) -> Iterator[None]:
    """Hold a run's folder while it is computed, and clear what an earlier process was killed over.

    Raises:
        ValueError: another process holds it.
    """
    run.mkdir(parents=True, exist_ok=True)
    with (run / ".lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise ValueError(f"a run must be computed by one process at a time; another works on '{run}'") from error
        for partial in run.rglob(".*.partial"):
            partial.unlink()
        yield


def _seal(record: str) -> str:
    return f'{{\n "sha256": "{hashlib.sha256(record.encode()).hexdigest()}",'


def _nan_to_none(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _nan_to_none(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_nan_to_none(item) for item in value]
    return value
