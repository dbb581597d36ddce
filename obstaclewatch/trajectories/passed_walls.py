"""Passed walls: one that is passed echoes no more before it is reached.

A wall mirrors at the foot of its normal through the phone, which lies R sin(a) aside of the walker's line where the
wall stands at the angle a and the distance R. As R falls the foot wanders inwards. A wall that is hit reaches across
the line, so that it is received until it is met; one that is passed ends aside of the line, and is received no more
once its foot would lie beyond that end.
"""

from __future__ import annotations

from obstaclewatch.support.compiled import inlined

GAP_M = (0.08, 0.75)
"""Between the walker's side and the end of a wall that is passed, evenly; what ends farther off is no near miss."""
LEAST_RECEIVED = 0.02
"""Share of passed walls that are received from where none should be: off their ends."""


def ends_of_passed(half_width_m: float) -> tuple[float, float]:
    """How far aside of a walker's line walls end that are passed, at least and at most."""
    least_m, most_m = GAP_M
    return half_width_m + least_m, half_width_m + most_m


@inlined
def still_received(foot_m: float, ends_m: tuple[float, float]) -> float:
    """Share of passed walls whose end lies nearer to the walker's line than their foot, and which are detected so.

    Args:
        foot_m: how far aside the foot lies; infinite for what is no wall, and is received until it is passed.
        ends_m: how far aside walls end that are passed, at least and at most.
    """
    least_m, most_m = ends_m
    return min(max((foot_m - least_m) / (most_m - least_m), LEAST_RECEIVED), 1.0)
