"""What the paths of a walk cost: processor time of a beep, and that in Fourier transforms of its block, by category.

python -m docs.studies.walk_cost --level auto --walks 2

Walks are the suite `paper`'s, of its development split, each in a scene that is prepared anew. A level has a process of
its own: another would find meshes that have been read. The transform is timed before each walk, as a machine's speed
changes. The last row is the mean over the categories.
"""

from __future__ import annotations

from collections import defaultdict
from time import process_time

import click
import numpy as np

from benchmarks.cells.compute import situation_of
from benchmarks.cells.probes.speed.timing import fft_ms
from benchmarks.cells.spec import Cell
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from simulator import Fidelity
from simulator.render import trace_walk
from simulator.scene.fidelity import LEVELS

Costs = dict[str, list[tuple[int, float, float]]]

HEADER = ("category", "walks", "beeps", "a beep", "transforms")


def walk_cost(cell: Cell, fidelity: Fidelity) -> tuple[int, float, float]:
    """Beeps of a walk, the processor time of its paths, and that of a transform of a beep's block just before, ms."""
    setting, beep = situation_of(cell), cell.beep.design()
    unit_ms, begin = fft_ms(beep.period_samples), process_time()
    _, _, beeps = trace_walk(setting.scene, setting.phone, setting.walk, beep, fidelity)
    return beeps, 1e3 * (process_time() - begin), unit_ms


def rows(costs: Costs) -> list[tuple[str, ...]]:
    """Lines under `HEADER` from the walks of each category, and one for the mean over categories."""
    lines, means = [], []
    for category, walks in costs.items():
        beeps, cost_ms, unit_ms = (np.array(column) for column in zip(*walks, strict=True))
        means.append((cost_ms.sum() / beeps.sum(), (cost_ms / unit_ms).sum() / beeps.sum()))
        lines.append((category, str(len(walks)), str(beeps.sum()), *_stated(*means[-1])))
    every = [walk for walks in costs.values() for walk in walks]
    total = sum(beeps for beeps, _, _ in every)
    return [*lines, ("mean", str(len(every)), str(total), *_stated(*np.mean(means, axis=0)))]


def _stated(cost_ms: float, transforms: float) -> tuple[str, str]:
    return f"{cost_ms:.0f} ms", f"{transforms:.0f}"


@click.command()
@click.option("--level", default="standard", show_default=True, type=click.Choice(sorted(LEVELS)))
@click.option("--walks", default=2, show_default=True, type=click.IntRange(min=1), help="of each street and category")
@click.option("--seed", type=click.IntRange(min=0), help="base seed of the walks; the suite's own unless given")
def main(level: str, walks: int, seed: int | None) -> None:
    """Print what the paths of a beep cost at a level of fidelity."""
    cells = [cell for cell in plan_cells(load_suite("paper", ["split=dev"], seed), "full") if cell.kind == "approach"]
    chosen: dict[tuple[str, str], list[Cell]] = defaultdict(list)
    for cell in cells:
        chosen[cell.scene, cell.category].append(cell)
    fidelity, costs = Fidelity(level=level), Costs()
    for (_, category), some in chosen.items():
        walk_cost(some[walks % len(some)], fidelity)  # reads what was compiled, or compiles
        costs.setdefault(category, []).extend(walk_cost(cell, fidelity) for cell in some[:walks])
    print("\n".join(f"| {' | '.join(row)} |" for row in (HEADER, ("---",) * len(HEADER), *rows(costs))))


if __name__ == "__main__":
    main()
