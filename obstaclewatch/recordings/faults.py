"""What can be wrong with a recording, by name."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Fault(Enum):
    """What can be wrong, and what follows: True for what no detector can use, False for what it lives with.

    >>> Fault.CLIPPED.label, Fault.CLIPPED.fatal
    ('clipped', False)
    """

    NO_BEEP = "no beep", True
    OTHER_BEEP = "other beep", True
    DEAF_MICROPHONE = "deaf microphone", False
    IDENTICAL_CHANNELS = "identical channels", False
    SWAPPED_CHANNELS = "swapped channels", True
    CLIPPED = "clipped", False
    LIMITED = "limiter", False
    DROPPED_SAMPLES = "dropped samples", False
    CLOCK_DRIFT = "clock drift", False
    MID_BEEP_START = "start in mid-beep", False
    MISSING_BEEPS = "missing beeps", False
    LATE_CHANNEL = "late channel", False
    INVERTED_CHANNEL = "inverted channel", False
    OFFSET = "constant offset", False
    COARSE_STEPS = "coarse steps", False
    ABSURD_LEVEL = "absurd level", True

    @property
    def label(self) -> str:
        """In words."""
        return self.value[0]

    @property
    def fatal(self) -> bool:
        """No detector can use such a recording."""
        return self.value[1]


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong.

    Attributes:
        fault: which.
        message: the measured value and what follows from it.
    """

    fault: Fault
    message: str

    def __str__(self) -> str:
        return f"{self.fault.label}: {self.message}"
