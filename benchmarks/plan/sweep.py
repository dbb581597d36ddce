"""Sweeps: the same cells at many points of any parameters.

A point is a mapping from dotted names to values, such as {"beep.start_hz": 16000.0, "air.temperature_c": 35.0}. Every
cell of a suite is planned once at every point, with the same seed: the walks of two points are the same walks.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product
from typing import Annotated, Any, Literal

import numpy as np
import scipy
from pydantic import BaseModel, Discriminator, Field, Tag, ValidationError, field_validator, model_validator

from benchmarks.cells.spec import Cell, first_error, variant_text
from benchmarks.plan.parameters import WHOLE, check_name, check_parts, path_of
from scenes.files.field_types import Number, Whole

Point = dict[str, Any]
NAME = "name"


class Range(BaseModel, extra="forbid", frozen=True):
    """An interval that is sampled.

    Attributes:
        low, high: its ends; both are points of a grid.
        count: points of a grid; random and Latin hypercube sweeps ignore it.
        scale: "linear", or "log" for even steps in the logarithm.
    """

    low: Number
    high: Number
    count: Annotated[Whole, Field(ge=2)] = 5
    scale: Literal["linear", "log"] = "linear"

    @model_validator(mode="after")
    def _in_order(self) -> Range:
        if not self.low < self.high:
            raise ValueError(f"low must lie below high, got {self.low} and {self.high}")
        if self.scale == "log" and self.low <= 0.0:
            raise ValueError(f"low must be positive on a log scale, got {self.low}")
        return self

    def at(self, share: float) -> float:
        """The value at a share of the way, 0 to 1; to 12 digits, so that cells have short names."""
        if self.scale == "log":
            return float(f"{self.low * (self.high / self.low) ** share:.12g}")
        return float(f"{self.low + (self.high - self.low) * share:.12g}")

    @property
    def grid(self) -> list[float]:
        """`count` values from end to end."""
        return [self.at(k / (self.count - 1)) for k in range(self.count)]


def _which(values: Any) -> str | None:
    """Which of both is meant: without this, a mistake in a range is reported as one in a list as well."""
    if isinstance(values, Range | dict):
        return "Range"
    return "list" if isinstance(values, list | tuple) else None


Values = Annotated[
    Annotated[Range, Tag("Range")] | Annotated[list[Any], Tag("list")],
    Discriminator(
        _which,
        custom_error_type="no_values",
        custom_error_message="must be a list of values or a range with low and high",
    ),
]


MEMBERS: dict[str, type[BaseModel]] = {"Range": Range}
"""For `first_error`: what pydantic calls the union's members."""


class Sweep(BaseModel, extra="forbid", frozen=True):
    """Which points are visited.

    Attributes:
        method: "grid" takes every combination, "one-at-a-time" the unchanged suite and then every value alone,
            "list" the points as they are written, "random" and "latin-hypercube" `samples` points of the ranges.
        over: values or ranges by dotted name, for all methods but "list".
        points: for "list"; a point may also have a `name`, by which labels and figures call it.
        samples, seed: of "random" and "latin-hypercube".
    """

    method: Literal["grid", "one-at-a-time", "list", "random", "latin-hypercube"] = "grid"
    over: dict[str, Values] = {}
    points: tuple[Point, ...] = ()
    samples: Annotated[Whole, Field(ge=1)] = 16
    seed: Annotated[Whole, Field(ge=0)] = 0

    @field_validator("over")
    @classmethod
    def _some_values(cls, over: dict[str, Values]) -> dict[str, Values]:
        check_parts(over)
        empty = [name for name, values in over.items() if isinstance(values, list) and not values]
        if empty:
            raise ValueError(f"a swept parameter must have values, got none for {empty}")
        return over

    @model_validator(mode="after")
    def _fits_method(self) -> Sweep:
        check_parts(name for point in self.points for name in point if name != NAME)
        if self.method == "list":
            if not self.points or self.over:
                raise ValueError("method 'list' must have points and no over")
        elif not self.over or self.points:
            raise ValueError(f"method '{self.method}' must have over and no points")
        if self.method in ("random", "latin-hypercube"):
            listed = [name for name, values in self.over.items() if isinstance(values, list)]
            if listed:
                raise ValueError(f"method '{self.method}' must have ranges with low and high, got lists for {listed}")
        return self

    @property
    def size(self) -> int:
        """How many points there are, without making them."""
        if self.method == "list":
            return len(self.points)
        if self.method in ("random", "latin-hypercube"):
            return self.samples
        counts = [each.count if isinstance(each, Range) else len(each) for each in self.over.values()]
        return 1 + sum(counts) if self.method == "one-at-a-time" else math.prod(counts)

    def visited(self) -> list[Point]:
        """The points in their order."""
        if self.method == "list":
            return [dict(point) for point in self.points]
        if self.method in ("random", "latin-hypercube"):
            return self._sampled()
        values = {name: each.grid if isinstance(each, Range) else each for name, each in self.over.items()}
        if self.method == "one-at-a-time":
            return [{}, *({name: value} for name, each in values.items() for value in each)]
        return [dict(zip(values, combination, strict=True)) for combination in product(*values.values())]

    def _sampled(self) -> list[Point]:
        rng, shape = np.random.default_rng(self.seed), (self.samples, len(self.over))
        latin = self.method == "latin-hypercube"
        shares = scipy.stats.qmc.LatinHypercube(shape[1], rng=rng).random(shape[0]) if latin else rng.random(shape)
        ranges = [each for each in self.over.values() if isinstance(each, Range)]
        return [
            {name: each.at(float(share)) for name, each, share in zip(self.over, ranges, row, strict=True)}
            for row in shares
        ]


def at_point(cell: Cell, point: Mapping[str, Any]) -> Cell:
    """The cell at a point of a sweep.

    Raises:
        ValueError: a name that no cell has, or a value out of range.
    """
    if not point:
        return cell
    data = cell.model_dump(mode="json")
    for name, value in point.items():
        if name == NAME:
            continue
        check_name(name)
        if name in WHOLE:
            data[WHOLE[name]] = [value] if name == "detector.name" else value
        else:
            _put(data, name, value)
    data["variant"] = data["variant"] | dict(point)
    try:
        return Cell.model_validate(data)
    except ValidationError as error:
        raise ValueError(f"sweep, at {variant_text(dict(point))}: {first_error(error, Cell)}") from error


def value_at(cell: Mapping[str, Any], name: str) -> Any:
    """What a stored cell has under a swept parameter's name; None where it leaves that open.

    >>> value_at({"beep": {"start_hz": 16000.0}, "air": {}}, "beep.start_hz")
    16000.0
    """
    if name in WHOLE:
        found = cell[WHOLE[name]]
        return found[0] if name == "detector.name" and len(found) == 1 else found
    node: Any = cell
    for part in path_of(name):
        node = (node or {}).get(part)
    return node


def _put(data: dict[str, Any], name: str, value: Any) -> None:
    *parents, last = path_of(name)
    node = data
    for parent in parents:
        node[parent] = node.get(parent) or {}
        node = node[parent]
        if not isinstance(node, dict):
            raise ValueError(f"swept '{name}' must name a value inside mappings, but '{parent}' is {node!r}")
    node[last] = value
