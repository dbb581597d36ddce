"""A run on disk: one atomic file per cell, found again by the cell's digest."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Store:
    """The folder of one run, results/<suite>/<run>/."""

    folder: Path

    def cell_path(self, digest: str) -> Path:
        """Where the cell of that digest is kept: cells/ab/<digest>.json."""
        return self.folder / "cells" / digest[:2] / f"{digest}.json"

    def read_cell(self, digest: str) -> dict[str, Any] | None:
        """The record of a cell; None if it was not computed yet."""
        path = self.cell_path(digest)
        return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None

    def write_cell(self, record: dict[str, Any]) -> None:
        """Keep the record of a cell; it appears whole or not at all."""
        write_json(self.cell_path(record["digest"]), record, indent=None)

    def done(self, digests: Iterable[str]) -> set[str]:
        """Digests of the cells that were computed and did not fail."""
        records = ((digest, self.read_cell(digest)) for digest in digests)
        return {digest for digest, record in records if record is not None and record["status"] == "ok"}

    def read_json(self, name: str) -> dict[str, Any]:
        """A file of the run, such as "manifest.json".

        Raises:
            ValueError: there is none: the folder is not a run, or the run did not get that far.
        """
        path = self.folder / name
        if not path.is_file():
            raise ValueError(f"a run must hold {name}, got none in '{self.folder}'")
        return json.loads(path.read_text(encoding="utf-8"))


def write_json(path: Path, value: Any, indent: int | None = 2) -> None:
    """Write JSON without NaN, whole or not at all."""
    write_text(path, json.dumps(value, indent=indent, allow_nan=False) + "\n")


def write_text(path: Path, text: str) -> None:
    """Write a text file, whole or not at all."""
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
