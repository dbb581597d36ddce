"""What things cost, one probe a file: each checks its answers first and times them then, as processor time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from benchmarks.cells.probes.speed.peers import against_peers
from benchmarks.cells.probes.speed.post import past_a_post
from benchmarks.cells.probes.speed.rendering_floor import against_floor
from benchmarks.cells.probes.speed.scaling import growth
from benchmarks.cells.probes.speed.stages import by_stage
from benchmarks.cells.spec import Cell

PROBES: dict[str, Callable[..., tuple[dict[str, float], list[str]]]] = {
    "floor": against_floor,
    "peers": against_peers,
    "post": past_a_post,
    "scaling": growth,
    "stages": by_stage,
}


def speed_result(cell: Cell) -> dict[str, Any]:
    """Numbers by name as `result["speed"]`: milliseconds of processor time, `_ms`, and ratios of one run, `_ratio`.

    `missing` lists peers that are not installed.

    Raises:
        ValueError: an unknown probe or parameter.
        RuntimeError: an answer is wrong, so that its time says nothing.
    """
    if cell.category not in PROBES:
        raise ValueError(f"a probe of speed must be one of {sorted(PROBES)}, got '{cell.category}'")
    found, missing = PROBES[cell.category](cell, **cell.probe)
    total = 1e-3 * sum(value for name, value in found.items() if name.endswith("_ms"))
    cost = {"simulate_s": total, "detect_s": {}, "recording_s": 0.0, "total_s": total}
    return {"truth": {}, "detectors": {}, "speed": {"numbers": found, "missing": missing}, "cost": cost}
