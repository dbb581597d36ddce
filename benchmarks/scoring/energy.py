"""From processor time per beep to the charge of 30 minutes: a model, not a measurement.

    power = audio path + share of time a core computes x its power
    share = CPU time per beep x slower phone / beep period
    charge = power x time / battery voltage

Every constant is an assumption stated here: none was fitted to the paper's Table 1, and the answer moves with them as
the formula says. The audio path stands for the whole phone playing and recording with its screen off, 0.3 to 0.5 W,
the order that Carroll and Heiser (2010, "An Analysis of Power Consumption in a Smartphone", USENIX ATC) measured on
phones playing audio. A busy core is taken at 0.75 W more, and a phone of 2014-2017 as three to ten times slower than
the machine that measured.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from obstaclewatch.support.argument_types import hold_numbers

AUDIO_W = (0.3, 0.5)
SLOWER = (3.0, 10.0)
DURATION_S = 1800.0


@dataclass(frozen=True)
class EnergyModel:
    """Constants of the model.

    Attributes:
        audio_w: power while playing and recording with nothing computed.
        core_w: extra power of one busy core.
        slower: how many times slower the phone computes than the machine that measured.
        battery_v: mean voltage of a lithium cell.

    Raises:
        ValueError: a constant that is not a positive, finite number.

    >>> EnergyModel(battery_v=0.0)
    Traceback (most recent call last):
    ValueError: battery_v must be positive and finite, got 0.0
    """

    audio_w: float = 0.4
    core_w: float = 0.75
    slower: float = 5.0
    battery_v: float = 3.85

    def __post_init__(self) -> None:
        hold_numbers(self, *(each.name for each in fields(self)))
        for name, value in vars(self).items():
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} must be positive and finite, got {value}")

    def charge_mah(self, cpu_s_per_beep: float, period_s: float) -> float:
        """Charge drawn over 30 minutes, mAh; more than one core's time is counted as it is."""
        busy = cpu_s_per_beep * self.slower / period_s
        return (self.audio_w + busy * self.core_w) * DURATION_S / 3600.0 / self.battery_v * 1000.0


def charge_range_mah(cpu_s_per_beep: float, period_s: float) -> tuple[float, float]:
    """Charge at both ends of what is assumed of the audio path and of the phone's speed, mAh."""
    low, high = (
        EnergyModel(audio_w=audio, slower=slower).charge_mah(cpu_s_per_beep, period_s)
        for audio, slower in zip(AUDIO_W, SLOWER, strict=True)
    )
    return low, high
