"""What is measured when a cause of error is removed: the points of a sweep against its first, walk by walk."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.cells.spec import counts_as
from benchmarks.figures.bench.error_budget import detected_enough
from benchmarks.figures.measured import finite_quantile, strata
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import variants
from benchmarks.scoring.paired import change_of
from benchmarks.scoring.scores import LEFT_M, Table, approach_table, beep_table, chosen
from benchmarks.scoring.scores import in_time as alerts_in_time
from benchmarks.scoring.statistics import exact_rate, paired_interval, quantile_with_interval
from obstaclewatch.support.arrays import Flags, Floats, Strings

Outcomes = dict[str, bool]
"""By walk."""


@dataclass(frozen=True)
class Point:
    """What one detector made of the walks at one point of a sweep.

    Attributes:
        walks, beeps: see `benchmarks.scoring.scores`; `walk` in both names the walk alike at every point.
    """

    walks: Table
    beeps: Table

    def of(self, column: str, value: str) -> Point:
        """The walks whose column has that value; all for an empty column."""
        if not column:
            return self
        return Point(*(chosen(table, table[column] == value) for table in (self.walks, self.beeps)))


@dataclass(frozen=True)
class Effect:
    """A rate with a cause of error removed, against the same walks as they are; in percent.

    Attributes:
        before, value: the rate as it is and now; NaN without walks.
        low, high: the rate as it is and the paired 95 % interval of the change; of the first point the exact own.
        gained, lost, n: walks that are counted now and were not, the other way round, and all that both have.
        p: exact two-sided McNemar.
    """

    before: float
    value: float
    low: float
    high: float
    gained: int
    lost: int
    n: int
    p: float


@dataclass(frozen=True)
class Spread:
    """Absolute errors over all beeps with an estimate: median, its 95 % interval over walks, upper quantile."""

    median: float
    low: float
    high: float
    upper: float


Count = Callable[[Point], Outcomes]


def points_of(run: RunData, detector: str) -> dict[str, Point]:
    """By point of the sweep, the first of which everything is held against; empty for a run without a sweep."""
    parts = variants(run)
    walked = {name: part for name, part in parts.items() if any(counts_as(c["cell"], "approach") for c in part.cells)}
    return {name: _at_point(part, detector) for name, part in walked.items()} if len(walked) > 1 else {}


def groups(run: RunData) -> list[tuple[str, str, str]]:
    """(title, column, value) of all walks, of every category and of every scene."""
    by_column = [(value, column, value) for column in ("category", "scene") for value in strata(run, column)]
    return [("all walks", "", ""), *by_column]


def in_time(point: Point) -> Outcomes:
    """Whether a collision is alerted with a metre left."""
    return _outcomes(point.walks, alerts_in_time(point.walks, LEFT_M[0]), point.walks["collides"])


def before_contact(point: Point) -> Outcomes:
    """Whether a collision is alerted before contact, however late."""
    return _outcomes(point.walks, point.walks["true_alert"], point.walks["collides"])


def no_alert(point: Point) -> Outcomes:
    """Whether a walk without a collision raises no alert."""
    return _outcomes(point.walks, ~point.walks["alert"], ~point.walks["collides"])


def false_alerts(point: Point) -> Outcomes:
    """Whether a walk raises a false alert; over all walks."""
    walks = point.walks
    return _outcomes(walks, walks["alert"] & ~walks["collides"], np.ones(len(walks["walk"]), dtype=bool))


def detected(point: Point) -> Outcomes:
    """Whether a collision's target is detected in enough beeps; see `benchmarks.figures.bench.error_budget`."""
    return _outcomes(point.walks, detected_enough(point.walks, point.beeps), point.walks["collides"])


def effect(count: Count, first: Point, now: Point) -> Effect:
    """A rate at a point of the sweep against the sweep's first point."""
    before, after = count(first), count(now)
    shared = before.keys() & after.keys()
    change = change_of(before, after)
    base = exact_rate(sum(before[walk] for walk in shared), len(shared))
    value = 100.0 * base.value
    if first is now:
        return Effect(value, value, 100.0 * base.low, 100.0 * base.high, 0, 0, base.n, 1.0)
    low, high = paired_interval(change.gained, change.lost, change.n)
    shifted = 100.0 * (base.k + change.gained - change.lost) / base.n if base.n else np.nan
    low, high = (float(np.clip(value + 100.0 * end, 0.0, 100.0)) for end in (low, high))
    return Effect(value, shifted, low, high, change.gained, change.lost, change.n, change.p)


def bearing_deg(point: Point) -> Floats:
    """(beeps,) absolute errors of the bearing, degrees; NaN without an estimate."""
    return np.rad2deg(np.abs(point.beeps["bearing_rad"] - point.beeps["true_bearing_rad"]))


def range_cm(point: Point) -> Floats:
    """(beeps,) absolute errors of the range, cm; NaN without an estimate."""
    return 100.0 * np.abs(point.beeps["range_m"] - point.beeps["true_range_m"])


def spread(errors: Floats, point: Point, upper: float) -> Spread:
    """Median and upper quantile of the errors of a point's beeps."""
    middle, low, high, _ = quantile_with_interval(errors, 0.5, point.beeps["walk"])
    return Spread(middle, low, high, finite_quantile(errors, upper))


def medians_of_shared_beeps(first: Point, now: Point) -> tuple[float, float]:
    """Median errors of the bearing, degrees, as it is and now, over the beeps that both have an estimate for.

    What is detected only now is often what is hard to judge, so medians over all beeps do not compare by themselves.
    """
    before, after = (_by_beep(point) for point in (first, now))
    shared = before.keys() & after.keys()
    if not shared:
        return np.nan, np.nan
    old, new = (float(np.median([errors[beep] for beep in shared])) for errors in (before, after))
    return old, new


def _at_point(part: RunData, detector: str) -> Point:
    """Tables with the walks' own names: labels hold the point of the sweep too."""
    names = {c["label"]: f"{c['cell']['scene']}/{c['cell']['category']}/{c['cell']['index']}" for c in part.cells}
    walks, beeps = approach_table(part, detector), beep_table(part, detector, "approach")
    return Point(*(table | {"walk": _renamed(table["label"], names)} for table in (walks, beeps)))


def _renamed(labels: Strings, names: Mapping[str, str]) -> Strings:
    return np.array([names[label] for label in labels.tolist()], dtype=np.str_)


def _outcomes(walks: Table, counted: Flags, among: Flags) -> Outcomes:
    return dict(zip(walks["walk"][among].tolist(), counted[among].tolist(), strict=True))


def _by_beep(point: Point) -> dict[tuple[str, int], float]:
    errors = bearing_deg(point)
    known = np.isfinite(errors)
    beeps = zip(point.beeps["walk"][known].tolist(), point.beeps["beep"][known].tolist(), strict=True)
    return dict(zip(beeps, errors[known].tolist(), strict=True))
