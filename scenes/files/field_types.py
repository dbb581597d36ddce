"""Kinds of values in a scene file."""

from __future__ import annotations

import re
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field


def no_bool(value: Any) -> Any:
    """YAML reads yes, no, on and off as truth values, which Python would take for 1 and 0."""
    if isinstance(value, bool):
        raise ValueError(f"must be a number, got {value}")
    return value


def matching(pattern: str, rule: str) -> AfterValidator:
    """For a text that a pattern describes as a whole; who breaks it reads the rule, not the pattern.

    >>> from pydantic import TypeAdapter
    >>> TypeAdapter(Annotated[str, matching("[01]*", "0 and 1 only")]).validate_python("011")
    '011'
    """

    def checked(text: str) -> str:
        if re.fullmatch(pattern, text) is None:
            raise ValueError(f"must be {rule}, got {text!r}")
        return text

    return AfterValidator(checked)


Real = Annotated[float, BeforeValidator(no_bool)]
Whole = Annotated[int, BeforeValidator(no_bool)]
Number = Annotated[Real, Field(allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0.0)]
NotNegative = Annotated[Number, Field(ge=0.0)]
FARTHEST_PLAN_M = 1e6
"""A thousand kilometres from the origin: beyond, millimetres are lost to rounding, and lengths overflow."""
Coordinate = Annotated[Number, Field(ge=-FARTHEST_PLAN_M, le=FARTHEST_PLAN_M)]
Length = Annotated[Number, Field(gt=0.0, le=FARTHEST_PLAN_M)]
FASTEST_M_S = 30.0
"""Of an obstacle, 108 km/h: phone and obstacles must close in at less than a tenth of the speed of sound."""
Plan = tuple[Coordinate, Coordinate]


class Strict(BaseModel):
    """A mapping without unknown fields."""

    model_config = ConfigDict(extra="forbid", frozen=True)
