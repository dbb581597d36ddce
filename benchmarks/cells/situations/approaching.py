"""A walk towards an obstacle of a named scene."""

from __future__ import annotations

from benchmarks.cells.situations.situation import Situation
from benchmarks.cells.spec import Cell
from scenes import make_approach


def approach_situation(cell: Cell) -> Situation:
    """The approach that the cell names.

    Raises:
        ValueError: an unknown scene, category or phone.
    """
    approach = make_approach(
        scene_name=cell.scene,
        category=cell.category,
        index=cell.index,
        phone_name=cell.phone,
        seed=cell.seed,
        collision=cell.collision,
        **({"beep_period_s": cell.beep.period_s} | cell.approach),
    )
    return Situation(approach.scene, approach.walk, approach.phone, (approach.target,))
