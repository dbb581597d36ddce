"""What a cell simulates: a scene, a walk through it, a phone, and the obstacle that the cell is about."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.cells.spec import Cell
from simulator.phone import Phone
from simulator.pose import Walk
from simulator.scene import Scene


@dataclass(frozen=True)
class Situation:
    """Everything that is rendered and judged.

    Attributes:
        scene, walk, phone: what is rendered.
        targets: names of the obstacles whose estimates are judged.
    """

    scene: Scene
    walk: Walk
    phone: Phone
    targets: tuple[str, ...]


def situation(cell: Cell) -> Situation:
    """Build what the cell asks for.

    Raises:
        ValueError: an unknown scene, category or phone.
    """
    if cell.kind == "standing":
        from benchmarks.cells.standing import standing_situation

        return standing_situation(cell)
    from scenes import make_approach

    approach = make_approach(
        scene_name=cell.scene,
        category=cell.category,
        index=cell.index,
        phone_name=cell.phone,
        seed=cell.seed,
        collision=cell.collision,
        **cell.approach,
    )
    return Situation(approach.scene, approach.walk, approach.phone, (approach.target,))
