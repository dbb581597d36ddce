"""What the measures of an obstacle may be: one rule for all kinds, read from the names of their parameters."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar, get_args, get_type_hints

import numpy as np

from obstaclewatch.support.argument_types import as_number, check_counts, check_types

P = ParamSpec("P")
Made = TypeVar("Made")

LEAST_M = 1e-4
"""A tenth of a millimetre: no street has a thinner sheet, and triangles much smaller lose their area to rounding."""
GREATEST_M = 1000.0
MOST_FACETS = 1000


def measured(make: Callable[P, Made]) -> Callable[P, Made]:
    """A function that makes an obstacle, with all its arguments checked by their types and names before it starts.

    A float must be a number, and one in metres (`..._m`) a length. A length of 0 passes where 0 is the default: that is
    a part left out. What is particular to a kind remains its own to check.

    Raises:
        ValueError: from the function it returns; the message gives name, rule and value.
    """
    hints, signature = get_type_hints(make), inspect.signature(make)

    @wraps(make)
    def checked(*args: P.args, **kwargs: P.kwargs) -> Made:
        bound = signature.bind(*args, **kwargs)
        for name, value in bound.arguments.items():
            kinds = get_args(hints[name]) or (hints[name],)
            if not (value is None and type(None) in kinds):
                bound.arguments[name] = _held(name, value, kinds, signature.parameters[name].default)
        return make(*bound.args, **bound.kwargs)

    return checked


def _held(name: str, value: Any, kinds: tuple[Any, ...], default: Any) -> Any:
    """An argument as its function works with it, once it has passed the rules of its kind."""
    if bool in kinds:
        check_types(**{name: (value, bool)})
    elif int in kinds:
        check_counts(1, **{name: value})
        if value > MOST_FACETS:
            raise ValueError(f"{name} must be at most {MOST_FACETS}, got {value}")
        return int(value)
    elif float in kinds:
        value = as_number(name, value)
        if name.endswith("_m") and not (default == 0.0 and value == 0.0):
            require_length(name, value)
    return value


def require_length(name: str, value: float) -> float:
    """The value, if it is a length that an obstacle can have, m.

    Raises:
        ValueError: it is not; the message gives name, rule and value.
    """
    value = as_number(name, value)
    if not (np.isfinite(value) and value > 0.0):
        raise ValueError(f"{name} must be positive, got {value}")
    if not LEAST_M <= value <= GREATEST_M:
        raise ValueError(f"{name} must lie within {LEAST_M:g} to {GREATEST_M:g} m, got {value:g}")
    return float(value)


def require_least(name: str, value: float, least: float, why: str) -> None:
    """Refuse a length below what the parts of a kind need, whose measures are fixed.

    Raises:
        ValueError: the message gives name, rule, reason and value.
    """
    if not value >= least:
        raise ValueError(f"{name} must be at least {least:g} m, {why}, got {value:g}")
