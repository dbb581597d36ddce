"""A run on disk, read back: manifest and cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from benchmarks.runs.store import cell_path, cost_path, read_cell, read_cost
from benchmarks.runs.stored import StoredManifest, check_stored, read_json


@dataclass(frozen=True)
class RunData:
    """One run.

    Attributes:
        folder: where it lies.
        manifest: how it came about; see `benchmarks.runs.manifest`.
        cells: the records of its cells in the order of the plan; see `benchmarks.runs.runner`.
        costs: what each cost, in the same order; empty where unknown.
    """

    folder: Path
    manifest: dict[str, Any]
    cells: tuple[dict[str, Any], ...]
    costs: tuple[dict[str, Any], ...] = ()

    @property
    def ok(self) -> tuple[dict[str, Any], ...]:
        """The cells that did not fail."""
        return tuple(cell for cell in self.cells if cell["status"] == "ok")

    def part(self, kept: Sequence[int]) -> RunData:
        """The run with these of its cells alone."""
        costs = tuple(self.costs[k] for k in kept) if self.costs else ()
        return replace(self, cells=tuple(self.cells[k] for k in kept), costs=costs)


def load_run(folder: str | Path) -> RunData:
    """Read a run's manifest and every cell that its plan names and that is there whole.

    Raises:
        ValueError: the folder holds no run, or its manifest is damaged, or a cell is of another version.
    """
    folder = Path(folder)
    path = folder / "manifest.json"
    if not path.is_file():
        raise ValueError(f"a run folder must hold manifest.json, got '{folder}'")
    manifest = read_manifest(path)
    cells, costs = [], []
    for digest in manifest["plan"]:
        record = read_cell(cell_path(folder, digest), digest)
        if record is None:
            continue
        cells.append(record)
        costs.append(read_cost(cost_path(folder, digest)))
    return RunData(folder, manifest, tuple(cells), tuple(costs))


def read_manifest(path: Path) -> dict[str, Any]:
    """What is stored of how a run came about.

    Raises:
        ValueError: it is damaged.
    """
    held = read_json(path)
    check_stored(held, StoredManifest, f"'{path}' must be the manifest of a run")
    return held
