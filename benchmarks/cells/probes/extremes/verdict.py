"""What becomes of an extreme: correct within a limit, refused by an error that names it, or wrong.

Each check says which of its values cannot be. Only those may be refused, and only by an error that names the value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

CORRECT, REFUSED, WRONG = "correct", "refused", "wrong"


class Error(NamedTuple):
    """How far a result lies from its reference, and how far it may.

    >>> Error(0.02, limit=0.01).share
    2.0
    """

    value: float
    limit: float

    @property
    def share(self) -> float:
        """Of the limit; infinite for what is not a number, which is never right."""
        return abs(self.value) / self.limit if math.isfinite(self.value) else math.inf


class Refusal(NamedTuple):
    """The error by which what cannot be was refused."""

    message: str


Errors = dict[str, Error]
Check = Callable[..., "Errors | Refusal"]

DELAY_SAMPLES = 1e-3
"""At 192 kHz: 1.8 um of path, 0.04 degrees of phase at 23 kHz. Single precision errs by this from 30 m of path on."""
LEVEL_DB = 0.01
ECHOES = 0.5
"""None missing, none too many."""
NEVER = Error(math.inf, 1.0)


def must_refuse(build: Callable[[], object], *named: str) -> Errors | Refusal:
    """What becomes of an input that cannot be.

    Args:
        build: makes it and uses it.
        named: what the error must say, the value among it.

    >>> must_refuse(lambda: int("one"), "'one'").message
    "invalid literal for int() with base 10: 'one'"
    >>> must_refuse(lambda: int("1"), "'1'")
    {'accepted': Error(value=inf, limit=1.0)}
    >>> must_refuse(lambda: int("one"), "must be a number")
    {'unnamed': Error(value=inf, limit=1.0)}
    """
    try:
        build()
    except ValueError as error:
        return Refusal(str(error)) if all(text in str(error) for text in named) else {"unnamed": NEVER}
    return {"accepted": NEVER}


def judged(check: Check, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The verdict over one case, as plain values. An error that the check does not ask for is wrong as well.

    Returns:
        "verdict"; "worst", the greatest error as a share of its limit; "errors" and "limits" by name; "refused", the
        message of the error that refused the case.

    >>> judged(lambda x: {"square": Error(x * x, 1.0)}, {"x": 2.0})["verdict"]
    'wrong'
    >>> judged(lambda x: {"root": Error(math.sqrt(x), 1.0)}, {"x": -2.0})["errors"]
    {'refused': inf}
    """
    message, errors = "", {}
    try:
        found = check(**parameters)
    except ValueError as error:
        message, errors = str(error), {"refused": NEVER}
    else:
        if isinstance(found, Refusal):
            return {"verdict": REFUSED, "worst": 0.0, "errors": {}, "limits": {}, "refused": found.message}
        errors = found
    worst = max(error.share for error in errors.values())
    return {
        "verdict": CORRECT if worst <= 1.0 else WRONG,
        "worst": worst,
        "errors": {name: float(error.value) for name, error in errors.items()},
        "limits": {name: error.limit for name, error in errors.items()},
        "refused": message,
    }
