"""Which of a detector's candidates is the target: the one whose range is nearest to the true one, within a gate.

Only the range decides. Bearing and radius take no part, so that their errors are not made small by the choice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from obstaclewatch.support.arrays import Flags, Floats, Ints

COLUMNS = (
    "range_m", "range2_m", "bearing_rad", "radius_m", "snr_db", "range_std_m", "bearing_std_rad",
    "radius_std_m", "flags",
)  # fmt: skip


class DetectionLike(Protocol):
    """What is read of one beep's detection: (K,) arrays over its candidates."""

    @property
    def index(self) -> int:
        """Number of the beep, from 0."""

    @property
    def range_m(self) -> Floats:
        """(K,) range from microphone 0, m."""

    @property
    def range2_m(self) -> Floats:
        """(K,) range from microphone 1, m; NaN without one."""

    @property
    def bearing_rad(self) -> Floats:
        """(K,) walking angle; NaN without one."""

    @property
    def radius_m(self) -> Floats:
        """(K,) radius; NaN without one."""

    @property
    def snr_db(self) -> Floats:
        """(K,) peak over noise."""

    @property
    def range_std_m(self) -> Floats:
        """(K,) claimed standard deviation of range_m; NaN without a claim."""

    @property
    def bearing_std_rad(self) -> Floats:
        """(K,) claimed standard deviation of bearing_rad; NaN without a claim."""

    @property
    def radius_std_m(self) -> Floats:
        """(K,) claimed standard deviation of radius_m; NaN without a claim."""

    @property
    def flags(self) -> NDArray[np.int_]:
        """(K,) remarks, a combination of `obstaclewatch.Flag`."""


@dataclass(frozen=True)
class Estimates:
    """What a detector said of the target, one row a beep; NaN where it said nothing.

    Attributes:
        range_m, range2_m, bearing_rad, radius_m, snr_db: (T,) of the associated candidate.
        flags: (T,) remarks on it, a combination of `obstaclewatch.Flag`.
        range_std_m, bearing_std_rad, radius_std_m: (T,) what the detector claims of its own errors.
        candidates: (T,) how many candidates the beep had.
    """

    range_m: Floats
    range2_m: Floats
    bearing_rad: Floats
    radius_m: Floats
    snr_db: Floats
    range_std_m: Floats
    bearing_std_rad: Floats
    radius_std_m: Floats
    flags: Floats
    candidates: Ints

    @property
    def found(self) -> Flags:
        """(T,) whether a candidate was associated."""
        return np.isfinite(self.range_m)


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
    table = np.full((len(COLUMNS), len(detections)), np.nan)
    for row, (detection, truth) in enumerate(zip(detections, true_range_m, strict=True)):
        chosen = nearest_within(detection.range_m, float(truth), gate_m)
        if chosen is not None:
            table[:, row] = [float(getattr(detection, name)[chosen]) for name in COLUMNS]
    counts = np.array([np.isfinite(detection.range_m).sum() for detection in detections], dtype=np.int64)
    return Estimates(**dict(zip(COLUMNS, table, strict=True)), candidates=counts)
