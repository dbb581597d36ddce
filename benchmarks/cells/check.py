"""Whether a cell could run, found out without running it."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields

from benchmarks.cells.detectors import check_detector, paper_settings, standing_form
from benchmarks.cells.equipment import check_equipment
from benchmarks.cells.interference import other_beep
from benchmarks.cells.situations.variation import air_of, changed_phone
from benchmarks.cells.spec import Cell, check_known
from scenes import list_scenes, make_approach
from scenes.obstacles import CATEGORIES
from simulator import Fidelity, Material, Phone

GIVEN = frozenset({"scene_name", "category", "index", "phone_name", "seed", "collision"})
"""Arguments of `make_approach` that a cell gives by itself."""


def check_cell(cell: Cell) -> None:
    """Make everything that a cell's plain values describe.

    Raises:
        ValueError: something is unknown or out of range; the message names the cell.
    """
    with _named(cell):
        beep = cell.beep.design()
        if cell.interferer is not None:
            other_beep(beep, cell.interferer)
        if cell.kind != "scene":  # such a file may bring a phone of its own
            changed_phone(Phone.named(cell.phone), cell.phone_change)
        air_of(cell)
        for name in (cell.scene_change.target_material, cell.scene_change.ground_material):
            if name is not None:
                Material.named(name)
        settings = paper_settings(cell.settings)
        for name in cell.detectors:
            check_detector(standing_form(name) if cell.kind == "standing" else name, settings)
        if cell.kind == "approach":
            _approach(cell)
        _fidelity(cell)


def check_detectors(cell: Cell) -> None:
    """Build the cell's detectors: `benchmarks.cells.equipment.check_equipment`.

    Raises:
        ValueError: a value out of range of a detector; the message names the cell.
    """
    with _named(cell):
        check_equipment(cell)


def check_place(cell: Cell) -> None:
    """Look up the scene and the kind of obstacle of a walk or a standing measurement.

    Raises:
        ValueError: there is none of that name; the message names the cell.
    """
    with _named(cell):
        if cell.kind == "approach" and cell.scene not in list_scenes():
            raise ValueError(f"scene must be one of {list_scenes()}, got '{cell.scene}'")
        if cell.kind in ("approach", "standing") and cell.category not in CATEGORIES:
            raise ValueError(f"category must be one of {sorted(CATEGORIES)}, got '{cell.category}'")


@contextmanager
def _named(cell: Cell) -> Iterator[None]:
    """Whatever is refused within is said with the cell's label."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"cell '{cell.label}': {error}") from error


def _approach(cell: Cell) -> None:
    check_known("approach", cell.approach, set(inspect.signature(make_approach).parameters) - GIVEN)


def _fidelity(cell: Cell) -> Fidelity:
    check_known("fidelity", cell.fidelity, [field.name for field in fields(Fidelity)])
    return Fidelity(**cell.fidelity)
