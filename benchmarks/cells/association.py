"""Which of a detector's candidates is the target: the one whose range is nearest to the true one, within a gate.

Only the range decides. Bearing and radius take no part, so that their errors are not made small by the choice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from obstaclewatch.detection import COLUMNS
from obstaclewatch.support.arrays import Flags, Floats, Ints

ESTIMATES = tuple(name for name in COLUMNS if name not in ("level_db", "closing_speed_m_s"))
"""Columns of a detector's candidates that are stored of the target."""
BEEP_COLUMNS = (
    "beep", "time_s", "true_range_m", "true_range2_m", "low", "true_bearing_rad", "true_radius_m",
    "true_signed_bearing_rad", *ESTIMATES, "flags", "candidates",
)  # fmt: skip
"""Columns over the beeps of a cell: what is true of the target, and what a detector says of it."""


class DetectionLike(Protocol):
    """What is read of one beep's detection, beside `ESTIMATES`: (K,) arrays over its candidates each."""

    @property
    def range_m(self) -> Floats:
        """(K,) range from microphone 0, m."""

    @property
    def flags(self) -> NDArray[np.int_]:
        """(K,) remarks, a combination of `obstaclewatch.Flag`."""


@dataclass(frozen=True)
class Estimates:
    """What a detector said of the target, one row a beep; NaN where it said nothing.

    Attributes:
        columns: (T,) each, of the associated candidate: `ESTIMATES`, and its flags.
        candidates: (T,) how many candidates the beep had.
    """

    columns: dict[str, Floats]
    candidates: Ints

    @property
    def found(self) -> Flags:
        """(T,) whether a candidate was associated."""
        return np.isfinite(self.columns["range_m"])


def nearest_within(range_m: ArrayLike, true_range_m: float, gate_m: float) -> int | None:
    """Index of the range nearest to the true one, None if none is within the gate. NaN ranges are never chosen."""
    miss = np.abs(np.asarray(range_m, dtype=np.float64) - true_range_m)
    if miss.size == 0 or np.isnan(miss).all():
        return None
    nearest = int(np.nanargmin(miss))
    return nearest if miss[nearest] <= gate_m else None


def associate(detections: Sequence[DetectionLike], true_range_m: Floats, gate_m: float) -> Estimates:
    """The target's row of every detection.

    Args:
        detections: T of them.
        true_range_m: (T,) range of the target from microphone 0.
        gate_m: greatest difference of ranges.
    """
    if len(detections) != len(true_range_m):
        raise ValueError(
            f"true_range_m must have one value per detection, got {len(true_range_m)} for {len(detections)}"
        )
    names = (*ESTIMATES, "flags")
    columns = {name: np.full(len(detections), np.nan) for name in names}
    for row, (detection, truth) in enumerate(zip(detections, true_range_m, strict=True)):
        chosen = nearest_within(detection.range_m, float(truth), gate_m)
        if chosen is not None:
            for name in names:
                columns[name][row] = getattr(detection, name)[chosen]
    counts = np.array([np.isfinite(detection.range_m).sum() for detection in detections], dtype=np.int64)
    return Estimates(columns, counts)
