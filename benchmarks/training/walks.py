"""Walks to learn from: of the development split alone, rendered once without noise, then received several times over.

Tracing a walk costs 1.7 s, receiving it once more 0.2 s: noise, its level against the beep's, and the rear microphone
are drawn anew for every reception, the reflection of people for every second walk (`benchmarks.plan.unknowns`). At one
of them the detector is given the walker's own walk ratio, so that what is learned holds with and without it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.cells.association import nearest_within
from benchmarks.cells.compute import distance_left_m, echo_range_m, scored, situation_of, truths_at_beeps
from benchmarks.cells.equipment import detector_for
from benchmarks.cells.situations.situation import Situation, rendered
from benchmarks.cells.spec import Cell
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.plan.unknowns import Offsets, drawn_offsets, with_unknowns
from obstaclewatch import BeepDesign, Detection, TrackingDetector
from obstaclewatch.support.arrays import Floats, Halves, Ints, Singles
from obstaclewatch.tracking.bearing_evidence import NUMBERS
from scenes.truth.truth import GroundTruth
from simulator.phone.noise import noise_rms

SUITE, TIER = "paper", "full"
FEWER = {"max_order": 2, "max_range_m": 5.0}
"""Arguments of `simulator.Fidelity` for walks that take two fifths of the time to trace, and teach nearly as much."""

RECEPTIONS = ("assumed levels", "drawn levels", "walk ratio given")
"""How a walk is received: at the levels that are assumed, at levels drawn, and at others drawn by a detector that knows
its walker's walk ratio."""


@dataclass(frozen=True)
class Walk:
    """A walk as its phone records it without noise.

    Attributes:
        cell, setting: what it is.
        samples: (2, n) without noise.
        left_m: (beeps,) distance left to contact at every emission; NaN on walks without a collision.
        truth: of the target, at every beep.
    """

    cell: Cell
    setting: Situation
    samples: Singles
    left_m: Floats
    truth: GroundTruth

    @property
    def collides(self) -> bool:
        """Whether the walker meets the target."""
        return bool(self.truth.collides)


@dataclass(frozen=True)
class Seen:
    """What `TrackingDetector` has after every beep of one reception.

    Attributes:
        evidence: (beeps, F) see `Evidence`.
        pictures: (beeps, *SHAPE) see `approach_picture`.
        beep: (n,) beeps in which a candidate is the target.
        bearing_evidence: (n, NUMBERS) of these candidates.
    """

    evidence: Floats
    pictures: Halves
    beep: Ints
    bearing_evidence: Floats


def development_cells(recipe: str, seed: int, count: int) -> list[Cell]:
    """So many walks of a recipe, in an order of their own; of further seeds once a seed's are used up."""
    cells: list[Cell] = []
    while len(cells) < count:
        suite = load_suite(SUITE, ["split=dev", f"seed={seed}", f"recipe={recipe}"])
        planned = [cell for cell in plan_cells(suite, TIER) if cell.kind == "approach"]
        cells += [planned[which] for which in np.random.default_rng(seed).permutation(len(planned))]
        seed += 1
    return cells[:count]


def with_people_drawn(cells: list[Cell]) -> list[Cell]:
    """The walks, every second one with the reflection of people drawn."""
    drawn = [cell.model_copy(update={"scene_change": with_unknowns(cell).scene_change}) for cell in cells]
    return [drawn[k] if k % 2 else cell for k, cell in enumerate(cells)]


def with_fewer_echoes(cells: list[Cell], whole: int) -> list[Cell]:
    """The walks, those after so many first ones with `FEWER` echoes."""
    return cells[:whole] + [cell.model_copy(update={"fidelity": cell.fidelity | FEWER}) for cell in cells[whole:]]


def recorded(cell: Cell) -> Walk:
    """Render a walk without noise."""
    setting, beep = situation_of(cell), cell.beep.design()
    quiet = replace(setting, phone=replace(setting.phone, noise_spl_db=-np.inf))
    recording = rendered(quiet, cell)
    truth = truths_at_beeps(cell, setting, beep, recording)[0]
    emitted_s = beep.period_s * np.arange(len(truth.time_s))
    left_m = distance_left_m(setting.walk, emitted_s, truth.contact_time_s)
    return Walk(cell, setting, recording.samples, left_m, truth)


def received(walk: Walk, reception: int) -> Singles:
    """(2, n) the walk with noise; reception 0 at the levels that are assumed, others at levels drawn."""
    rng = np.random.default_rng(np.random.SeedSequence(walk.cell.seed, spawn_key=(reception,)))
    offsets = drawn_offsets(rng) if reception else Offsets()
    beep = walk.cell.beep.design()
    rms = noise_rms(walk.setting.phone, beep.sample_rate_hz) * 10.0 ** ((offsets.noise_db - offsets.beep_db) / 20.0)
    samples = walk.samples * np.array([[1.0], [10.0 ** (offsets.rear_db / 20.0)]], dtype=np.float32)
    noise = rng.standard_normal(samples.shape, dtype=np.float32)
    noise *= np.float32(rms)
    return noise + samples


def seen_at_beeps(walk: Walk, reception: int) -> Seen:
    """What the detector has of a reception; the target is found by its range alone, as in scores."""
    beep, truth = walk.cell.beep.design(), walk.truth
    given = walk.cell.knowledge.model_copy(update={"walk_ratio": RECEPTIONS[reception] == "walk ratio given"})
    cell = walk.cell.model_copy(update={"knowledge": given})
    detector = detector_for(cell, TrackingDetector.__name__, walk.setting, beep)
    true_m = echo_range_m(truth)[:, 0]
    judged = scored(walk.cell, truth)
    evidence, pictures, found = [], [], []
    for number, detection in enumerate(_detections(detector, received(walk, reception), beep)):
        evidence.append(tuple(detector.evidence))
        pictures.append(detector.picture)
        target = nearest_within(detection.range_m, float(true_m[number]), walk.cell.scoring.gate_m)
        if target is not None and judged[number]:
            found.append((number, detector.bearing_evidence[target]))
    which, numbers = zip(*found, strict=True) if found else ((), ())
    rows = np.array(numbers).reshape(-1, NUMBERS)
    return Seen(np.array(evidence), np.array(pictures, dtype=np.float16), np.array(which, dtype=np.int64), rows)


def _detections(detector: TrackingDetector, samples: Singles, beep: BeepDesign) -> Iterator[Detection]:
    for first in range(0, samples.shape[1] - beep.period_samples + 1, beep.period_samples):
        yield detector.process(samples[:, first : first + beep.period_samples], first / beep.sample_rate_hz)
