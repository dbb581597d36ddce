"""What motion does to a chirp's echoes beyond their delay: each frequency meets another instant.

A chirp passes frequency f at the instant (f - f0) / rate. By then a path has become longer by its own rate, so that
over frequency its phase turns as that of a path does which is longer by f0 / rate times that rate: the range-Doppler
coupling of chirps (Skolnik, Radar Handbook).
"""

from __future__ import annotations

from dataclasses import dataclass

from obstaclewatch.beep import BeepDesign
from obstaclewatch.support.arrays import Floats
from simulator.waves.band import REFERENCE_HZ

LEAST_SWEPT = 30.0  # cycles of its bandwidth that a beep must last for each frequency to have an instant of its own


@dataclass(frozen=True)
class Sweep:
    """A chirp that sweeps the band while phones move.

    Attributes:
        velocity_m_s: (N, 3, 3) of speaker and microphones at N poses.
        passed_s: when the chirp passes `REFERENCE_HZ`, after its middle, at which the poses are taken.
        coupling_s: by the motion of so long along a path the chirp shifts its echo over range.
    """

    velocity_m_s: Floats
    passed_s: float
    coupling_s: float

    @classmethod
    def of(cls, beep: BeepDesign, velocity_m_s: Floats) -> Sweep | None:
        """That of a beep; None of a beep so short or narrow in band that it passes all frequencies at once."""
        if abs(beep.stop_hz - beep.start_hz) * beep.duration_s < LEAST_SWEPT:
            return None
        rate = beep.chirp_rate_hz_s
        return cls(velocity_m_s, (REFERENCE_HZ - beep.center_hz) / rate, REFERENCE_HZ / rate)
