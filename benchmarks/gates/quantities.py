"""One number per walk for each quantity that a gate can watch: what a change of the detector would move."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from benchmarks.runs.results import RunData
from benchmarks.scoring.scores import Table, approach_table, beep_table, chosen, is_narrow, rows_where
from obstaclewatch.support.arrays import Floats

Worse = Literal["up", "either"]


@dataclass(frozen=True)
class Quantity:
    """A column of a walk's beeps, and how it is summed up.

    Attributes:
        unit: for messages.
        greatest: what no value and no shift exceeds: a tolerance of that much is a gate that cannot fail.
        worse: whether only growth is a loss ("up"), or any shift ("either").
        of: from a table to one value a row; NaN without an estimate.
        summary: of the values of a walk, and of the differences between walks: median, or mean for shares and counts.
        rows: whether `of` takes a table of beeps or one of walks.
    """

    unit: str
    greatest: float
    worse: Worse
    of: Callable[[Table], Floats]
    summary: Callable[..., Any]
    rows: Literal["beeps", "walks"] = "beeps"


FARTHEST_M = 15.0
"""Sound is back from there when the paper's next beep starts, 90 ms later: no range, and no error of one, is more."""
WIDEST_M = 1.0
"""Between the microphones of any phone: their ranges differ by no more."""
LOUDEST_DB = 60.0
"""From the noise of a recording to its full scale."""
MOST_CANDIDATES = 100.0
"""Resolved echoes within reach: a Hann chirp's pulses are wider than a hundredth of it."""

QUANTITIES = {
    "range_error": Quantity("m", FARTHEST_M, "up", lambda t: np.abs(t["range_m"] - t["true_range_m"]), np.median),
    "range_bias": Quantity("m", FARTHEST_M, "either", lambda t: t["range_m"] - t["true_range_m"], np.median),
    "range2_error": Quantity("m", FARTHEST_M, "up", lambda t: np.abs(t["range2_m"] - t["true_range2_m"]), np.median),
    "path_difference_bias": Quantity(
        "m",
        WIDEST_M,
        "either",
        lambda t: (t["range2_m"] - t["range_m"]) - (t["true_range2_m"] - t["true_range_m"]),
        np.median,
    ),
    "bearing_error": Quantity(
        "rad", np.pi, "up", lambda t: np.abs(t["bearing_rad"] - t["true_bearing_rad"]), np.median
    ),
    "radius_error": Quantity(
        "m",
        FARTHEST_M,
        "up",
        lambda t: np.where(is_narrow(t), np.abs(t["radius_m"] - t["true_radius_m"]), np.nan),
        np.median,
    ),
    "no_estimate": Quantity("", 1.0, "up", lambda t: np.isnan(t["range_m"]).astype(np.float64), np.mean),
    "candidates": Quantity("", MOST_CANDIDATES, "either", lambda t: t["candidates"].astype(np.float64), np.mean),
    "snr": Quantity("dB", LOUDEST_DB, "either", lambda t: t["snr_db"], np.median),
    "alerts": Quantity("", 1.0, "either", lambda t: t["alert"].astype(np.float64), np.mean, "walks"),
    "alert_distance": Quantity("m", FARTHEST_M, "either", lambda t: t["alert_distance_m"], np.median, "walks"),
}
"""A channel that comes late shows in `path_difference_bias`; a threshold that has moved in `candidates`, `no_estimate`
and `snr`; a vote that has become easier in `alerts`, before rates can tell."""

KINDS = ("approach", "standing")


@dataclass(frozen=True)
class WalkTables:
    """One detector's tables of a kind of cells: a row per beep, and a row per walk (none of standing measurements)."""

    beeps: Table
    walks: Table


def walk_tables(run: RunData, detector: str, kind: str) -> WalkTables:
    """The tables that quantities are taken from."""
    walks = approach_table(run, detector)
    mask = np.full(len(walks["label"]), kind == "approach")
    return WalkTables(beep_table(run, detector, kind), chosen(walks, mask))


def per_walk(tables: WalkTables, quantity: str) -> dict[str, float]:
    """Label of every walk (or standing measurement) with a beep in range -> the quantity; NaN without an estimate.

    Raises:
        ValueError: an unknown quantity.
    """
    check_quantity(quantity)
    asked = QUANTITIES[quantity]
    table = tables.beeps if asked.rows == "beeps" else tables.walks
    labels, owner = np.unique(table["label"], return_inverse=True)
    values = asked.of(table) if len(labels) else np.empty(0)
    found: dict[str, float] = {}
    for k, label in enumerate(labels):
        own = values[owner == k]
        own = own[np.isfinite(own)]
        found[str(label)] = float(asked.summary(own)) if len(own) else float("nan")
    return found


def check_tolerance(quantity: str, tolerance: float) -> None:
    """Refuse a quantity that is unknown, and a tolerance that nothing exceeds.

    Raises:
        ValueError: the message names the quantity, the rule and the value.

    >>> check_tolerance("alerts", 1.0)
    Traceback (most recent call last):
    ValueError: alerts must be below 1, which nothing exceeds, got 1
    """
    check_quantity(quantity)
    check_exceedable(quantity, tolerance, QUANTITIES[quantity].greatest)


def check_quantity(quantity: str) -> None:
    """Refuse a quantity that is unknown, with a ValueError."""
    if quantity not in QUANTITIES:
        raise ValueError(f"a quantity must be one of {sorted(QUANTITIES)}, got '{quantity}'")


def check_exceedable(name: str, at_most: float, greatest: float) -> None:
    """Refuse a greatest value allowed which nothing exceeds, with a ValueError: such a gate cannot fail."""
    if at_most >= greatest:
        raise ValueError(f"{name} must be below {greatest:g}, which nothing exceeds, got {at_most:g}")


def judged_right(run: RunData, detector: str) -> dict[str, tuple[bool, bool]]:
    """Label of every walk -> whether it collides, and whether the detector was right: an alert in time, or none."""
    walks = approach_table(run, detector)
    right = np.where(walks["collides"], walks["true_alert"], ~walks["alert"])
    return {
        str(label): (bool(collides), bool(good))
        for label, collides, good in zip(walks["label"], walks["collides"], right, strict=True)
    }


def tables_where(tables: WalkTables, **values: str | float | None) -> WalkTables:
    """Both tables cut to rows whose columns have these values; None leaves a column free, and walks lack some."""
    of_walks = {column: value for column, value in values.items() if column in tables.walks}
    return WalkTables(rows_where(tables.beeps, **values), rows_where(tables.walks, **of_walks))
