"""A phone as an acoustic instrument: where its transducers are, how they respond, how loud and how noisy they are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.support.argument_types import check_types, hold_numbers
from simulator.phone.presets import preset
from simulator.phone.transducers import MOST_DB, StructureBorne, Transducer
from simulator.scene.scene import Obstacle


@dataclass(frozen=True, eq=False, repr=False)
class Phone:
    """Everything of the phone that shapes a recording.

    Attributes:
        geometry: speaker and microphone positions, phone frame.
        speaker: response and directivity of the speaker.
        mics: the same of the two microphones, top and bottom.
        structure_borne: direct sound through the case; None has none.
        level_spl_db: sound pressure level of the beep 1 m in front of the speaker (its peak sine), dB re 20 uPa.
        noise_spl_db: noise of air and microphone in 18-23 kHz, dB re 20 uPa; -inf is silent.
        full_scale_spl_db: level of a sine that just reaches digital full scale, dB re 20 uPa.
        body: the walker's body, an obstacle that moves with the phone; mesh in the walker's frame: origin at the
            phone, x along the heading, y to the left, z up. None has no body.

    Raises:
        ValueError: a level that is not a number, or beyond 300 dB but for a silent noise; a part of another type; not
            two microphones.

    Example:
        >>> from simulator import Phone
        >>> phone = Phone.named("galaxy-s8-plus")
        >>> phone.geometry.mic_separation_m
        0.16
        >>> phone.held_by(None).body is None
        True
        >>> phone
        Phone('galaxy-s8-plus', beep 55 dB SPL at 1 m, noise 30 dB SPL, no body)
    """

    geometry: PhoneGeometry
    speaker: Transducer
    mics: tuple[Transducer, Transducer]
    structure_borne: StructureBorne | None = None
    level_spl_db: float = 55.0
    noise_spl_db: float = 30.0
    full_scale_spl_db: float = 120.0
    body: Obstacle | None = None

    def __repr__(self) -> str:
        body = "no body" if self.body is None else f"body '{self.body.name}'"
        levels = f"beep {self.level_spl_db:g} dB SPL at 1 m, noise {self.noise_spl_db:g} dB SPL"
        return f"Phone({self.geometry.name!r}, {levels}, {body})"

    def __post_init__(self) -> None:
        check_types(geometry=(self.geometry, PhoneGeometry), speaker=(self.speaker, Transducer))
        check_types(mics=(self.mics, Iterable))
        object.__setattr__(self, "mics", tuple(self.mics))
        if len(self.mics) != 2:
            raise ValueError(f"mics must be two transducers, got {len(self.mics)}")
        for mic in self.mics:
            check_types(mic=(mic, Transducer))
        if self.structure_borne is not None:
            check_types(structure_borne=(self.structure_borne, StructureBorne))
        if self.body is not None:
            check_types(body=(self.body, Obstacle))
        for name in ("level_spl_db", "noise_spl_db", "full_scale_spl_db"):
            hold_numbers(self, name)
            level = getattr(self, name)
            if not (abs(level) <= MOST_DB or (name == "noise_spl_db" and level == -np.inf)):
                silent = " or -inf" * (name == "noise_spl_db")
                raise ValueError(f"{name} must be finite, within +-{MOST_DB:g} dB{silent}, got {level}")

    @classmethod
    def ideal(cls, speaker_m: ArrayLike, mics_m: ArrayLike) -> Phone:
        """Omnidirectional, flat, noiseless, without case, body or structure-borne sound."""
        geometry = PhoneGeometry("ideal", speaker_m, mics_m)  # type: ignore[arg-type]
        return cls(geometry, Transducer(), (Transducer(), Transducer()), noise_spl_db=-np.inf)

    @classmethod
    def named(cls, name: str) -> Phone:
        """A preset by name: "ideal", "galaxy-s5", "galaxy-note5", "galaxy-s8-plus" or "nexus-6p".

        Raises:
            ValueError: an unknown name; the message lists those there are.
        """
        return cls(**vars(preset(name)))

    def held_by(self, body: Obstacle | None) -> Phone:
        """The same phone in front of that body."""
        return replace(self, body=body)

    @property
    def full_scale_gain(self) -> float:
        """Digital amplitude of a sine at `level_spl_db`: what a path of gain 1 leaves in the samples."""
        return float(10.0 ** ((self.level_spl_db - self.full_scale_spl_db) / 20.0))
