"""What a detector hands out after each beep."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntFlag
from typing import Annotated, Any, NamedTuple, Self, get_type_hints

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Floats


class Flag(IntFlag):
    """Remarks on a candidate, or on a beep.

    >>> Flag.NO_BEEP in (Flag.NO_BEEP | Flag.CLAMPED)
    True
    """

    NONE = 0
    CLAMPED = 1
    """The path difference left arccos's domain; the bearing is 0 or pi."""
    BODY_DEDUCTED = 2
    """Microphone 1 received the obstacle's echo via the walker's body; the detour was deducted."""
    NO_SECOND_MIC = 4
    """Microphone 1 received nothing of the candidate: no bearing. Of a beep: it is deaf; collisions are judged by range
    only."""
    IDENTICAL_CHANNELS = 8
    """One channel is a multiple of the other (Galaxy S5, VOICE_RECOGNITION): no bearing; collisions are judged by
    range only."""
    UNCONFIRMED = 16
    """Too few earlier beeps to distinguish a static peak from a moving one; the candidate has no vote."""
    MERGED_CREST = 32
    """The crest runs into the next one: no radius."""
    NO_BEEP = 64
    """The direct sound is not where it should be: nothing was measured."""
    NO_RADIUS = 128
    """Nothing that was received says how broad the obstacle is: its radius is NaN."""
    DAMAGED = 256
    """Samples of the beep are damaged, by a click or a gap: it is passed over as if it had not been received."""


class Column(NamedTuple):
    """What a column of candidates holds: its unit, empty for none, and its meaning."""

    unit: str
    meaning: str


@dataclass(frozen=True, kw_only=True)
class Candidates:
    """Estimates of one beep's n candidates, nearest first: the one place that names and explains their columns.

    Each is an (n,) array; NaN stands for "not estimated". `COLUMNS` has the same as a table. Ranges and bearings hold
    for when the beep's centre meets the obstacle, half the beep's length and range / c after its emission; the latter
    alone is 1.1 cm for a walker at 1.3 m/s, 3 m away. The paper's detectors keep the range-Doppler bias: theirs hold
    for `range_doppler_s` later still.

    A claimed range_std_m holds for a walk that goes on: the track of one who stops within 0.4 s goes on for 0.3 s, to
    17 cm too near at a claim of 2 cm.
    """

    range_m: Annotated[Floats, Column("m", "D1, from microphone 0 to the obstacle")]
    range2_m: Annotated[Floats, Column("m", "D2, from microphone 1 to the obstacle")]
    bearing_rad: Annotated[Floats, Column("rad", "unsigned angle between walking direction and obstacle")]
    radius_m: Annotated[Floats, Column("m", "half the obstacle's width, from the crest's width")]
    level_db: Annotated[Floats, Column("dB", "echo relative to the direct sound, at microphone 0")]
    snr_db: Annotated[Floats, Column("dB", "2E/N0 at microphone 0: peak power over half the envelope's noise power")]
    closing_speed_m_s: Annotated[Floats, Column("m/s", "speed of approach, from the ranges of earlier beeps")]
    range_std_m: Annotated[Floats, Column("m", "claimed standard deviation of range_m, range-Doppler bias apart")]
    bearing_std_rad: Annotated[Floats, Column("rad", "claimed standard deviation of bearing_rad")]

    def __len__(self) -> int:
        return len(self.range_m)

    def columns(self) -> dict[str, Floats]:
        """The estimates by name, in the order of `COLUMNS`."""
        return {name: getattr(self, name) for name in COLUMNS}


COLUMNS: dict[str, Column] = {
    name: hint.__metadata__[0] for name, hint in get_type_hints(Candidates, include_extras=True).items()
}
"""Unit and meaning of every column of `Candidates`, by name."""


@dataclass(frozen=True, kw_only=True)
class Detection(Candidates):
    """Everything measured from one beep: at most five candidates by default, see `Candidates` for their columns.

    Attributes:
        index: number of the beep since the start or the last reset.
        time_s: emission of the beep, s from the start of the recording.
        collides: (n,) votes for a collision.
        flags: (n,) int, a combination of `Flag`.
        beep_flags: remarks on the beep itself.
        decision: whether the walker is alerted.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign, PaperStandingDetector, PhoneGeometry
    >>> beep = BeepDesign()
    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> time_s = np.arange(beep.period_samples) / beep.sample_rate_hz
    >>> direct_m, echo_m = [0.0, 0.14], [4.0, 4.14]  # a wall straight ahead, 2 m away
    >>> block = [0.1 * beep.waveform(time_s - d / 343) + 0.001 * beep.waveform(time_s - e / 343)
    ...          for d, e in zip(direct_m, echo_m)]
    >>> found = PaperStandingDetector(beep, phone).process(block)
    >>> found
    Detection(index=0, range_m=[2.0], bearing_rad=[0.0], alert=False)
    >>> found.columns()["radius_m"].shape
    (1,)
    """

    index: int
    time_s: float
    collides: Flags
    flags: NDArray[np.int_]
    beep_flags: Flag
    decision: Decision

    def __repr__(self) -> str:
        rounded = [(np.round(column, 2) + 0.0).tolist() for column in (self.range_m, self.bearing_rad)]  # never -0.0
        where = f"range_m={rounded[0]}, bearing_rad={rounded[1]}"
        return f"Detection(index={self.index}, {where}, alert={self.decision.alert})"

    def taken(self, rows: NDArray[np.intp]) -> Self:
        """The same beep with the candidates of those rows alone."""
        columns: dict[str, Any] = {name: column[rows] for name, column in self.columns().items()}
        return replace(self, **columns, collides=self.collides[rows], flags=self.flags[rows])


@dataclass(frozen=True)
class Decision:
    """Whether the walker is alerted after one beep.

    Attributes:
        alert: a collision is predicted within the dangerous distance.
        time_s: emission of the beep, s from the start of the recording.
        range_m: to the nearest candidate that voted for a collision; NaN if none did.
        time_to_collision_s: that range over its closing speed; NaN likewise. Both are read 0.205 s ahead for the
            paper's beep (see `signal.two_mics`). `TrackingDetector` has the expected time to the first touch of a body,
            just below 0 once that should have come.
        votes: collision votes among the last `votes_of` beeps; of `TrackingDetector`, the candidates that vote now.
        collision_probability: of a collision, by what an alert may be given for now; NaN where the detector states
            none. A threshold on it is the detector's operating point.

    >>> decision = Decision(alert=True, time_s=1.8, range_m=2.6, time_to_collision_s=2.0, votes=5)
    >>> print(f"stop in {decision.range_m} m" if decision.alert else "go on")
    stop in 2.6 m
    """

    alert: bool
    time_s: float
    range_m: float
    time_to_collision_s: float
    votes: int
    collision_probability: float = np.nan

    def __repr__(self) -> str:
        stated = {"range_m": self.range_m, "time_to_collision_s": self.time_to_collision_s, "votes": self.votes,
                  "collision_probability": self.collision_probability}  # fmt: skip
        known = [f"{name}={value:.3g}" for name, value in stated.items() if value and np.isfinite(value)]
        return f"Decision({', '.join([f'alert={self.alert}', f'time_s={self.time_s + 0.0:.2f}', *known])})"
