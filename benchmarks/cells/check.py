"""Whether a cell could run, found out without running it."""

from __future__ import annotations

from benchmarks.cells.detectors import detector_class, paper_settings, parse_detector
from benchmarks.cells.interference import other_beep
from benchmarks.cells.spec import Cell
from benchmarks.cells.variation import air_of, changed_phone
from obstaclewatch import BeepDesign
from simulator import Fidelity, Material, Phone


def check_cell(cell: Cell) -> None:
    """Make everything that a cell's plain values describe.

    Raises:
        ValueError: something is unknown or out of range; the message names the cell.
    """
    try:
        beep = BeepDesign(**cell.beep.model_dump())
        if cell.interferer is not None:
            other_beep(beep, cell.interferer)
        if cell.kind != "scene":  # such a file may bring a phone of its own
            changed_phone(Phone.named(cell.phone), cell.phone_change)
        air_of(cell)
        for name in (cell.scene_change.target_material, cell.scene_change.ground_material):
            if name is not None:
                Material.named(name)
        paper_settings(cell.settings)
        for name in cell.detectors:
            detector_class(parse_detector(name))
        _fidelity(cell)
    except ValueError as error:
        raise ValueError(f"cell '{cell.label}': {error}") from error


def _fidelity(cell: Cell) -> Fidelity:
    try:
        return Fidelity(**cell.fidelity)
    except TypeError as error:
        raise ValueError(f"fidelity must have the arguments of simulator.Fidelity: {error}") from error
