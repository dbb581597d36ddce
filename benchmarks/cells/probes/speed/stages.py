"""Where the time of a walk goes: scene, paths and their motion, rendering, noise, ground truth, each detector."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.cells.equipment import detector_for
from benchmarks.cells.probes.speed.timing import cpu_ms, require
from benchmarks.cells.situations.approaching import approach_situation
from benchmarks.cells.situations.situation import rendered
from benchmarks.cells.spec import Cell
from scenes import ground_truth
from simulator import Fidelity, PreparedScene
from simulator.phone.noise import noise_samples
from simulator.render import sum_envelopes, to_rate, trace_walk

DETECTORS = ("PaperDetector", "DistanceOnlyDetector", "TrackingDetector")
ROUNDS = 3


def by_stage(
    cell: Cell, category: str = "wall", scene: str = "supermarket", index: int = 0
) -> tuple[dict[str, float], list[str]]:
    """Processor time a beep of one approach, stage by stage, and of all of it."""
    walk = cell.model_copy(
        update={"kind": "approach", "scene": scene, "category": category, "index": index, "probe": {}}
    )
    setting, beep = approach_situation(walk), cell.beep.design()
    recording = rendered(setting, walk)
    require(np.array_equal(recording.samples, rendered(setting, walk).samples), "a walk sounds otherwise when repeated")
    place, fidelity = PreparedScene(setting.scene), Fidelity(**cell.fidelity)
    paths, motion, count = trace_walk(place, setting.phone, setting.walk, beep, fidelity)
    envelope = sum_envelopes(paths, motion, beep, count)
    samples, middles = count * beep.period_samples, beep.period_s * (0.5 + np.arange(count))

    place_and_way = setting.scene, setting.walk, setting.phone

    def detected(name: str) -> list[Any]:
        return list(detector_for(walk, name, setting, beep).stream(recording))

    whole = {
        "scene_ms": lambda: approach_situation(walk),
        "paths_ms": lambda: trace_walk(place, setting.phone, setting.walk, beep, fidelity),
        "sum_ms": lambda: sum_envelopes(paths, motion, beep, count),
        "to_rate_ms": lambda: to_rate(envelope, setting.phone, beep, samples),
        "noise_ms": lambda: noise_samples(setting.phone, samples, beep.sample_rate_hz, np.random.default_rng(1)),
        "truth_ms": lambda: ground_truth(*place_and_way, middles, target=setting.targets[0]),
    } | {f"{name}_ms": lambda name=name: detected(name) for name in DETECTORS}
    found = {name: cpu_ms(call, ROUNDS) / count for name, call in whole.items()}
    return found | {"beep_ms": sum(found.values())}, []
