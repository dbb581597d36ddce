"""Speaker and microphones as instruments, and the case between them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Floats


@dataclass(frozen=True)
class Transducer:
    """Frequency response and directivity of a speaker or a microphone, taken as separable.

    The directivity is a level that falls smoothly from the axis to the rear,
    -rear_loss_db (1 - cos angle) / 2 in dB: the case's shadow, without nulls.

    Attributes:
        response_hz: (K,) frequencies of the response table, increasing.
        response_db: (K,) level on the axis, dB.
        axis: (3,) unit vector of greatest sensitivity, phone frame.
        rear_loss_db: level opposite the axis, dB below the axis; 0 is omnidirectional.
    """

    response_hz: Floats = field(default_factory=lambda: np.array([0.0, 96_000.0]))
    response_db: Floats = field(default_factory=lambda: np.zeros(2))
    axis: Floats = field(default_factory=lambda: np.array([0.0, 1.0, 0.0]))
    rear_loss_db: float = 0.0

    def response(self, frequency_hz: ArrayLike) -> Floats:
        """Amplitude response on the axis at any frequencies (linear in dB between table points, held outside).

        It has no phase, as the tables have none: it delays nothing, and the corners of a table ring alike before and
        after a sound. Of a galaxy-s5's that is 1e-3 of a 50 ms beep close by it, 1e-4 at 40 ms.
        """
        level_db = np.interp(np.asarray(frequency_hz, dtype=np.float64), self.response_hz, self.response_db)
        return 10.0 ** (level_db / 20.0)

    @property
    def lean(self) -> Floats:
        """(3,) vector v along the axis such that the directivity is exp(v . direction - |v|)."""
        return self.rear_loss_db * np.log(10.0) / 40.0 * np.asarray(self.axis, dtype=np.float64)

    def directivity(self, direction: Floats) -> Floats:
        """(...,) amplitude factor for (..., 3) unit vectors of the phone frame that point away from the phone."""
        cosine = np.clip(np.asarray(direction) @ self.axis, -1.0, 1.0)
        return 10.0 ** (-self.rear_loss_db * (1.0 - cosine) / 40.0)


@dataclass(frozen=True)
class StructureBorne:
    """Direct sound through the case, one arrival per microphone.

    Attributes:
        delay_s: (2,) after emission.
        gain: (2,) amplitude relative to the free-field pressure 1 m in front of the speaker.
    """

    delay_s: Floats
    gain: Floats
