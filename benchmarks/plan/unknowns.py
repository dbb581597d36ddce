"""What nobody has measured of phones and people, drawn for every walk from its stated uncertainty: one table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from benchmarks.cells.spec import Cell, PhoneChange
from simulator import Phone

STREAM = (4, 1)
"""Of a walk's seed; keys of one number are what `make_approach` draws the walk itself from."""
DRAWN = "unknowns drawn"
"""Name of the point of a run at which they are."""


@dataclass(frozen=True)
class Unknown:
    """Offset from an assumed level, uniform between low_db and high_db, with its source.

    Attributes:
        offset: which one of `Offsets` it is.
        name: for people.
    """

    offset: str
    name: str
    low_db: float
    high_db: float
    source: str


UNKNOWNS = (
    Unknown("beep_db", "level of the beep", -5.0, 5.0, "assumed; echoes of four other phones lie within +5 / -6 dB"),
    Unknown("noise_db", "noise", -5.0, 5.0, "assumed; 17-26 dB below the beep at 1 m in four recordings"),
    Unknown("person_db", "reflection of people", -4.0, 4.0, "-5 +- 4 dB, inferred: see the material clothed-person"),
    Unknown("rear_db", "rear microphone", -5.0, 5.0, "14 +- 5 dB front to rear, by recordings"),
)


class Offsets(NamedTuple):
    """One of every unknown, dB; of the assumed levels 0."""

    beep_db: float = 0.0
    noise_db: float = 0.0
    person_db: float = 0.0
    rear_db: float = 0.0


def drawn_offsets(rng: np.random.Generator) -> Offsets:
    """Every unknown drawn, in the order of the table.

    >>> round(drawn_offsets(np.random.default_rng(1)).beep_db, 3)
    0.118
    """
    return Offsets(**{unknown.offset: float(rng.uniform(unknown.low_db, unknown.high_db)) for unknown in UNKNOWNS})


def with_unknowns(cell: Cell) -> Cell:
    """The walk with every unknown drawn, by its own seed: the same walk, phone and people, at other levels."""
    rng = np.random.default_rng(np.random.SeedSequence(cell.seed, spawn_key=STREAM))
    drawn = drawn_offsets(rng)
    preset, asked = Phone.named(cell.phone), cell.phone_change
    level_db = preset.level_spl_db if asked.level_spl_db is None else asked.level_spl_db
    floor_db = preset.noise_spl_db if asked.noise_spl_db is None else asked.noise_spl_db
    changes = {
        "level_spl_db": round(level_db + drawn.beep_db, 3),
        "noise_spl_db": round(floor_db + drawn.noise_db, 3),
        "mic_level_db": (asked.mic_level_db[0], round(asked.mic_level_db[1] + drawn.rear_db, 3)),
    }
    return cell.model_copy(
        update={
            "phone_change": PhoneChange.model_validate(asked.model_dump() | changes),
            "scene_change": cell.scene_change.model_copy(update={"person_level_db": round(drawn.person_db, 3)}),
            "variant": {"name": DRAWN},
        }
    )
