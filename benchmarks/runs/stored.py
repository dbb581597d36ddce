"""What files of a run must hold to be read: types and lengths, so that damage is found here and not in a figure."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, ValidationError, model_validator

from benchmarks.cells.association import BEEP_COLUMNS
from benchmarks.cells.spec import first_error
from scenes.files.field_types import matching

Number = Annotated[float, Field(ge=-1e18, le=1e18)] | None
"""JSON lacks NaN: no number is null. The bound is that of 64-bit integers, as which beeps are counted."""
Natural = Annotated[int, Field(ge=0, lt=1 << 63)]
COUNTS = ("beep", "candidates")
Digest = Annotated[str, matching("[0-9a-f]{64}", "64 hexadecimal digits")]
"""Names a file of the run, so it must be no path."""


class _Stored(BaseModel, extra="allow", strict=True):
    """Fields that are not named here are whatever they are."""


class StoredManifest(_Stored):
    """See `benchmarks.runs.manifest`."""

    argv: list[str]
    suite: str
    tier: str
    split: str
    seed: int
    plan: list[Digest]
    title: str = ""
    detectors: list[str] = []
    figures: list[str] = []
    versions: dict[str, str | None] = {}


class DatedManifest(StoredManifest):
    """That of a run which says of itself when it began, and on which source."""

    started: str
    source_sha256: str
    git_revision: str | None
    git_dirty: bool | None


class _Rate(_Stored):
    value: Number
    low: Number
    high: Number


class _Median(_Stored):
    median: Number


class _Measured(_Stored):
    tp: dict[str, _Rate]
    tn: _Rate
    walking: dict[str, _Median]


class StoredSummary(_Stored):
    """The part of summary.json, as `benchmarks.scoring.scores.summary` makes it, that a history shows."""

    cells: Natural
    failed: Natural
    detectors: dict[str, _Measured]


class StoredCost(_Stored):
    """What a cell took."""

    total_s: float = 0.0
    simulate_s: float = 0.0
    recording_s: float = 0.0
    peak_rss_mb: float = 0.0
    detect_s: dict[str, float] = {}
    detect_cpu_s: dict[str, float] = {}
    beeps: int = 0


class _Decisions(_Stored):
    """What a detector stated on the way, in columns."""

    left_m: list[Number]
    probability: list[float]

    @model_validator(mode="after")
    def _even(self) -> _Decisions:
        if len(self.left_m) != len(self.probability):
            raise ValueError(f"decisions must pair, got {len(self.left_m)} and {len(self.probability)}")
        return self


class _Entry(_Stored):
    """One detector on one walk."""

    alert: bool
    alert_time_s: Number
    alert_range_m: Number
    alert_distance_m: Number
    alert_lead_s: Number
    outcome: Literal["TP", "FN", "TN", "FP"]
    decisions: _Decisions
    beeps: list[dict[str, list[Number | bool]]]

    @model_validator(mode="after")
    def _columns(self) -> _Entry:
        for columns in self.beeps:
            missing = [name for name in BEEP_COLUMNS if name not in columns]
            if missing:
                raise ValueError(f"columns over beeps must hold '{missing[0]}'")
            lengths = {len(column) for column in columns.values()}
            if len(lengths) > 1:
                raise ValueError(f"columns over beeps must be equally long, got {sorted(lengths)}")
            for name in COUNTS:
                odd = [value for value in columns[name] if value is None or value % 1 != 0]
                if odd:
                    raise ValueError(f"column '{name}' must hold whole numbers, got {odd[0]}")
        return self


class _Result(_Stored):
    truth: dict[str, Any]
    detectors: dict[str, _Entry]
    loud_echoes_m: Annotated[list[list[float]], Field(min_length=2, max_length=2)] = [[], []]


class _Truth(_Stored):
    """Of a walk that detectors were judged on."""

    targets: list[str]
    collides: bool
    line_collides: bool
    moving: bool
    radius_m: Number
    duration_s: float
    contact_time_s: Number
    miss_distance_m: Number
    overlap_m: Number
    clearance_m: Number
    detection_index_db: Number


class _Walk(_Stored):
    """The part of a cell that tables show."""

    kind: str
    scene: str
    category: str
    phone: str
    index: Natural
    seed: Natural
    range_m: Number
    bearing_rad: Number = None
    detectors: list[str] = []
    variant: dict[str, Any] | None = None
    probe: dict[str, Any] | None = None


class StoredCell(_Stored):
    """One cell's record; see `benchmarks.runs.executors.work`."""

    digest: Digest
    status: Literal["ok", "failed"]
    label: str
    cell: _Walk
    result: _Result | None
    error: str | None

    @model_validator(mode="after")
    def _one_or_the_other(self) -> StoredCell:
        if (self.result is None) is (self.status == "ok") or (self.error is None) is (self.status == "failed"):
            raise ValueError(f"a cell must have a result or an error, as its status '{self.status}' says")
        if self.result is not None and self.result.detectors:
            truth = _truth(self.result.truth)
            for name, entry in self.result.detectors.items():
                if truth.collides and None in entry.decisions.left_m:
                    raise ValueError(f"decisions of '{name}' on a walk that collides must say what was left of it")
                if len(entry.beeps) != len(truth.targets):
                    raise ValueError(
                        f"beeps of '{name}' must be told of {len(truth.targets)} targets, got {len(entry.beeps)}"
                    )
        return self


def _truth(data: dict[str, Any]) -> _Truth:
    try:
        return _Truth.model_validate(data)
    except ValidationError as error:
        raise ValueError(f"truth.{first_error(error, _Truth)}") from error


def json_mapping(text: str, source: str) -> dict[str, Any]:
    """The mapping that JSON text holds.

    Raises:
        ValueError: not JSON, or no mapping; `source` says what.

    >>> json_mapping('{"seed": 3}', "'manifest.json'")
    {'seed': 3}
    """
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{source} must be JSON: {error}") from error
    if not isinstance(found, dict):
        raise ValueError(f"{source} must be a JSON object, got {type(found).__name__}")
    return found


def check_file(path: Path) -> None:
    """Refuse a folder where a file belongs; a path without anything passes.

    Raises:
        ValueError: the message names the path.
    """
    if path.is_dir():
        raise ValueError(f"'{path}' must be a file, got a folder")


def read_json(path: Path) -> dict[str, Any]:
    """The mapping in a JSON file.

    Raises:
        ValueError: as `json_mapping`, or not UTF-8, or a folder.
        FileNotFoundError: there is no such file.
    """
    check_file(path)
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"'{path}' must be JSON: {error}") from error
    return json_mapping(text, f"'{path}'")


def check_stored(data: dict[str, Any], model: type[BaseModel], source: str) -> None:
    """Raise ValueError, which names the field, unless the data fit the model."""
    try:
        model.model_validate(data)
    except ValidationError as error:
        raise ValueError(f"{source}: {first_error(error, model)}") from error
