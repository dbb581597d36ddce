"""The replays of a run: computed once, kept beside it, and held against what the run has stored."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed
from tqdm import tqdm

from benchmarks.cells.fingerprint import ROOT, source_fingerprint
from benchmarks.cells.spec import Cell
from benchmarks.replays.choice import ChosenWalk
from benchmarks.store import read_cell, to_json, write_cell

SAME_INSTANT_S = 5e-4
"""Alerts are packed to a tenth of a millisecond."""


def replays_of(folder: Path, walks: Sequence[ChosenWalk], jobs: int = 1, progress: bool = True) -> list[dict[str, Any]]:
    """What the page plays, a walk each, in order.

    A walk that can no longer be computed (its detector's module or scene file is gone) has the reason as "error"
    instead of numbers; one whose alerts are not those the run stored has `faithful` false.

    Args:
        folder: of the run; the numbers are kept in its folder `replays`.
        walks: which.
        jobs: processes to compute them with.
        progress: show a bar where the output is a terminal.

    Raises:
        OSError: the folder cannot be written.
    """
    done = Parallel(n_jobs=jobs, return_as="generator")(delayed(_entry)(folder, walk) for walk in walks)
    quiet = not (progress and sys.stderr.isatty())
    return list(tqdm(done, desc="walks to watch", unit="walk", total=len(walks), disable=quiet))


def replay_path(folder: Path, digest: str) -> Path:
    """Where the numbers of a walk are kept."""
    return folder / "replays" / f"{digest}.json"


def same_alerts(stored: Mapping[str, Any], detectors: Sequence[Mapping[str, Any]]) -> bool:
    """Whether every detector alerts first when the stored result says."""
    return all(_same(stored[entry["name"]], entry["alert_s"]) for entry in detectors)


def _entry(folder: Path, walk: ChosenWalk) -> dict[str, Any]:
    record = walk.record
    named = {"label": record["label"], "phone": record["cell"]["phone"], "why": walk.why}
    try:
        numbers = _kept(folder, Cell.model_validate(record["cell"]))
    except (ValueError, FileNotFoundError) as error:
        return named | {"error": str(error)}
    faithful = same_alerts(record["result"]["detectors"], numbers["detectors"])
    return named | numbers | {"outcomes": _outcomes(record), "faithful": faithful}


def _kept(folder: Path, cell: Cell) -> dict[str, Any]:
    from benchmarks.replays.replay import replay

    digest = cell.digest(source_fingerprint() + packing_fingerprint())
    path = replay_path(folder, digest)
    found = read_cell(path, digest)
    if found is None:
        found = {"digest": digest, "status": "ok", "replay": replay(cell)}
        path.parent.mkdir(exist_ok=True)
        write_cell(path, to_json(found))
    kept: dict[str, Any] = found["replay"]
    return kept


@cache
def packing_fingerprint() -> str:
    """SHA-256 over the source that packs the numbers, hexadecimal."""
    packing = [*sorted((ROOT / "benchmarks" / "replays").glob("*.py")), ROOT / "benchmarks" / "echogram.py"]
    return hashlib.sha256(b"".join(hashlib.sha256(path.read_bytes()).digest() for path in packing)).hexdigest()


def _outcomes(record: Mapping[str, Any]) -> dict[str, str]:
    return {name: entry["outcome"] for name, entry in record["result"]["detectors"].items()}


def _same(stored: Mapping[str, Any], alert_s: float | None) -> bool:
    if not stored["alert"] or alert_s is None:
        return bool(stored["alert"]) == (alert_s is not None)
    return abs(stored["alert_time_s"] - alert_s) < SAME_INSTANT_S
