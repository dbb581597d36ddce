"""The replays of a run: computed once, kept beside it, and held against what the run has stored."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed
from pydantic import ValidationError
from tqdm import tqdm

from benchmarks.cells.fingerprint import ROOT, source_fingerprint
from benchmarks.cells.memory import return_freed_memory
from benchmarks.cells.spec import Cell
from benchmarks.report.replays.chosen_walks import ChosenWalk
from benchmarks.runs.store import read_sealed, to_json, write_cell

SAME_INSTANT_S = 5e-4
"""Alerts are packed to a tenth of a millisecond."""


def replays_of(folder: Path, walks: Sequence[ChosenWalk], jobs: int = 1) -> list[dict[str, Any]]:
    """What the page plays, a walk each, in order; see `replays_begun`."""
    return replays_begun(folder, walks, jobs)()


def replays_begun(folder: Path, walks: Sequence[ChosenWalk], jobs: int = 1) -> Callable[[], list[dict[str, Any]]]:
    """What waits for the walks that the page plays and hands them over, in order.

    Several processes begin at once, so that the caller can do something else meanwhile; one begins when it is asked.

    A walk that can no longer be computed (its detector's module or scene file is gone) has the reason as "error"
    instead of numbers; one whose alerts are not those the run stored has `faithful` false.

    Args:
        folder: of the run; the numbers are kept in its folder `replays`.
        walks: which.
        jobs: processes to compute them with.

    Raises:
        OSError: the folder cannot be written; what is handed back raises it.
    """
    digests = [_digest(walk.record) for walk in walks]
    stored = {k: _kept(folder, digest) for k, digest in enumerate(digests)}
    found = {k: numbers for k, numbers in stored.items() if numbers is not None}
    missing = [k for k in stored if k not in found]
    done = Parallel(n_jobs=jobs, return_as="generator")(delayed(_computed)(walks[k].record["cell"]) for k in missing)

    def all_of_them() -> list[dict[str, Any]]:
        shown = tqdm(done, "walks", len(missing), unit="walk", disable=not sys.stderr.isatty())
        for k, numbers in zip(missing, shown, strict=True):
            found[k] = numbers
            if "error" not in numbers:
                write_cell(replay_path(folder, digests[k]), to_json(_sealed(digests[k], numbers)))
        return [_entry(walk, found[k]) for k, walk in enumerate(walks)]

    return all_of_them


def replay_path(folder: Path, digest: str) -> Path:
    """Where the numbers of a walk are kept."""
    return folder / "replays" / f"{digest}.json"


def same_alerts(stored: Mapping[str, Any], detectors: Sequence[Mapping[str, Any]]) -> bool:
    """Whether every detector alerts first when the stored result says."""
    return all(_same(stored[entry["name"]], entry["alert_s"]) for entry in detectors)


def _computed(stored_cell: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of a walk, or "error": why it cannot be computed any more."""
    from benchmarks.report.replays.replay import replay

    try:
        return replay(Cell.model_validate(stored_cell))
    except ValidationError as error:
        return {"error": f"its settings are of another version of the source: {error.errors()[0]['msg']}"}
    except (ValueError, FileNotFoundError) as error:
        return {"error": str(error)}
    finally:
        return_freed_memory()


def _entry(walk: ChosenWalk, numbers: Mapping[str, Any]) -> dict[str, Any]:
    record = walk.record
    named = {"label": record["label"], "phone": record["cell"]["phone"], "why": walk.why, **numbers}
    if "error" in numbers:
        return named
    faithful = same_alerts(record["result"]["detectors"], numbers["detectors"])
    return named | {"outcomes": _outcomes(record), "faithful": faithful}


def _sealed(digest: str, numbers: Mapping[str, Any]) -> dict[str, Any]:
    return {"digest": digest, "status": "ok", "replay": numbers}


def _kept(folder: Path, digest: str) -> dict[str, Any] | None:
    """What was packed before; None where nothing or only a damaged file is there."""
    stored = read_sealed(replay_path(folder, digest), digest)
    return None if stored is None or not isinstance(stored.get("replay"), dict) else stored["replay"]


def _digest(record: Mapping[str, Any]) -> str:
    """Names the packed numbers by the cell and by the source that computes and packs it."""
    parts = to_json(record["cell"]), source_fingerprint(), packing_fingerprint()
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


@cache
def packing_fingerprint() -> str:
    """SHA-256 over the source that packs the numbers, hexadecimal."""
    packing = [*sorted((ROOT / "benchmarks" / "report" / "replays").glob("*.py")), ROOT / "benchmarks" / "echogram.py"]
    return hashlib.sha256(b"".join(hashlib.sha256(path.read_bytes()).digest() for path in packing)).hexdigest()


def _outcomes(record: Mapping[str, Any]) -> dict[str, str]:
    return {name: entry["outcome"] for name, entry in record["result"]["detectors"].items()}


def _same(stored: Mapping[str, Any], alert_s: float | None) -> bool:
    if not stored["alert"] or alert_s is None:
        return bool(stored["alert"]) == (alert_s is not None)
    return abs(stored["alert_time_s"] - alert_s) < SAME_INSTANT_S
