"""What becomes of an extreme: correct within a limit, refused with a named error, or silently wrong."""

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


Errors = dict[str, Error]
Check = Callable[..., Errors]

DELAY_SAMPLES = 1e-3
"""At 192 kHz: 1.8 um of path, 0.04 degrees of phase at 23 kHz. Single precision errs by this from 30 m of path on."""
LEVEL_DB = 0.01
ECHOES = 0.5
"""None missing, none too many."""


def accepted() -> Errors:
    """What an impossible input comes to if nobody refuses it."""
    return {"accepted": Error(math.inf, 1.0)}


def judged(check: Check, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The verdict over one case, as plain values.

    Returns:
        "verdict"; "worst", the greatest error as a share of its limit; "errors" and "limits" by name; "refused", the
        message of the error that refused the case.

    >>> judged(lambda x: {"square": Error(x * x, 1.0)}, {"x": 2.0})["verdict"]
    'wrong'
    """
    try:
        errors = check(**parameters)
    except ValueError as error:
        return {"verdict": REFUSED, "worst": 0.0, "errors": {}, "limits": {}, "refused": str(error)}
    worst = max(error.share for error in errors.values())
    return {
        "verdict": CORRECT if worst <= 1.0 else WRONG,
        "worst": worst,
        "errors": {name: float(error.value) for name, error in errors.items()},
        "limits": {name: error.limit for name, error in errors.items()},
        "refused": "",
    }
