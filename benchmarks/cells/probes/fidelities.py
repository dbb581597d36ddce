"""What fidelity costs and what it buys: the echo of an approach's target at every level and knob.

The measure of error is the simulator's own finest level, itself held against exact solutions in its tests, and the
measure the detector's: level, time and shape of the target's compressed echo, all its paths summed coherently.
"""

from __future__ import annotations

from time import process_time
from typing import Any

import numpy as np

from benchmarks.cells.probes.compressed_echoes import LAG_RATE_HZ, compressed, levels_db, of_target, peak_levels_db
from benchmarks.cells.probes.echo_errors import envelope_errors, resolved_errors
from benchmarks.cells.spec import Cell
from obstaclewatch.support.arrays import Floats
from scenes import make_approach
from simulator import Fidelity, Paths, Phone, Pose, PreparedScene, Scene, trace_paths

POINTS: dict[str, dict[str, Any]] = {
    "standard": {"level": "standard"},
    "auto 2 dB": {"level": "auto", "tolerance_db": 2.0},
    "auto 0.5 dB": {"level": "auto", "tolerance_db": 0.5},
    "auto 0.1 dB": {"level": "auto", "tolerance_db": 0.1},
    "order 2": {"level": "reference", "max_order": 2},
    "no edges": {"level": "reference", "mechanisms": ("specular", "curved", "kirchhoff")},
    "no integrals": {"level": "reference", "mechanisms": ("specular", "curved", "edges")},
    "loud edges": {"level": "reference", "edge_floor_db": -60.0, "edge_share_db": -50.0},
    "one edge a path": {"level": "reference", "edge_order": 1},
    "facets of 2 cm": {"level": "reference", "facet_m": 0.02},
    "facets of 3 cm": {"level": "reference", "facet_m": 0.03},
    "3 frequencies": {"level": "reference", "band_points": 3},
}


def fidelity_result(cell: Cell) -> dict[str, Any]:
    """Errors of every point as `result["fidelity"]`, and what each cost as `cost["trace_cpu_s"]`.

    Each point has `level_db`, `delay_samples` (192 kHz) and `correlation` of the target's echo, `total_db` of all
    echoes, a list over poses and microphones where the reference's echo is above `MATTERS_DB`, and its `paths`; of the
    target's echoes, each by itself, "resolved_db" and "resolved_samples".

    Raises:
        ValueError: an unknown scene, category or point, or poses below 1.
    """
    chosen = {key: value for key, value in cell.probe.items() if key != "points"}
    points = _points(cell.probe.get("points", list(POINTS)))
    scene, phone, pose, time_s, target = _drawn(cell, **chosen)
    exact, cost = timed_paths(scene, phone, pose, time_s, {"level": "reference"})
    found: dict[str, Any] = {"reference": {"level_db": peak_levels_db(compressed(exact, of_target(exact, target)))}}
    costs = {"reference": cost}
    for name, settings in points.items():
        paths, costs[name] = timed_paths(scene, phone, pose, time_s, settings)
        found[name] = compared(paths, exact, target)
    return priced(found, costs)


def priced(found: dict[str, Any], costs: dict[str, float]) -> dict[str, Any]:
    """The result of a cell that measures points (by name) and what each cost, processor seconds."""
    total = sum(costs.values())
    return {
        "truth": {}, "detectors": {}, "fidelity": found,
        "cost": {"simulate_s": total, "detect_s": {}, "recording_s": 0.0, "total_s": total, "trace_cpu_s": costs},
    }  # fmt: skip


def _points(names: list[str]) -> dict[str, dict[str, Any]]:
    unknown = sorted(set(names) - set(POINTS))
    if unknown:
        raise ValueError(f"points must be among {', '.join(POINTS)}, got {unknown}")
    return {name: POINTS[name] for name in names}


def _drawn(cell: Cell, scene: str, index: int, poses: int = 2) -> tuple[Scene, Phone, Pose, Floats, str]:
    """An approach and instants of it."""
    if poses < 1:
        raise ValueError(f"poses must be at least 1, got {poses}")
    approach = make_approach(scene, cell.category, index, cell.phone, cell.seed, collision=index % 2 == 0)
    rng = np.random.default_rng(np.random.SeedSequence(cell.seed, spawn_key=(index,)))
    time_s = np.sort(rng.uniform(0.05, 0.95, poses)) * approach.walk.duration_s
    return approach.scene, approach.phone, approach.walk.pose(time_s), time_s, approach.target


def timed_paths(
    scene: Scene, phone: Phone, pose: Pose, time_s: Floats, settings: dict[str, Any]
) -> tuple[Paths, float]:
    """What is traced, and the processor time that it takes in a scene that has been prepared, s."""
    prepared, fidelity = PreparedScene(scene), Fidelity(**settings)
    trace_paths(prepared, phone, pose[:1], fidelity, time_s[:1])
    start = process_time()
    paths = trace_paths(prepared, phone, pose, fidelity, time_s)
    return paths, process_time() - start


def compared(paths: Paths, exact: Paths, target: str) -> dict[str, Any]:
    """Errors of a target's compressed echo against a better tracing of the same poses; see `fidelity_result`."""
    ours, theirs = (compressed(each, of_target(each, target)) for each in (paths, exact))
    whole, all_of_it = (levels_db(compressed(each, each.order > 0)).max(axis=1) for each in (paths, exact))
    return {
        **envelope_errors(ours, theirs, LAG_RATE_HZ),
        **resolved_errors(ours, theirs, LAG_RATE_HZ),
        "total_db": (whole - all_of_it).tolist(),
        "paths": len(paths),
    }
