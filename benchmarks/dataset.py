"""A labelled data set of a suite's walks: which walks, in which split, and the files that describe them all."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

import pandas as pd
import yaml
from jinja2 import Environment, PackageLoader, StrictUndefined

from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.cells.spec import Cell
from benchmarks.cells.walk_files import FOLDERS, checksum, file_of, walk_name, write_walk
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import Suite, Tier
from benchmarks.runs.executors import Executor
from benchmarks.runs.manifest import manifest
from benchmarks.runs.runner import Tally, run_cells
from benchmarks.runs.store import cell_path, read_cell, to_json, write_atomically, write_bytes_atomically
from benchmarks.scoring.frames import cell_row, frame_of, swept_names
from simulator.field.not_modelled import NOT_MODELLED

TEST_SHARE, VALIDATION = 0.2, 8
"""A fifth of the walks are drawn of the suite's split `test`; of the others about one in eight is for validation."""
SPLITS = ("train", "validation", "test")
BOOKS = ".export"
"""Folder with what is needed to go on."""

Split = tuple[str, Cell]


def split_walks(suite: Suite, walks: int) -> list[Split]:
    """So many cells and the split of each; those of a smaller number are among those of a larger one.

    All points of a sweep of one walk are in one split. "test" shares no seed with the others; scene files and the
    six stored bodies of pedestrians are in all splits.

    Raises:
        ValueError: fewer than one walk, or a suite that has none.
    """
    if walks < 1:
        raise ValueError(f"walks must be at least 1, got {walks}")
    tests = round(TEST_SHARE * walks)
    seen = _first_cells(suite.model_copy(update={"split": "dev"}), walks - tests)
    unseen = _first_cells(suite.model_copy(update={"split": "test"}), tests)
    parts = [("validation" if cell.seed % VALIDATION == 0 else "train", cell) for cell in seen]
    return parts + [("test", cell) for cell in unseen]


def write_data_set(
    folder: Path, suite: Suite, walks: Sequence[Split], executor: Executor, argv: Sequence[str]
) -> Tally:
    """Write what is missing of a data set, each walk as soon as it is done, then its table, card, licence and loader.

    A set grows, but does not shrink: fewer walks than are there are refused. Their files would lie in the folder
    without a row in its table, and to remove them would throw away hours of simulation for a mistyped number.

    Raises:
        ValueError: the folder holds something else than a data set, or one of another suite or source, or more walks
            than these, or files that are missing or have changed since they were written; or another process works on
            it.
        OSError: a file cannot be written; what is done is kept.
    """
    _check_same(folder, suite)
    _check_not_fewer(folder, walks)
    write_atomically(folder / "suite.yaml", _resolved(suite))  # first: by it the folder is known to be a data set's
    for part in FOLDERS:
        (folder / part).mkdir(parents=True, exist_ok=True)
    cells, books = [cell for _, cell in walks], folder / BOOKS
    write_atomically(books / "manifest.json", to_json(manifest(suite, "full", cells, argv)))
    tally = run_cells(books, cells, executor, work=partial(write_walk, folder=folder))
    table = frame_of(list(_rows(folder, walks)))
    write_bytes_atomically(folder / "walks.parquet", table.to_parquet(index=False), lasting=True)
    for name, text in _texts(suite, table, argv).items():
        write_atomically(folder / name, text)
    return tally


def _first_cells(suite: Suite, count: int) -> list[Cell]:
    """The first cells of an order in which every stratum has its share at any length (that of Sainte-Lague)."""
    if count == 0:
        return []
    bare = suite.model_copy(update={"detectors": (), "tiers": {"full": Tier(fraction=1.0)}, "probes": ()})
    cells = _bare(plan_cells(bare, "full"))
    if len(cells) < count:
        cells = _bare(plan_cells(_enlarged(bare, -(-count // len(cells))), "full"))
    sizes = Counter(map(_stratum, cells))
    return sorted(cells, key=lambda cell: (cell.index + 0.5) / sizes[_stratum(cell)])[:count]


def _bare(cells: Sequence[Cell]) -> list[Cell]:
    """Without detectors: a walk is the same whoever runs on it."""
    return [cell.model_copy(update={"detectors": (), "detector_sources": {}}) for cell in cells]


def _stratum(cell: Cell) -> tuple[Any, ...]:
    return cell.kind, cell.scene, cell.category, cell.range_m, cell.bearing_rad, str(cell.variant)


def _enlarged(suite: Suite, times: int) -> Suite:
    """The suite with so many times its walks."""
    data = suite.model_dump()
    for part in [*data["groups"], *([data["standing"]] if data["standing"] else [])]:
        part["counts"] = {category: times * count for category, count in part["counts"].items()}
    for own in data["scenes"]:
        own["count"] *= times
    return Suite.model_validate(data | {"detectors": ("PaperDetector",)})


def _check_same(folder: Path, suite: Suite) -> None:
    there = folder / "suite.yaml"
    other = [] if there.is_file() or not folder.is_dir() else sorted(path.name for path in folder.iterdir())
    if other:
        raise ValueError(f"'{folder}' must be new, empty or hold a data set, but it has no suite.yaml and '{other[0]}'")
    if there.is_file() and there.read_text(encoding="utf-8") != _resolved(suite):
        raise ValueError(f"'{folder}' must be new or hold a data set of the same suite and source, but {there} differs")


def _check_not_fewer(folder: Path, walks: Sequence[Split]) -> None:
    asked = {walk_name(cell) for _, cell in walks}
    there = {path.stem for part, ending in FOLDERS.items() for path in (folder / part).glob(f"*.{ending}")}
    if left := sorted(there - asked):
        raise ValueError(
            f"walks must include all that '{folder}' holds, got {len(asked)} without {len(left)} of them, such as "
            f"'{left[0]}'; ask for as many as there are, or export to a new folder"
        )


def _resolved(suite: Suite) -> str:
    data = suite.model_dump(mode="json", exclude={"detectors", "figures", "tiers"})
    return yaml.safe_dump(data | {"source_sha256": source_fingerprint()}, sort_keys=False)


def _rows(folder: Path, walks: Sequence[Split]) -> Iterator[dict[str, Any]]:
    """A row a walk that is there."""
    version, swept = source_fingerprint(), swept_names(cell.variant for _, cell in walks)
    for split, cell in walks:
        digest = cell.digest(version)
        record = read_cell(cell_path(folder / BOOKS, digest), digest)
        if record is None or record["status"] != "ok":
            continue
        name = walk_name(cell)
        for part, written in record["result"]["files"].items():
            path = file_of(folder, part, name)
            if not path.is_file() or checksum(path) != written:
                found = "has changed" if path.is_file() else "is missing"
                raise ValueError(
                    f"'{path}' must be there as it was written, but {found}; without "
                    f"'{cell_path(folder / BOOKS, digest)}' the same command makes it again"
                )
        beep = {f"beep_{key}": value for key, value in cell.beep.model_dump().items()}
        row = {"walk": name, "split": split} | cell_row(record, swept) | beep | record["result"]["truth"]
        yield {key: value for key, value in row.items() if key not in ("status", "error")}


def _texts(suite: Suite, table: pd.DataFrame, argv: Sequence[str]) -> dict[str, str]:
    """Card, loader, and the licence where there is one."""
    licence = _licence()
    templates = Environment(
        loader=PackageLoader("benchmarks"), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    loader = (Path(__file__).parent / "templates" / "load_walks.py.txt").read_text(encoding="utf-8")
    counts = pd.crosstab([table.kind, table.scene, table.category], table.split).reindex(columns=SPLITS, fill_value=0)
    card = templates.get_template("data_card.md.j2").render(
        suite=suite, table=table, counts=counts.reset_index().to_dict("records"), loader=loader,
        command=shlex.join(["obstaclewatch", *argv]), hours=f"{table.duration_s.sum() / 3600.0:.2g}",
        not_modelled=NOT_MODELLED, source=source_fingerprint()[:12], with_licence=licence is not None,
    )  # fmt: skip
    return {"README.md": card, "load.py": loader} | ({} if licence is None else {"LICENSE": licence})


def _licence() -> str | None:
    """The bench's, as it was installed; None for sources that were not."""
    try:
        files = distribution("obstaclewatch").files or []
    except PackageNotFoundError:
        return None
    return next((file.read_text() for file in files if file.name == "LICENSE"), None)
