"""What a physics check hands back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Measured:
    """The worst of n comparisons with an exact solution.

    Attributes:
        value: the worst found, in `unit`.
        n: how many comparisons; 0 if nothing came back to compare.
    """

    value: float
    unit: str
    n: int


Check = Callable[[int], Measured]
"""From a seed to the worst found."""
