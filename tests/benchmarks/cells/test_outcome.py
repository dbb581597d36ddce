"""Outcomes of alerts."""

from __future__ import annotations

import pytest

from benchmarks.cells.compute import outcome

NAN = float("nan")


@pytest.mark.parametrize(
    ("alert", "distance_m", "collides", "expected"),
    [
        (True, 2.0, True, "TP"),
        (True, 0.01, True, "TP"),
        (True, 3.5, True, "TP"),  # an alert that began earlier lasts
        (True, 0.0, True, "FN"),
        (True, -0.1, True, "FN"),  # after contact
        (False, NAN, True, "FN"),
        (True, NAN, False, "FP"),
        (False, NAN, False, "TN"),
    ],
)
def test_outcomes(alert: bool, distance_m: float, collides: bool, expected: str) -> None:
    assert outcome(alert, distance_m, collides) == expected
