"""What the last beeps received, laid out along the approaches that walkers make: what the learned decision looks at.

A row is a beep, the newest first; a column is a distance ahead of the phone now. Each is read where something that
stands so far ahead, on the walker's line, was to be read in that beep, at the speed that the steps tell and with the
gait's oscillation. So what will be met stands upright in the picture, and what will be passed, or does not stand,
leans or bends. There is one picture for each of a few heights of the reflecting point below the phone.

Microphone 1 is rotated by the path difference that something on the walker's line would have: what it receives is real
and positive along the echo of a collision, and turns with the bearing of what lies aside.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.signal.two_mics import path_difference_at
from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints, SingleComplexes, Singles
from obstaclewatch.tracking.approach_sums import MEMORY_BEEPS, RecentBeeps
from obstaclewatch.trajectories.geometry import NEAREST_M
from obstaclewatch.walker.pitch_oscillation import Oscillation, oscillation_as_read, oscillation_at

AHEAD_M = np.arange(0.15, 2.15, 0.05)
HEIGHTS_M = np.array([0.0, 0.45, np.inf])
"""Phone above the reflecting point: what is as high as the phone; rims, bonnets and doors; corners with the ground."""
LAYERS = 4
"""Of a height: log likelihood ratio of an echo; real and imaginary part of microphone 1 against microphone 0; level at
microphone 0."""
SHAPE = LAYERS * len(HEIGHTS_M), MEMORY_BEEPS, len(AHEAD_M)


class Carrier(NamedTuple):
    """The walker and the phone, as far as they are known.

    Attributes:
        speed_m_s: of the walk, by its steps.
        ground_m: height of microphone 0 above the ground.
        separation_m: between the microphones.
        pitch_rad: mean pitch of the phone.
        step_rad_s: angular frequency of the steps; 0 if it is not known.
    """

    speed_m_s: float
    ground_m: float
    separation_m: float
    pitch_rad: float
    step_rad_s: float


NOBODY = Carrier(0.0, 0.0, 0.0, 0.0, 0.0)
NO_PICTURE: Singles = np.zeros(SHAPE, dtype=np.float32)


def approach_picture(
    beeps: RecentBeeps,
    now_s: float,
    ahead_s: float,
    carrier: Carrier,
    oscillation: Oscillation,
    wavelength_m: float,
    mic_phase_rad: float | None,
) -> Singles:
    """`SHAPE` numbers about 0 to 5; 0 where nothing was received.

    Args:
        beeps: of which the newest ones count.
        now_s: at which the last beep's centre was hit.
        ahead_s: how far ahead the chirp reads.
        carrier: walker and phone.
        oscillation: of the phone by the steps.
        wavelength_m: of the carrier wave.
        mic_phase_rad: what microphone 1's channel adds to the phase; None leaves microphone 1 out.
    """
    picture = np.zeros(SHAPE, dtype=np.float32)
    layers = picture.reshape(len(HEIGHTS_M), LAYERS, *SHAPE[1:])[:, :, : len(beeps.time_s)]
    # heights x beeps x places ahead
    along_m = AHEAD_M + carrier.speed_m_s * (now_s - ahead_s - beeps.time_s)[:, None]
    height_m = np.minimum(HEIGHTS_M, carrier.ground_m)[:, None, None]
    range_m = np.maximum(np.hypot(along_m, height_m), NEAREST_M)
    read = oscillation_as_read(oscillation, beeps.time_s, ahead_s)[:, :, None]
    read_m = range_m + (height_m * read[1] - along_m * read[2]) / range_m
    cell = (read_m - beeps.first_m) / beeps.cell_m
    layers[:, 0] = _higher_of_two(beeps.ratio, cell)
    first = _between(beeps.envelope[:, 0], 2.0 * cell + 0.5)
    layers[:, 3] = 0.5 * np.log1p(np.abs(first) ** 2)
    if mic_phase_rad is None:
        return picture
    pitch_rad = carrier.pitch_rad + oscillation_at(oscillation, beeps.time_s)[0, :, None]
    cosine = (along_m * np.cos(pitch_rad) - height_m * np.sin(pitch_rad)) / range_m
    later_m = path_difference_at.py_func(range_m, cosine, carrier.separation_m)
    second = _between(beeps.envelope[:, 1], 2.0 * cell + 0.5 + later_m / beeps.cell_m)
    both = second * first.conj() * np.exp(1j * (2.0 * np.pi / wavelength_m * later_m - mic_phase_rad))
    size = np.abs(both)
    both *= 0.5 * np.log1p(size) / np.maximum(size, 1e-30)
    layers[:, 1], layers[:, 2] = both.real, both.imag
    return picture


def _higher_of_two(ratio: Floats, cell: Floats) -> Floats:
    """(H, K, X) the higher of the ratios (K, cells) on both sides of a place; 0 beyond the last."""
    beep, before, inside = _places(cell, ratio.shape[1])
    found: Floats = np.where(inside, np.maximum(ratio[beep, before], ratio[beep, before + 1]), 0.0)
    return found


def _between(envelope: SingleComplexes, sample: Floats) -> Complexes:
    """(H, K, X) envelopes (K, S) at places between samples; 0 beyond the last."""
    beep, before, inside = _places(sample, envelope.shape[1])
    low, share = envelope[beep, before], sample - before
    found: Complexes = np.where(inside, low + share * (envelope[beep, before + 1] - low), 0.0)
    return found


def _places(place: Floats, count: int) -> tuple[Ints, Ints, Flags]:
    """Beeps, the samples before places (H, K, X), and which places have a sample on both sides."""
    before = np.floor(place).astype(np.int64)
    inside = (before >= 0) & (before < count - 1)
    return np.arange(place.shape[1])[:, None], np.where(inside, before, 0), inside
