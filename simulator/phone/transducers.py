"""Speaker and microphones as instruments, and the case between them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.argument_types import as_finite, as_points, hold_numbers
from obstaclewatch.support.arrays import Floats

UNIT = 1e-6  # of the length of an axis
MOST_DB = 300.0  # either way: no instrument comes near, and numbers of 64 bits hold it


@dataclass(frozen=True, eq=False)
class Transducer:
    """Frequency response and directivity of a speaker or a microphone, taken as separable.

    The directivity is a level that falls smoothly from the axis to the rear,
    -rear_loss_db (1 - cos angle) / 2 in dB: the case's shadow, without nulls.

    Attributes:
        response_hz: (K,) frequencies of the response table, increasing.
        response_db: (K,) level on the axis, dB.
        axis: (3,) unit vector of greatest sensitivity, phone frame.
        rear_loss_db: level opposite the axis, dB below the axis; 0 is omnidirectional.

    Raises:
        ValueError: tables that do not fit or do not increase, numbers that are not finite, an axis of another length
            than 1, a negative loss.

    Example:
        >>> from simulator import Transducer
        >>> speaker = Transducer([18e3, 23e3], [0.0, -6.0], axis=[0.0, 1.0, 0.0], rear_loss_db=12.0)
        >>> print(speaker.response(23e3).round(3), speaker.directivity([0.0, -1.0, 0.0]).round(3))
        0.501 0.251
    """

    response_hz: Floats = field(default_factory=lambda: np.array([0.0, 96_000.0]))
    response_db: Floats = field(default_factory=lambda: np.zeros(2))
    axis: Floats = field(default_factory=lambda: np.array([0.0, 1.0, 0.0]))
    rear_loss_db: float = 0.0

    def __post_init__(self) -> None:
        for name in ("response_hz", "response_db", "axis"):
            object.__setattr__(self, name, as_finite(name, getattr(self, name)))
        hz, db = self.response_hz, self.response_db
        if hz.ndim != 1 or hz.size == 0 or (np.diff(hz) <= 0.0).any():
            raise ValueError(f"response_hz must be one or more frequencies that increase, got {hz.tolist()}")
        if db.shape != hz.shape:
            raise ValueError(f"response_db must have one level per frequency, got shape {db.shape} for {hz.shape}")
        if self.axis.shape != (3,) or abs(np.linalg.norm(self.axis) - 1.0) > UNIT:
            raise ValueError(f"axis must be a unit vector, got {self.axis.tolist()}")
        if np.abs(db).max() > MOST_DB:
            raise ValueError(f"response_db must be within +-{MOST_DB:g} dB, got {db.tolist()}")
        hold_numbers(self, "rear_loss_db")
        if not 0.0 <= self.rear_loss_db <= MOST_DB:
            raise ValueError(f"rear_loss_db must be 0 to {MOST_DB:g} dB, got {self.rear_loss_db}")

    def response(self, frequency_hz: ArrayLike) -> Floats:
        """Amplitude response on the axis at any frequencies (linear in dB between table points, held outside).

        It has no phase, as the tables have none: it delays nothing, and the corners of a table ring alike before and
        after a sound. Of a galaxy-s5's that is 1e-3 of a 50 ms beep close by it, 1e-4 at 40 ms.
        """
        level_db = np.interp(as_finite("frequency_hz", frequency_hz), self.response_hz, self.response_db)
        return 10.0 ** (level_db / 20.0)

    @property
    def lean(self) -> Floats:
        """(3,) vector v along the axis such that the directivity is exp(v . direction - |v|)."""
        return self.rear_loss_db * np.log(10.0) / 40.0 * self.axis

    def directivity(self, direction: ArrayLike) -> Floats:
        """(...,) amplitude factor for (..., 3) unit vectors of the phone frame that point away from the phone."""
        cosine = np.clip(as_points("direction", direction) @ self.axis, -1.0, 1.0)
        return 10.0 ** (-self.rear_loss_db * (1.0 - cosine) / 40.0)


@dataclass(frozen=True, eq=False)
class StructureBorne:
    """Direct sound through the case, one arrival per microphone.

    Attributes:
        delay_s: (2,) after emission, not negative.
        gain: (2,) amplitude relative to the free-field pressure 1 m in front of the speaker.

    Raises:
        ValueError: not two finite numbers each, or a negative delay.

    Example:
        >>> from simulator import StructureBorne
        >>> print(StructureBorne(delay_s=[20e-6, 60e-6], gain=[5.0, 0.5]).gain)
        [5.  0.5]
    """

    delay_s: Floats
    gain: Floats

    def __post_init__(self) -> None:
        for name in ("delay_s", "gain"):
            value = as_finite(name, getattr(self, name))
            if value.shape != (2,):
                raise ValueError(f"{name} must be one number per microphone, got {value.tolist()}")
            object.__setattr__(self, name, value)
        if (self.delay_s < 0.0).any():
            raise ValueError(f"delay_s must not be negative, got {self.delay_s.tolist()}")
