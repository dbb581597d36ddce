"""Rendering against its floor: the Fourier transform of one beep's block of two channels."""

from __future__ import annotations

import numpy as np

from benchmarks.cells.probes.speed.timing import cpu_ms, fft_ms, require
from benchmarks.cells.situations.approaching import approach_situation
from benchmarks.cells.spec import Cell
from obstaclewatch.support.arrays import Ints
from simulator import Fidelity
from simulator.paths import Paths
from simulator.render import sum_envelopes, to_rate, trace_walk


def against_floor(cell: Cell, arrivals: int = 20, category: str = "wall") -> tuple[dict[str, float], list[str]]:
    """A beep of so many moving paths to each microphone in transforms: in the band, and on to the full rate."""
    walk = cell.model_copy(update={"kind": "approach", "scene": "supermarket", "category": category, "probe": {}})
    setting, beep = approach_situation(walk), cell.beep.design()
    paths, motion, count = trace_walk(setting.scene, setting.phone, setting.walk, beep, Fidelity(**cell.fidelity))
    rows = _rows(paths, count, arrivals)
    some, moving = paths[rows], motion[rows]
    envelope, samples = sum_envelopes(some, moving, beep, count), count * beep.period_samples
    doubled = sum_envelopes(paths[np.tile(rows, 2)], motion[np.tile(rows, 2)], beep, count)
    sound = sum_envelopes(paths[rows[:0]], motion[rows[:0]], beep, count)
    error = np.abs(doubled - 2.0 * envelope + sound).max() / np.abs(envelope).max()
    require(error < 1e-6, f"twice the paths are not twice the sound, by {error:.2g}")
    unit = fft_ms(beep.period_samples)
    in_band = cpu_ms(lambda: sum_envelopes(some, moving, beep, count)) / count
    on = cpu_ms(lambda: to_rate(envelope, setting.phone, beep, samples)) / count
    return {
        "transform_ms": unit, "in_band_ms": in_band, "in_band_ratio": in_band / unit,
        "at_rate_ms": in_band + on, "at_rate_ratio": (in_band + on) / unit,
    }, []  # fmt: skip


def _rows(paths: Paths, count: int, arrivals: int) -> Ints:
    """So many paths of every beep and microphone, some twice where there are fewer."""
    parts = [np.flatnonzero((paths.pose == n) & (paths.mic == m)) for n in range(count) for m in (0, 1)]
    return np.concatenate([np.resize(part, arrivals) for part in parts])
