"""One gate's end, and the exit code of all of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum


class State(Enum):
    """How a gate ended."""

    PASSED = "passed"
    FAILED = "failed"
    UNMEASURED = "unmeasured"


@dataclass(frozen=True)
class Verdict:
    """One gate.

    Attributes:
        group: "claim", "regression", "physics" or "run".
        name: what is judged, e.g. "PaperDetector TN".
        state: how it ended.
        message: what was measured against which bound, for people, with the metric's name.
        n: how many walks, pairs or trials it rests on.
    """

    group: str
    name: str
    state: State
    message: str
    n: int = 0

    @classmethod
    def of(cls, group: str, name: str, passed: bool, message: str, n: int) -> Verdict:
        """Passed or failed on n measurements."""
        return cls(group, name, State.PASSED if passed else State.FAILED, message, n)

    @classmethod
    def unmeasured(cls, group: str, name: str, why: str) -> Verdict:
        """Nothing was measured, or nothing that can be compared."""
        return cls(group, name, State.UNMEASURED, why)


PASSED, FAILED, INCOMPLETE, UNMEASURED = 0, 1, 3, 4


def exit_code(verdicts: Iterable[Verdict], complete: bool = True) -> int:
    """1 if a gate failed, else 3 if the run is incomplete, else 4 if one measured nothing or there is none, else 0."""
    states = [verdict.state for verdict in verdicts]
    if State.FAILED in states:
        return FAILED
    if not complete:
        return INCOMPLETE
    return UNMEASURED if State.UNMEASURED in states or not states else PASSED
