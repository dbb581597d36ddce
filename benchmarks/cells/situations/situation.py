"""What a cell simulates: a scene, a walk through it, a phone, and the obstacle that the cell is about."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.cells.spec import Cell
from obstaclewatch.recording import Recording
from scenes import GaitWalk
from scenes.streets.approaches import AFTER_CONTACT_S
from scenes.truth.truth import contact
from simulator import Fidelity, render_walk
from simulator.paths import Paths
from simulator.phone.phone import Phone
from simulator.scene.pose import Walk
from simulator.scene.scene import Scene


@dataclass(frozen=True)
class Situation:
    """Everything that is rendered and judged.

    Attributes:
        scene, walk, phone: what is rendered.
        targets: names of the obstacles whose estimates are judged.
        gated: names of those whose own echoes are left out; see `simulator.render_walk`.
    """

    scene: Scene
    walk: Walk
    phone: Phone
    targets: tuple[str, ...]
    gated: tuple[str, ...] = ()


def rendered(setting: Situation, cell: Cell, seen: Callable[[Paths, int], None] | None = None) -> Recording:
    """What the phone records on the walk, with the cell's beep, fidelity and seed; `seen` is told the paths."""
    beep, fidelity = cell.beep.design(), Fidelity(**cell.fidelity)
    return render_walk(setting.scene, setting.phone, setting.walk, beep, fidelity, cell.seed, setting.gated, seen)


def until_contact(walk: Walk, scene: Scene, targets: tuple[str, ...]) -> Walk:
    """A straight walk that ends just after contact with a target, as drawn ones do: the phone would go on into it."""
    if not isinstance(walk, GaitWalk):
        return walk
    met = [contact(scene.obstacle(name), walk).contact_time_s for name in targets]
    ends = [time + AFTER_CONTACT_S for time in met if np.isfinite(time)]
    return replace(walk, duration_s=min([walk.duration_s, *ends]))
