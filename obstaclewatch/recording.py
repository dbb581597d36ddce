"""The only contract between a recorder (simulated or real) and a detector: samples, rate and phone geometry."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.argument_types import as_floats, as_reals, check_types, hold_numbers
from obstaclewatch.support.arrays import Floats, Singles


@dataclass(frozen=True, eq=False)
class PhoneGeometry:
    """Where a phone's top speaker and two microphones sit, in the phone frame.

    The phone frame has +y along the long edge from bottom to top, +x to the right as seen from the screen
    and +z out of the screen.

    Attributes:
        name: model name, for messages and reports.
        speaker_m: (3,) position of the emitting speaker, m. Beside the line of the microphones it costs ranges: what is
            to the left looks as what is to the right, and 3 cm beside ranges at 40 degrees are off by up to 1 cm.
        mics_m: (2, 3) positions of microphone 0 (top, the paper's mic1) and 1 (bottom, mic2), m. Detectors take their
            line for the walking direction, seen from above: at 2 cm to either side of the middle, 14 cm apart, what is
            straight ahead reads 16 degrees aside.

    Raises:
        ValueError: a shape is wrong, a coordinate is not finite, or the microphones coincide.

    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> print(f"{phone.mic_separation_m:.2f} m")
    0.14 m
    >>> phone.speaker_to_mic_m.round(2).tolist()
    [0.0, 0.14]
    """

    name: str
    speaker_m: Floats
    mics_m: Floats

    def __post_init__(self) -> None:
        check_types(name=(self.name, str))
        object.__setattr__(self, "speaker_m", _checked(self.speaker_m, (3,), "speaker_m"))
        object.__setattr__(self, "mics_m", _checked(self.mics_m, (2, 3), "mics_m"))
        if self.mic_separation_m == 0.0:
            raise ValueError(f"mics_m must be two different points, got {self.mics_m.tolist()}")

    @property
    def mic_separation_m(self) -> float:
        """Distance between the two microphones (the paper's L_mic, Eq. 2), m."""
        return float(np.linalg.norm(self.mics_m[0] - self.mics_m[1]))

    def line_pitch_rad(self, pitch_rad: float) -> float:
        """Pitch of the line from microphone 1 to microphone 0 while the phone's top edge has the given one, rad.

        >>> phone = PhoneGeometry("rear top microphone", [0, 0.04, 0], [[0, 0.07, -0.008], [0, -0.07, 0]])
        >>> print(f"{np.degrees(phone.line_pitch_rad(0.5)):.1f} of {np.degrees(0.5):.1f} degrees")
        25.4 of 28.6 degrees
        """
        right, along, out = (self.mics_m[0] - self.mics_m[1]).tolist()
        in_plane_rad = pitch_rad + math.atan2(out, along)
        if right == 0.0:
            return in_plane_rad
        return math.asin(math.sin(in_plane_rad) * math.hypot(along, out) / self.mic_separation_m)

    @property
    def speaker_to_mic_m(self) -> Floats:
        """(2,) length of the direct path from the speaker to each microphone, m."""
        return np.linalg.norm(self.mics_m - self.speaker_m, axis=1)

    @property
    def speaker_cosine(self) -> float:
        """Cosine of the angle at microphone 0 between the speaker and the line on from microphone 1: -1 where the
        speaker lies on the way back to microphone 1; 0 where it is at microphone 0."""
        to_speaker_m, length_m = self.speaker_m - self.mics_m[0], float(self.speaker_to_mic_m[0])
        if length_m == 0.0:
            return 0.0
        return float(to_speaker_m @ (self.mics_m[0] - self.mics_m[1])) / (length_m * self.mic_separation_m)


LEAST_RATE_HZ, GREATEST_RATE_HZ = 1.0, 1e12
"""No recorder of sound samples more slowly or faster; far beyond, durations overflow."""


@dataclass(frozen=True, eq=False)
class Recording:
    """A two-channel recording; channel k is microphone k.

    Attributes:
        samples: (2, N) float32, relative to digital full scale; a view that cannot be written through. Where float32 is
            given it is not copied, as ten minutes are a gigabyte: that array must not change any more.
        sample_rate_hz: samples per second, 1 to 1e12.

    Raises:
        ValueError: not two channels of real numbers, no samples, samples that are not finite, or a rate that no
            recorder has.

    >>> Recording([[0.0, 0.1], [0.0, 0.2]], sample_rate_hz=192_000.0)
    Recording(2 x 2 samples at 192000 Hz, 0.00 s)
    """

    samples: Singles
    sample_rate_hz: float

    def __post_init__(self) -> None:
        with np.errstate(over="ignore"):  # what float32 does not hold is refused as infinite
            samples = np.ascontiguousarray(as_reals("samples", self.samples), dtype=np.float32).view()
        if samples.ndim != 2 or samples.shape[0] != 2:
            raise ValueError(f"samples must have shape (2, N), one row per microphone, got {samples.shape}")
        if samples.shape[1] == 0:
            raise ValueError("samples must hold at least one sample per microphone, got none")
        if not np.isfinite([samples.min(), samples.max()]).all():
            raise ValueError(f"samples must be finite, got {int((~np.isfinite(samples)).sum())} NaN or infinite values")
        hold_numbers(self, "sample_rate_hz")
        if not LEAST_RATE_HZ <= self.sample_rate_hz <= GREATEST_RATE_HZ:
            rule = f"{LEAST_RATE_HZ:g} to {GREATEST_RATE_HZ:g} Hz"
            raise ValueError(f"sample_rate_hz must be {rule}, got {self.sample_rate_hz}")
        samples.setflags(write=False)
        object.__setattr__(self, "samples", samples)

    def __repr__(self) -> str:
        rate_hz, seconds = self.sample_rate_hz, self.duration_s
        return f"Recording(2 x {self.samples.shape[1]} samples at {rate_hz:g} Hz, {seconds:.2f} s)"

    @property
    def duration_s(self) -> float:
        """Length of the recording, s."""
        return self.samples.shape[1] / self.sample_rate_hz


def _checked(value: ArrayLike, shape: tuple[int, ...], name: str) -> Floats:
    array = as_floats(name, value)
    if array.shape != shape:
        raise ValueError(f"{name} must have shape {shape}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got {array.tolist()}")
    array.setflags(write=False)
    return array
