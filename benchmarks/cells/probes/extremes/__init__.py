"""The simulator and the detector at the extremes, one axis a function, with a verdict for every value.

References are closed forms and image sums in extended precision; none shares code with what it checks. Which values
are tried stands in `benchmarks/suites/extremes.yaml`.
"""

from __future__ import annotations

import inspect
from time import perf_counter
from typing import Any

from benchmarks.cells.probes.extremes import air, curved, impossible, rooms, snr, sound, triangulations, walls
from benchmarks.cells.probes.extremes.verdict import Check, judged
from benchmarks.cells.spec import Cell

CHECKS: dict[str, Check] = {
    "wall-distance": walls.wall_distance,
    "wall-offset": walls.wall_offset,
    "grazing": walls.grazing,
    "microphone-distance": walls.microphone_distance,
    "wall-size": walls.wall_size,
    "slivers": triangulations.slivers,
    "triangles": triangulations.triangles,
    "flaws": triangulations.flaw,
    "crack": triangulations.crack,
    "sheets": triangulations.sheets,
    "ball-radius": curved.ball_radius,
    "ball-incidence": curved.ball_incidence,
    "ball-offset": curved.ball_offset,
    "ball-and-wall-offset": curved.ball_and_wall_offset,
    "hollow": curved.hollow,
    "order": rooms.order,
    "corner": rooms.corner,
    "weather": air.weather,
    "sample-rate": sound.sample_rate,
    "beep-length": sound.beep_length,
    "band-edge": sound.band_edge,
    "walking": sound.walking,
    "moving-wall": sound.moving_wall,
    "walk-length": sound.walk_length,
    "rendered-phase": sound.rendered_phase,
    "last-beep": sound.last_beep,
    "impossible": impossible.impossible,
    "detector-snr": snr.detector_snr,
}
"""Axis to its check, from a case's parameters to errors with limits."""


def numerics_result(cell: Cell) -> dict[str, Any]:
    """The verdict over the case that the cell names, as `result["numerics"]`; see `verdict.judged`.

    Raises:
        ValueError: an unknown check or parameter.
    """
    if cell.category not in CHECKS:
        raise ValueError(f"a numerics probe must be one of {sorted(CHECKS)}, got '{cell.category}'")
    check = CHECKS[cell.category]
    try:
        inspect.signature(check).bind(**cell.probe)
    except TypeError as error:
        raise ValueError(f"numerics probe '{cell.category}': {error}") from error
    begin = perf_counter()
    verdict = judged(check, cell.probe)
    cost = {"simulate_s": 0.0, "detect_s": {}, "recording_s": 0.0, "total_s": perf_counter() - begin}
    return {"truth": {}, "detectors": {}, "numerics": verdict, "cost": cost}
