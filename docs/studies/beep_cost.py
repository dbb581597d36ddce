"""What a beep costs: milliseconds from two channels of samples to a decision, beep by beep over rendered walks.

python -m docs.studies.beep_cost --walks 10 --rounds 30

Walks are the suite `paper`'s, of its development split, taken evenly. Every round streams all beeps anew from a fresh
state, and a beep counts with its least time over the rounds: what it costs without what else the machine was doing.
"""

from __future__ import annotations

from time import perf_counter

import click
import numpy as np

from benchmarks.cells.compute import recording_of
from benchmarks.cells.equipment import detector_for
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from obstaclewatch.recordings.streaming import StreamingDetector
from obstaclewatch.support.arrays import Floats, Singles

LIMIT_MS = 0.5
HEADER = ("detector", "beeps", "mean", "median", "95 %", "slowest", f"within {LIMIT_MS} ms")


def beep_cost_ms(detector: StreamingDetector, blocks: Singles, rounds: int) -> Floats:
    """(B,) least time of each beep, ms, of (B, 2, period_samples) blocks streamed so often, each time anew."""
    least = np.full(len(blocks), np.inf)
    for _ in range(rounds):
        detector.reset()
        for beep, block in enumerate(blocks):
            begin = perf_counter()
            detector.process(block)
            least[beep] = min(least[beep], perf_counter() - begin)
    return 1e3 * least


def cost_row(name: str, cost_ms: Floats) -> tuple[str, ...]:
    """One detector's line under `HEADER`."""
    mean, middle, most = np.mean(cost_ms), np.median(cost_ms), np.max(cost_ms)
    figures = (f"{value:.3f} ms" for value in (mean, middle, np.quantile(cost_ms, 0.95), most))
    return name, str(len(cost_ms)), *figures, f"{np.mean(cost_ms <= LIMIT_MS):.1%}"


@click.command()
@click.option("--walks", default=10, show_default=True, type=click.IntRange(min=1), help="walks of the suite `paper`")
@click.option("--rounds", default=30, show_default=True, type=click.IntRange(min=1), help="times that each is streamed")
@click.option("--seed", type=click.IntRange(min=0), help="base seed of the walks; the suite's own unless given")
def main(walks: int, rounds: int, seed: int | None) -> None:
    """Print what a beep costs each of the suite's detectors."""
    suite = load_suite("paper", ["split=dev"], seed)
    cells = [cell for cell in plan_cells(suite, "full") if cell.kind == "approach"]
    chosen = [cells[k] for k in np.linspace(0, len(cells) - 1, walks).round().astype(int)]
    cost_ms: dict[str, list[Floats]] = {name: [] for name in suite.detectors}
    for cell in chosen:
        setting, beep, recording = recording_of(cell)
        count = recording.samples.shape[1] // beep.period_samples
        blocks = recording.samples[:, : count * beep.period_samples].reshape(2, count, -1).swapaxes(0, 1).copy()
        for name, costs in cost_ms.items():
            costs.append(beep_cost_ms(detector_for(cell, name, setting, beep), blocks, rounds))
    rows = [HEADER, ("---",) * len(HEADER), *(cost_row(name, np.concatenate(all_)) for name, all_ in cost_ms.items())]
    print("\n".join(f"| {' | '.join(row)} |" for row in rows))


if __name__ == "__main__":
    main()
