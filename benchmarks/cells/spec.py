"""What one cell measures: a value that can be hashed, stored and run again alone."""

from __future__ import annotations

import hashlib
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


class BeepSetting(BaseModel):
    """Arguments of `obstaclewatch.BeepDesign`."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    start_hz: Positive = 18_000.0
    stop_hz: Positive = 23_000.0
    duration_s: Positive = 0.050
    gap_s: Annotated[float, Field(ge=0.0)] = 0.040
    sample_rate_hz: Positive = 192_000.0

    @property
    def period_s(self) -> float:
        """From the start of one beep to the start of the next, s."""
        return self.duration_s + self.gap_s


class Knowledge(BaseModel):
    """What the detector is told of its phone, beside the geometry.

    Attributes:
        pitch: the mean lift of the phone's top edge, as its accelerometer gives it.
        direct_delay: the delay of the direct sound, measured once in free space: sound through the case is earlier
            than sound through the air.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    pitch: bool = True
    direct_delay: bool = True


class Scoring(BaseModel):
    """The rules by which alerts and estimates are judged.

    Attributes:
        alert_margin_m: a true alert comes at least this far before contact, along the walk.
        alert_within_m: the paper's danger distance; under its rule a true alert comes within it, before contact.
        half_width_m: half the width of the walker's swept body.
        gate_m: a candidate belongs to the target if its range is within this of the true one; wide enough to keep
            the range-Doppler reading of a walking phone (-20 to -33 cm at 1.0-1.6 m/s).
        max_range_m: beeps with the target farther than this are left out of the error statistics.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    alert_margin_m: Annotated[float, Field(ge=0.0)] = 1.0
    alert_within_m: Positive = 3.0
    half_width_m: Annotated[float, Field(ge=0.0)] = 0.25
    gate_m: Positive = 0.5
    max_range_m: Positive = 7.0


class Cell(BaseModel):
    """One walk, or one standing measurement, with everything that decides its numbers.

    Attributes:
        kind: "approach" walks towards (or past) an obstacle; "standing" measures at a fixed distance.
        index: number of the walk within its scene and category.
        seed: of the walk's own random stream.
        range_m: distance of a standing measurement, m; None for a walk.
        settings: constants of the detector, arguments of `obstaclewatch.PaperSettings`.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    kind: Literal["approach", "standing"]
    scene: str
    category: str
    index: Annotated[int, Field(ge=0)]
    phone: str
    seed: Annotated[int, Field(ge=0)]
    collision: bool
    range_m: float | None = None
    approach: dict[str, Any] = {}
    beep: BeepSetting = BeepSetting()
    fidelity: dict[str, Any] = {}
    knowledge: Knowledge = Knowledge()
    settings: dict[str, Any] = {}
    detectors: tuple[str, ...]
    scoring: Scoring = Scoring()

    @property
    def beep_period_s(self) -> float:
        """From the start of one beep to the start of the next, s."""
        return self.beep.duration_s + self.beep.gap_s

    @property
    def label(self) -> str:
        """Short name for people: "supermarket/dustbin/17"."""
        distance = "" if self.range_m is None else f"/{self.range_m:g}m"
        return f"{self.scene}/{self.category}{distance}/{self.index}"

    def digest(self, fingerprint: str) -> str:
        """SHA-256 of the cell and of the source that computes it, hexadecimal."""
        return hashlib.sha256(f"{fingerprint}\n{self.model_dump_json()}".encode()).hexdigest()
