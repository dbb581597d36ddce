"""Walks by what decides how hard they are: how clearly they hit or miss, how well the target could be detected."""

from __future__ import annotations

import numpy as np

from benchmarks.scoring.scores import Table
from obstaclewatch.support.arrays import Flags, Ints

OVERLAPS_M, CLEARANCES_M = (0.10, 0.20), (0.30, 0.50)
"""Ends of the classes of collisions and of other walks."""
CLOSENESS = (
    "close: overlap < 10 cm, clearance < 30 cm",
    "between: overlap 10–20 cm, clearance 30–50 cm",
    "clear-cut: overlap ≥ 20 cm, clearance ≥ 50 cm",
)
INDEX_DB = (10.0, 15.0, 20.0)
INDEX = ("index < 10 dB", "index 10–15 dB", "index 15–20 dB", "index ≥ 20 dB")
MOTION = ("target stands", "target moves")
ROUNDING_M = 1e-9


def closeness(table: Table) -> Ints:
    """(n,) class in `CLOSENESS`: of collisions by the overlap, of other walks by the clearance."""
    of_hits = np.searchsorted(OVERLAPS_M, table["overlap_m"] + ROUNDING_M, side="right")
    of_misses = np.searchsorted(CLEARANCES_M, table["clearance_m"] + ROUNDING_M, side="right")
    return np.where(table["collides"], of_hits, of_misses)


def clear_cut(table: Table) -> Flags:
    """(n,) whether a walk hits or misses clearly, and its target stands: the paper's field test."""
    return (closeness(table) == 2) & ~table["moving"]


def strata(table: Table) -> dict[str, Flags]:
    """Name -> (n,) rows, in the order in which they are shown; walks whose index is not known are in none of its."""
    known, index_db = np.isfinite(table["detection_index_db"]), table["detection_index_db"]
    level = np.searchsorted(INDEX_DB, index_db, side="right")
    found = {"all walks": np.ones(len(index_db), dtype=bool)}
    found |= {name: closeness(table) == k for k, name in enumerate(CLOSENESS)}
    found |= {name: known & (level == k) for k, name in enumerate(INDEX)}
    found |= {name: table["moving"] == bool(k) for k, name in enumerate(MOTION)}
    found |= {str(name): table["category"] == name for name in np.unique(table["category"])}
    return found | {
        "clear-cut, target stands": clear_cut(table),
        "clear-cut, stands, index ≥ 15 dB": clear_cut(table) & (index_db >= 15.0),
    }
