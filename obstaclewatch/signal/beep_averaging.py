"""Beeps of a phone held still add up in phase: n of them gain 10 log10 n of signal-to-noise ratio.

What stands still has the same phase in every beep, noise has not; so the mean of the complex envelopes is the response
of the place. A hand that moves by 1 mm rotates an echo's phase by 0.75 rad: then the mean starts anew.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obstaclewatch.signal.echoes import noise_amplitude
from obstaclewatch.signal.matched_filter import EchoProfile
from obstaclewatch.support.argument_types import check_counts
from obstaclewatch.support.arrays import Complexes

STILL = 6.0
"""Height of a change, in rms of what is left of noise, from which the phone has moved: noise alone reaches it at one
sample in exp(36)."""


class AveragedBeeps:
    """Running complex mean of the envelopes of beeps measured in one pose.

    Args:
        beeps: after so many a new beep counts as one of them, and noise falls on to 1 / (2 beeps - 1); 1 hands every
            beep through as it is.

    Raises:
        ValueError: not a whole number of beeps, or not a single one.
    """

    def __init__(self, beeps: int) -> None:
        check_counts(1, averaged_beeps=beeps)
        self._beeps = beeps
        self._mean: Complexes | None = None
        self._count = 0

    def clear(self) -> None:
        """Forget all beeps."""
        self._mean, self._count = None, 0

    def add(self, profile: EchoProfile) -> EchoProfile:
        """The mean response with this beep in it; this beep's own where it shows another pose."""
        if self._beeps == 1:
            return profile
        if self._mean is None or has_changed(profile.envelope - self._mean):
            self._mean, self._count = profile.envelope, 0
        self._count = min(self._count + 1, self._beeps)
        self._mean = self._mean + (profile.envelope - self._mean) / self._count
        return replace(profile, envelope=self._mean)


def has_changed(difference: Complexes) -> bool:
    """Whether more than noise is left in (C, M) differences of two responses."""
    height = np.abs(difference)
    return any(float(row.max()) > STILL * noise_amplitude(row) for row in height)
