"""What earlier runs measured on each walk, in one small file with the reasons of its changes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence, Sized
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import BaseModel, model_validator

from benchmarks.gates.quantities import KINDS, QUANTITIES, judged_right, per_walk, walk_tables
from benchmarks.runs.manifest import options_in
from benchmarks.runs.results import RunData
from benchmarks.runs.store import write_atomically
from benchmarks.runs.stored import check_stored, read_json
from scenes.files.field_types import matching


class IncompatibleBaselineError(ValueError):
    """The file is a baseline that this version cannot compare with."""


FORMAT = 1
DIGITS = 6


Bits = Annotated[str, matching("[01]*", "0 and 1 only")]


class _Columns(BaseModel, strict=True):
    """Quantities over labels, as stored."""

    labels: list[str]
    columns: dict[str, list[float | None]]

    @model_validator(mode="after")
    def _even(self) -> _Columns:
        return _equally_long(self, len(self.labels), self.columns.values())


class _Run(BaseModel, strict=True):
    """One run, as stored."""

    source: str
    walks: list[str]
    collides: Bits
    right: dict[str, Bits]
    values: dict[str, dict[str, _Columns]]

    @model_validator(mode="after")
    def _even(self) -> _Run:
        return _equally_long(self, len(self.walks), [self.collides, *self.right.values()])


class _Update(BaseModel, strict=True):
    """One entry of the history, as stored."""

    date: str
    reason: str
    runs: dict[str, dict[str, str]]


class _File(BaseModel, strict=True):
    """The file."""

    history: list[_Update]
    runs: dict[str, _Run]


Stored = TypeVar("Stored", bound=BaseModel)


def _equally_long(found: Stored, length: int, columns: Iterable[Sized]) -> Stored:
    if any(len(column) != length for column in columns):
        raise ValueError(f"columns must have a value for each of {length} labels")
    return found


@dataclass(frozen=True)
class RunBaseline:
    """One run's walks.

    Attributes:
        source: fingerprint of the source that measured them.
        collides: walk's label -> whether it is on a collision course.
        right: detector -> label -> whether it was right.
        values: detector -> kind -> quantity -> label -> value; NaN without an estimate.
    """

    source: str
    collides: dict[str, bool]
    right: dict[str, dict[str, bool]]
    values: dict[str, dict[str, dict[str, dict[str, float]]]]


@dataclass(frozen=True)
class Baseline:
    """Runs by key, and the history: date, reason, runs and counts of every update."""

    runs: dict[str, RunBaseline]
    history: tuple[dict[str, Any], ...]


def run_key(run: RunData) -> str:
    """Which runs measure the same walks: "suite/tier/split/seed", and what cuts them: " --limit 5"."""
    cut = [word for name in ("--only", "-k", "--limit") for word in options_in(run.manifest["argv"], name)]
    return " ".join(["/".join(str(run.manifest[name]) for name in ("suite", "tier", "split", "seed")), *cut])


def baseline_of(run: RunData) -> RunBaseline:
    """What a run measured.

    Raises:
        ValueError: cells of the run failed or are missing, or two of its walks have the same label.
    """
    if len(run.ok) < len(run.manifest["plan"]):
        raise ValueError(
            f"a baseline must rest on a whole run, got {len(run.ok)} good cells of {len(run.manifest['plan'])}"
        )
    labels = [record["label"] for record in run.ok]
    if len(set(labels)) < len(labels):
        raise ValueError(f"walks of a run must have different labels, got {len(set(labels))} for {len(labels)} cells")
    detectors = sorted({name for record in run.ok for name in (record["result"].get("detectors") or {})})
    judged = {name: judged_right(run, name) for name in detectors}
    return RunBaseline(
        source=str(run.manifest["source_sha256"]),
        collides={label: collides for found in judged.values() for label, (collides, _) in found.items()},
        right={name: {label: right for label, (_, right) in found.items()} for name, found in judged.items()},
        values={name: {kind: _values(run, name, kind) for kind in KINDS} for name in detectors},
    )


def _values(run: RunData, detector: str, kind: str) -> dict[str, dict[str, float]]:
    tables = walk_tables(run, detector, kind)
    return {quantity: per_walk(tables, quantity) for quantity in QUANTITIES}


def updated(baseline: Baseline | None, runs: Sequence[RunData], reason: str) -> Baseline:
    """The baseline with these runs in place of earlier ones of the same key, and why.

    Raises:
        ValueError: an empty reason, no run, two runs of one key, or a run that cannot serve.
    """
    if not reason.strip():
        raise ValueError("a baseline must be updated with a reason, got an empty one")
    fresh = {run_key(run): baseline_of(run) for run in runs}
    if not runs or len(fresh) < len(runs):
        raise ValueError(
            f"a baseline must be updated from runs of different suite, tier, split or seed, "
            f"got {[run_key(run) for run in runs]}"
        )
    entry = {
        "date": datetime.now(UTC).date().isoformat(),
        "reason": reason.strip(),
        "revision": runs[0].manifest.get("git_revision"),
        "runs": {key: _counts(found) for key, found in fresh.items()},
    }
    before = baseline or Baseline({}, ())
    return Baseline(before.runs | fresh, (*before.history, entry))


def baseline_walks(found: RunBaseline, detector: str) -> dict[str, bool]:
    """Label of every walk that a detector was judged on -> whether it collides."""
    return {label: found.collides[label] for label in found.right.get(detector, {})}


def _counts(found: RunBaseline) -> dict[str, str]:
    """Detector -> "TP 18/57, TN 46/60", so that the history tells what a change did."""
    lines = {}
    for name, right in found.right.items():
        parts = []
        for rate, side in (("TP", True), ("TN", False)):
            asked = [good for label, good in right.items() if found.collides[label] is side]
            parts.append(f"{rate} {sum(asked)}/{len(asked)}")
        lines[name] = ", ".join(parts)
    return lines


def save_baseline(path: Path, baseline: Baseline) -> None:
    """Write it: columns over the labels, one line each."""
    runs = {key: _packed(found) for key, found in baseline.runs.items()}
    data = {"format": FORMAT, "history": list(baseline.history), "runs": runs}
    write_atomically(path, _lines(data) + "\n")


def load_baseline(path: Path) -> Baseline:
    """Read it.

    Raises:
        IncompatibleBaselineError: another format.
        ValueError: there is none, or it is damaged.
    """
    if not path.is_file():
        raise ValueError(
            f"a baseline must exist, got '{path}'; `obstaclewatch baseline update RUN --reason ...` makes one"
        )
    data = read_json(path)
    if data.get("format") != FORMAT:
        found = data.get("format")
        raise IncompatibleBaselineError(f"baseline '{path}' must have format {FORMAT}, got {found!r}: make it anew")
    check_stored(data, _File, f"baseline '{path}' is damaged")
    return Baseline({key: _unpacked(run) for key, run in data["runs"].items()}, tuple(data["history"]))


def _packed(found: RunBaseline) -> dict[str, Any]:
    walks = sorted(found.collides)
    return {
        "source": found.source,
        "walks": walks,
        "collides": _bits([found.collides[label] for label in walks]),
        "right": {name: _bits([right[label] for label in walks]) for name, right in found.right.items() if right},
        "values": {
            name: {kind: _packed_values(columns) for kind, columns in kinds.items()}
            for name, kinds in found.values.items()
        },
    }


def _packed_values(columns: dict[str, dict[str, float]]) -> dict[str, Any]:
    labels = sorted({label for column in columns.values() for label in column})
    rounded = {name: [_rounded(column.get(k, np.nan)) for k in labels] for name, column in columns.items() if column}
    return {"labels": labels, "columns": rounded}


def _rounded(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None


def _unpacked(data: dict[str, Any]) -> RunBaseline:
    walks = data["walks"]
    return RunBaseline(
        source=data["source"],
        collides=dict(zip(walks, _flags(data["collides"]), strict=True)),
        right={name: dict(zip(walks, _flags(bits), strict=True)) for name, bits in data["right"].items()},
        values={
            name: {kind: _unpacked_values(packed) for kind, packed in kinds.items()}
            for name, kinds in data["values"].items()
        },
    )


def _unpacked_values(packed: dict[str, Any]) -> dict[str, dict[str, float]]:
    return {
        name: {
            label: float("nan") if value is None else float(value)
            for label, value in zip(packed["labels"], column, strict=True)
        }
        for name, column in packed["columns"].items()
    }


def _bits(flags: Sequence[bool]) -> str:
    return "".join("1" if flag else "0" for flag in flags)


def _flags(bits: str) -> list[bool]:
    return [bit == "1" for bit in bits]


def _lines(value: Any, depth: int = 0) -> str:
    """JSON with mappings on lines of their own and each list on one, so that a diff shows which column moved."""
    if not isinstance(value, dict) or not value:
        return json.dumps(value, allow_nan=False)
    pad = " " * (depth + 1)
    rows = [f"{pad}{json.dumps(key)}: {_lines(value[key], depth + 1)}" for key in sorted(value)]
    return "{\n" + ",\n".join(rows) + "\n" + " " * depth + "}"
