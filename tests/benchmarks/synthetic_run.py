"""A run made up from known outcomes and errors, so that every figure and number can be counted by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.cells.compute import outcome
from benchmarks.cells.spec import Cell
from benchmarks.runs.results import RunData

LEFT_M = [1.5, 0.7, 0.3]
DETECTORS = ("PaperDetector", "DistanceOnlyDetector")
RANGE_ERROR_M, RANGE2_ERROR_M = 0.004, 0.012
BEARING_ERROR_RAD, RADIUS_ERROR_M = math.radians(5.0), 0.02
MANIFEST = {
    "argv": ["run", "paper", "--tier", "smoke", "--set", "scoring.gate_m=0.4"],
    "suite": "paper", "title": "Made up & counted", "tier": "smoke", "split": "test", "seed": 2018,
    "git_revision": "0123abc", "git_dirty": False, "platform": "nowhere", "versions": {"numpy": "2.0"},
}  # fmt: skip


def walk(
    scene: str = "supermarket",
    category: str = "wall",
    phone: str = "galaxy-s5",
    index: int = 0,
    collides: bool = True,
    alert_distance_m: float | None = 2.0,
    detectors: Sequence[str] = DETECTORS,
    radius_m: float = 0.3,
    bearing_rad: float = 0.1,
    probability: Sequence[float] = (),
    recipe: str = "paper",
    **truths: Any,
) -> dict[str, Any]:
    """One walk of four beeps; every detector alerts first `alert_distance_m` before contact (None: not at all).

    `probability` is stated at 1.5, 0.7, 0.3 ... m left; further keywords are of the truth.
    """
    cell = Cell(
        kind="approach", scene=scene, category=category, index=index, phone=phone, seed=index, collision=collides,
        detectors=tuple(detectors), approach={"recipe": recipe},
    )  # fmt: skip
    alert = alert_distance_m is not None
    entry = {
        "alert": alert,
        "alert_time_s": 1.0 if alert else None,
        "alert_range_m": 2.5 if alert else None,
        "alert_distance_m": alert_distance_m if collides else None,
        "alert_lead_s": alert_distance_m / 1.3 if alert and collides else None,
        "outcome": outcome(alert, alert_distance_m or 0.0, collides),
        "decisions": {"left_m": LEFT_M[: len(probability)], "probability": list(probability)},
        "beeps": [beeps([4.0, 3.5, 3.0, 2.5], bearing_rad, radius_m)],
    }
    truth = {
        "targets": ["target"], "collides": collides, "line_collides": collides,
        "contact_time_s": 3.0 if collides else None, "miss_distance_m": 0.0 if collides else 0.4 + 0.1 * index,
        "clearance_m": 0.0 if collides else 0.6, "overlap_m": 0.25 if collides else None, "moving": False,
        "detection_index_db": 18.0, "radius_m": radius_m, "duration_s": 4.0,
    } | truths  # fmt: skip
    return record(cell, truth, dict.fromkeys(detectors, entry))


def standing(range_m: float, index: int = 0, detectors: Sequence[str] = DETECTORS) -> dict[str, Any]:
    """One standing measurement of four beeps."""
    cell = Cell(
        kind="standing", scene="standing", category="wall", index=index, phone="galaxy-s5", seed=index,
        collision=False, range_m=range_m, detectors=tuple(detectors),
    )  # fmt: skip
    truth = {
        "targets": ["target"], "collides": False, "line_collides": False, "contact_time_s": None,
        "miss_distance_m": 0.0, "overlap_m": None, "moving": False, "detection_index_db": None,
        "clearance_m": range_m, "radius_m": 0.3, "duration_s": 0.9,
    }  # fmt: skip
    entry = {
        "alert": False, "alert_time_s": None, "alert_range_m": None, "alert_distance_m": None, "alert_lead_s": None,
        "outcome": "TN",
        "decisions": {"left_m": [], "probability": []}, "beeps": [beeps([range_m] * 4, 0.1, 0.3)],
    }  # fmt: skip
    return record(cell, truth, dict.fromkeys(detectors, entry))


def beeps(range_m: Sequence[float], bearing_rad: float, radius_m: float) -> dict[str, Any]:
    """Columns over beeps with the errors stated above; the first beep has no estimate."""
    truth = np.asarray(range_m, dtype=np.float64)
    count = len(truth)

    def estimated(values: np.ndarray) -> list[float | None]:
        return [None, *values[1:].tolist()]

    return {
        "beep": list(range(count)),
        "time_s": (0.09 * np.arange(count)).tolist(),
        "true_range_m": truth.tolist(),
        "true_range2_m": (truth + 0.1).tolist(),
        "true_ground_range_m": truth.tolist(),
        "low": [False] * count,
        "true_bearing_rad": [bearing_rad] * count,
        "true_signed_bearing_rad": [bearing_rad] * count,
        "true_radius_m": [radius_m] * count,
        "range_m": estimated(truth - RANGE_ERROR_M),
        "range2_m": estimated(truth + 0.1 + RANGE2_ERROR_M),
        "bearing_rad": estimated(np.full(count, bearing_rad + BEARING_ERROR_RAD)),
        "radius_m": estimated(np.full(count, radius_m + RADIUS_ERROR_M)),
        "snr_db": estimated(np.full(count, 25.0)),
        "range_std_m": estimated(np.full(count, RANGE_ERROR_M)),
        "flags": estimated(np.array([0.0, 1.0] * count)[:count]),
        "bearing_std_rad": estimated(np.full(count, BEARING_ERROR_RAD)),
        "candidates": [0, *[2] * (count - 1)],
    }


def record(cell: Cell, truth: dict[str, Any], entries: dict[str, Any]) -> dict[str, Any]:
    """A cell's record as it is stored."""
    return {
        "label": cell.label, "cell": cell.model_dump(mode="json"), "status": "ok", "error": None,
        "result": {"truth": truth, "detectors": entries},
    }  # fmt: skip


def failed(stored: dict[str, Any], error: str = "Traceback\nValueError: no <mesh>") -> dict[str, Any]:
    """The same cell, failed."""
    return {**stored, "status": "failed", "result": None, "error": error}


def made_up_run(folder: Path, cells: Sequence[dict[str, Any]] | None = None, **manifest: Any) -> RunData:
    """A run of these cells, or of `default_cells`, with a cost for each."""
    chosen = tuple(default_cells() if cells is None else cells)
    cost = {
        "simulate_s": 0.2,
        "detect_s": dict.fromkeys(DETECTORS, 0.01),
        "beeps": 10,
        "detect_cpu_s": dict.fromkeys(DETECTORS, 0.01),
        "recording_s": 0.9,
        "total_s": 0.3,
    }
    return RunData(folder, MANIFEST | manifest, chosen, tuple(cost if c["status"] == "ok" else {} for c in chosen))


def default_cells() -> list[dict[str, Any]]:
    """Walls: 3 of 4 collisions alerted in time, 1 of 2 others alerted; campus pedestrians all failed; six standing."""
    walls = [walk(index=k, alert_distance_m=distance) for k, distance in enumerate((2.0, 1.5, 3.0, -0.2))]
    others = [walk(index=4, collides=False, alert_distance_m=None), walk(index=5, collides=False)]
    people = [failed(walk("campus", "pedestrian", "galaxy-note5", index=k)) for k in range(2)]
    return [*walls, *others, *people, *(standing(range_m, k) for range_m in (1.5, 3.0, 5.0) for k in range(2))]
