"""What a cell simulates: a scene, a walk through it, a phone, and the obstacle that the cell is about."""

from __future__ import annotations

from dataclasses import dataclass

from simulator.phone import Phone
from simulator.pose import Walk
from simulator.scene import Scene


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
