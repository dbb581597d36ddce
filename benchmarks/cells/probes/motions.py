"""What following motion inside a beep costs and buys: an approach's target, by the degree of its polynomials in time.

Degree 0 freezes the world for each beep: no Doppler shift, and ranges 20 to 33 cm from where the chirp reads them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.cells.probes.compressed_echoes import of_target, peak_levels_db
from benchmarks.cells.probes.echo_errors import envelope_errors
from benchmarks.cells.probes.fidelities import priced
from benchmarks.cells.spec import Cell
from obstaclewatch.signal.matched_filter import MatchedFilter
from obstaclewatch.support.arrays import Complexes
from scenes import make_approach
from simulator import Fidelity, Pose
from simulator.render import sum_envelopes, to_rate, trace_walk
from simulator.scene.pose import Walk

DEGREES = (0, 1, 2, 3)
FINEST = 6
RATE_HZ = 192_000.0


def degree_named(degree: int) -> str:
    """The name of a point."""
    return f"degree {degree}"


@dataclass(frozen=True)
class Excerpt:
    """A walk from an instant on."""

    walk: Walk
    start_s: float
    duration_s: float

    def pose(self, time_s: ArrayLike) -> Pose:
        """(N,) times, s, after the instant, to N poses."""
        return self.walk.pose(np.asarray(time_s) + self.start_s)


def motion_result(cell: Cell) -> dict[str, Any]:
    """Errors by degree as `result["fidelity"]`, shaped as `fidelities.fidelity_result` has them, at one beep.

    Raises:
        ValueError: an unknown scene or category.
    """
    beep = cell.beep.design()
    approach = make_approach(category=cell.category, phone_name=cell.phone, seed=cell.seed, **_drawn(cell))
    share = np.random.default_rng(np.random.SeedSequence(cell.seed, spawn_key=(1,))).uniform(0.2, 0.9)
    walk = Excerpt(approach.walk, share * approach.walk.duration_s, beep.period_s)
    compressor = MatchedFilter(beep, beep.gap_s, rate_hz=RATE_HZ)

    def rendered(degree: int) -> tuple[Complexes, float]:
        start = process_time()
        fidelity = Fidelity(motion_degree=degree)
        paths, motion, count = trace_walk(approach.scene, approach.phone, walk, beep, fidelity)
        own = of_target(paths, approach.target)
        silent = replace(paths.phone, structure_borne=None)
        envelope = sum_envelopes(replace(paths[own], phone=silent), motion[own], beep, count)
        samples = to_rate(envelope, silent, beep, beep.period_samples)
        return compressor.compress(samples).envelope, process_time() - start

    exact, cost = rendered(FINEST)
    found: dict[str, Any] = {"reference": {"level_db": peak_levels_db(exact)}}
    costs = {"reference": cost}
    for degree in DEGREES:
        name = degree_named(degree)
        envelope, costs[name] = rendered(degree)
        found[name] = envelope_errors(envelope, exact, compressor.rate_hz)
    return priced(found, costs)


def _drawn(cell: Cell) -> dict[str, Any]:
    """Scene and number of the approach; even ones collide."""
    return {"scene_name": cell.probe["scene"], "index": cell.probe["index"], "collision": cell.probe["index"] % 2 == 0}
