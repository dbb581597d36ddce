"""A phone as an acoustic instrument: where its transducers are, how they respond, how loud and how noisy they are."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from obstaclewatch.recording import PhoneGeometry
from simulator.scene import Obstacle


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

    response_hz: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 96_000.0]))
    response_db: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))
    axis: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 1.0, 0.0]))
    rear_loss_db: float = 0.0

    def response(self, frequency_hz: ArrayLike) -> NDArray[np.float64]:
        """Amplitude response on the axis at any frequencies (linear in dB between table points, held outside)."""
        level_db = np.interp(np.asarray(frequency_hz, dtype=np.float64), self.response_hz, self.response_db)
        return 10.0 ** (level_db / 20.0)

    def directivity(self, direction: NDArray[np.float64]) -> NDArray[np.float64]:
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

    delay_s: NDArray[np.float64]
    gain: NDArray[np.float64]


@dataclass(frozen=True)
class Phone:
    """Everything of the phone that shapes a recording.

    Attributes:
        geometry: speaker and microphone positions, phone frame.
        speaker: response and directivity of the speaker.
        mics: the same of the two microphones.
        structure_borne: direct sound through the case; None has none.
        level_spl_db: sound pressure level of the beep 1 m in front of the speaker (its peak sine), dB re 20 uPa.
        noise_spl_db: noise of air and microphone in 18-23 kHz, dB re 20 uPa; -inf is silent.
        full_scale_spl_db: level of a sine that just reaches digital full scale, dB re 20 uPa.
        body: the walker's body, an obstacle that moves with the phone; mesh in the walker's frame: origin at the
            phone, x along the heading, y to the left, z up. None has no body.
    """

    geometry: PhoneGeometry
    speaker: Transducer
    mics: tuple[Transducer, Transducer]
    structure_borne: StructureBorne | None = None
    level_spl_db: float = 55.0
    noise_spl_db: float = 30.0
    full_scale_spl_db: float = 120.0
    body: Obstacle | None = None

    @classmethod
    def ideal(cls, speaker_m: ArrayLike, mics_m: ArrayLike) -> Phone:
        """Omnidirectional, flat, noiseless, without case, body or structure-borne sound."""
        geometry = PhoneGeometry("ideal", np.asarray(speaker_m), np.asarray(mics_m))
        return cls(geometry, Transducer(), (Transducer(), Transducer()), noise_spl_db=-np.inf)

    @classmethod
    def named(cls, name: str) -> Phone:
        """A preset by name: "ideal", "galaxy-s5", "galaxy-note5" or "galaxy-s8-plus".

        Raises:
            ValueError: an unknown name; the message lists those there are.
        """
        from simulator.phone_presets import preset

        return preset(name)

    def held_by(self, body: Obstacle | None) -> Phone:
        """The same phone in front of that body."""
        return replace(self, body=body)

    @property
    def full_scale_gain(self) -> float:
        """Digital amplitude of a sine at `level_spl_db`: what a path of gain 1 leaves in the samples."""
        return float(10.0 ** ((self.level_spl_db - self.full_scale_spl_db) / 20.0))
