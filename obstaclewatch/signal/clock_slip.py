"""Beeps of which each comes a little later or earlier than the last one, and where a coherent mean needs them.

Phone and clock are rigid where one clock plays and records: the direct sound's phase stays within 0.05 rad, walls that
are walked into included. Another clock that is 20 ppm off rotates it by 0.23 rad a beep, a sample that is lost by 0.67.
Then a mean over beeps no longer holds the direct sound, and what is left of it looks like something that moves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.signal.direct_sound import DirectSound
from obstaclewatch.signal.matched_filter import EchoProfile, MatchedFilter

LEAST_SLIP_RAD = 0.2
"""Phase of the direct sound from which beeps are moved; below, they stay as they are."""


class ClockSlip:
    """Keeps the direct sound of successive beeps at the delay and phase that the first one had.

    Args:
        compressor: what makes the profiles.
    """

    def __init__(self, compressor: MatchedFilter) -> None:
        self._compressor = compressor
        self._first: tuple[float, int, complex] | None = None

    def clear(self) -> None:
        """Forget all beeps."""
        self._first = None

    def held(self, block: NDArray[np.floating], profile: EchoProfile, direct: DirectSound) -> tuple[EchoProfile, float]:
        """The profile with its direct sound in the first one's place, and by how much later it really is, s.

        A profile that needs no move is handed back as it is, with 0.

        Args:
            block: (2, block_samples) samples of the beep.
            profile: of that block.
            direct: its direct sound.
        """
        delay_s = float(direct.delay_s[0])
        sample = profile.position(delay_s)
        now = complex(profile.envelope[0, sample])
        if self._first is None:
            self._first = delay_s, sample, now
        first_s, place, before = self._first
        slip_rad = _near(float(np.angle(before * now.conjugate())), _turns(profile, delay_s - first_s))
        if abs(slip_rad) < LEAST_SLIP_RAD:
            return profile, 0.0
        slip_s = slip_rad / _turns(profile, 1.0)
        moved = self._compressor.compress(block, slip_s)
        left = before * moved.envelope[0, place].conjugate()  # read at one sample: what the two above were off by
        return replace(moved, envelope=moved.envelope * (left / abs(left))), slip_s


def _turns(profile: EchoProfile, delay_s: float) -> float:
    """Phase of the carrier over a delay, rad."""
    return 2.0 * np.pi * profile.reference_hz * delay_s


def _near(phase_rad: float, about_rad: float) -> float:
    """The phase in the cycle that is nearest to another one."""
    return phase_rad + 2.0 * np.pi * round((about_rad - phase_rad) / (2.0 * np.pi))
