"""Kinds of values in a scene file."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field


def _no_bool(value: Any) -> Any:
    """YAML reads yes, no, on and off as truth values, which Python would take for 1 and 0."""
    if isinstance(value, bool):
        raise ValueError(f"must be a number, got {value}")
    return value


Number = Annotated[float, Field(allow_inf_nan=False), BeforeValidator(_no_bool)]
Positive = Annotated[Number, Field(gt=0.0)]
NotNegative = Annotated[Number, Field(ge=0.0)]
FARTHEST_PLAN_M = 1e6
"""A thousand kilometres from the origin: beyond, millimetres are lost to rounding, and lengths overflow."""
Coordinate = Annotated[Number, Field(ge=-FARTHEST_PLAN_M, le=FARTHEST_PLAN_M)]
Length = Annotated[Number, Field(gt=0.0, le=FARTHEST_PLAN_M)]
Plan = tuple[Coordinate, Coordinate]


class Strict(BaseModel):
    """A mapping without unknown fields."""

    model_config = ConfigDict(extra="forbid", frozen=True)
