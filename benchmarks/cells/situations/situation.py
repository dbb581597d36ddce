"""What a cell simulates: a scene, a walk through it, a phone, and the obstacle that the cell is about."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.cells.spec import Cell
from obstaclewatch import BeepDesign
from obstaclewatch.recording import Recording
from simulator import Fidelity, render_walk
from simulator.phone.phone import Phone
from simulator.scene.pose import Walk
from simulator.scene.scene import Scene


@dataclass(frozen=True)
class Situation:
    """Everything that is rendered and judged.

    Attributes:
        scene, walk, phone: what is rendered.
        targets: names of the obstacles whose estimates are judged.
        unheard: names of those whose own echoes are left out; see `simulator.render_walk`.
    """

    scene: Scene
    walk: Walk
    phone: Phone
    targets: tuple[str, ...]
    unheard: tuple[str, ...] = ()


def rendered(setting: Situation, cell: Cell) -> Recording:
    """What the phone records on the walk, with the cell's beep, fidelity and seed."""
    beep, fidelity = BeepDesign(**cell.beep.model_dump()), Fidelity(**cell.fidelity)
    return render_walk(
        setting.scene, setting.phone, setting.walk, beep, fidelity=fidelity, seed=cell.seed, unheard=setting.unheard
    )
