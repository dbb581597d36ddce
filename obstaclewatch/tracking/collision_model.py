"""The probability of a collision by what was learned from simulated walks: a small convolutional network.

It looks at the picture of the last beeps (`approach_picture`) through three layers of 3 x 3 kernels, of which the first
two keep the greatest of every 2 x 2 values, and takes the numbers of `Evidence` beside what it saw. Numbers are
centred, scaled and limited, and the picture is limited as well, so that nothing unusual can decide alone; a number that
is missing is 0, with a sign of it. Several networks learned from the same walks are averaged. `python -m
benchmarks.training decision` learns the weights and writes their card; docs/learned.md shows it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Flags, Floats, Singles
from obstaclewatch.support.whole_file import whole_file
from obstaclewatch.tracking.approach_picture import LAYERS, SHAPE
from obstaclewatch.tracking.deviations import deviations
from obstaclewatch.tracking.evidence import OF_TRACKS, Evidence

WEIGHTS = Path(__file__).with_name("collision_model.npz")
KERNEL = 3
POOLED_LAYERS = 2
MOST_AGREEMENT, MOST_LEVEL = 1.0, 1.3
"""Beyond which microphone 1's agreement, and the level, of a picture count as so much: an echo 11 dB over what is usual
tells by its place and phase, not by how loud it is."""


@dataclass(frozen=True)
class Network:
    """Weights, single precision, of input to output; those of several networks together have another axis before (...).

    Attributes:
        kernels: of every layer (..., outputs, inputs, 3, 3).
        kernel_offsets: (..., outputs) each.
        hidden, hidden_offset: (..., H, C + F) and (..., H), of what the last layer saw and the numbers.
        output, output_offset: (..., H) and (...), to log odds.
    """

    kernels: tuple[Singles, ...]
    kernel_offsets: tuple[Singles, ...]
    hidden: Singles
    hidden_offset: Singles
    output: Singles
    output_offset: Singles

    @classmethod
    def together(cls, networks: Sequence[Network]) -> Network:
        """All of some networks of the same shapes, in half the time of one after the other, beep by beep."""
        kernels = zip(*(network.kernels for network in networks), strict=True)
        offsets = zip(*(network.kernel_offsets for network in networks), strict=True)
        dense = (np.stack([getattr(network, name) for network in networks]) for name in DENSE)
        return cls(tuple(map(np.stack, kernels)), tuple(map(np.stack, offsets)), *dense)

    def log_odds(self, pictures: Singles, numbers: Singles) -> Singles:
        """(..., n) of a collision, by (n, *SHAPE) pictures as `limited` and (n, F) numbers as `scaled` gives them."""
        seen = pictures[(None,) * self.output_offset.ndim]
        for layer, (kernel, offset) in enumerate(zip(self.kernels, self.kernel_offsets, strict=True)):
            seen = _convolved(seen, kernel, offset)
            if layer < POOLED_LAYERS:
                seen = _greatest_of_four(seen)
        seen = seen.reshape(*seen.shape[:-3], -1)
        joined = np.concatenate([seen, np.broadcast_to(numbers, (*seen.shape[:-1], numbers.shape[1]))], axis=-1)
        hidden = np.maximum(joined @ self.hidden.swapaxes(-1, -2) + self.hidden_offset[..., None, :], 0.0)
        found: Singles = (hidden @ self.output[..., None])[..., 0] + self.output_offset[..., None]
        return found


@dataclass(frozen=True)
class CollisionModel:
    """What was learned.

    Attributes:
        networks: whose log odds are averaged.
        usual, spread: (F,) mean and deviation of the numbers of `Evidence` among the beeps learned from.
        left_m, thresholds: (2,) distances left, ascending, and the probabilities above which a walker is alerted
            there; linear between, constant beyond.

    >>> from obstaclewatch.tracking.approach_picture import NO_PICTURE
    >>> from obstaclewatch.tracking.collision_model import collision_model
    >>> from obstaclewatch.tracking.evidence import NO_EVIDENCE
    >>> collision_model().probability(NO_EVIDENCE, NO_PICTURE) < 0.5
    True
    """

    networks: tuple[Network, ...]
    usual: Floats
    spread: Floats
    left_m: Floats
    thresholds: Floats

    def probability(self, evidence: Evidence, picture: Singles) -> float:
        """Of a collision."""
        return float(self.probabilities(np.array([evidence]), picture[None])[0])

    def probabilities(self, evidence: Floats, pictures: Singles) -> Floats:
        """(n,) of a collision, by (n, F) numbers of `Evidence` and (n, *SHAPE) pictures."""
        numbers, seen = self.numbers(evidence), limited(pictures)
        log_odds = np.mean(self._together.log_odds(seen, numbers), axis=0, dtype=np.float64)
        found: Floats = 1.0 / (1.0 + np.exp(-log_odds))
        return found

    @cached_property
    def _together(self) -> Network:
        return Network.together(self.networks)

    def numbers(self, evidence: Floats) -> Singles:
        """(n, F + tracks' numbers) what a network takes of the numbers of `Evidence`."""
        return scaled(evidence, self.usual, self.spread)

    def suffices(self, probability: ArrayLike, left_m: ArrayLike, false_alert_cost: float = 1.0) -> Flags:
        """Whether probabilities are enough for an alert with so much left to walk.

        The thresholds are for false alerts that cost as much as missed collisions. Odds must be higher in proportion
        where they cost more (Bayes' rule).
        """
        least = np.interp(np.asarray(left_m, dtype=np.float64), self.left_m, self.thresholds)
        stated = np.asarray(probability, dtype=np.float64)
        enough: Flags = stated * (1.0 - least) > false_alert_cost * (1.0 - stated) * least
        return enough

    def write(self, weights: Path) -> None:
        """As plain arrays, which `from_file` reads."""
        arrays: dict[str, Any] = {name: getattr(self, name) for name in OF_ALL}
        for k, network in enumerate(self.networks):
            for layer, (kernel, offset) in enumerate(zip(network.kernels, network.kernel_offsets, strict=True)):
                arrays |= {f"kernel_{k}_{layer}": kernel, f"kernel_offset_{k}_{layer}": offset}
            arrays |= {f"{name}_{k}": getattr(network, name) for name in DENSE}
        with whole_file(weights) as partial, partial.open("wb") as file:
            np.savez_compressed(file, numbers=np.array(Evidence._fields), **arrays)

    @classmethod
    def from_file(cls, weights: Path) -> CollisionModel:
        """The model of a file.

        Raises:
            ValueError: its numbers are not those of `Evidence`, or its kernels are not for such pictures.
        """
        with np.load(weights, allow_pickle=False) as stored:
            if list(stored["numbers"]) != list(Evidence._fields):
                raise ValueError(f"{weights.name} must have numbers {Evidence._fields}, got {tuple(stored['numbers'])}")
            count = sum(name.startswith("output_offset_") for name in stored)
            networks = tuple(_network(stored, k) for k in range(count))
            taken = {network.kernels[0].shape[1] for network in networks}
            if taken != {SHAPE[0]}:
                raise ValueError(f"{weights.name} must have kernels for {SHAPE[0]} layers, got {sorted(taken)}")
            return cls(networks, *(stored[name] for name in OF_ALL))


OF_ALL = ("usual", "spread", "left_m", "thresholds")
DENSE = ("hidden", "hidden_offset", "output", "output_offset")


@lru_cache(maxsize=1)
def collision_model() -> CollisionModel:
    """The model that comes with the detector."""
    return CollisionModel.from_file(WEIGHTS)


def scaled(evidence: Floats, usual: Floats, spread: Floats) -> Singles:
    """(n, F + T) numbers of `Evidence` (n, F) in deviations from what is usual, and which of tracks are missing."""
    missing = np.isnan(evidence[:, :OF_TRACKS])
    return np.concatenate([deviations(evidence, usual, spread), missing], axis=1).astype(np.float32)


def limited(pictures: Singles) -> Singles:
    """(n, *SHAPE) pictures (n, *SHAPE) in which nothing is louder than most of what was learned from."""
    layers = pictures.reshape(len(pictures), -1, LAYERS, *SHAPE[1:]).copy()
    size = np.hypot(layers[:, :, 1], layers[:, :, 2])
    layers[:, :, 1:3] *= np.minimum(1.0, MOST_AGREEMENT / np.maximum(size, 1e-6))[:, :, None]
    np.minimum(layers[:, :, 3], MOST_LEVEL, out=layers[:, :, 3])
    return layers.reshape(pictures.shape)


def _network(stored: np.lib.npyio.NpzFile, k: int) -> Network:
    layers = range(sum(name.startswith(f"kernel_{k}_") for name in stored))
    kernels = tuple(stored[f"kernel_{k}_{layer}"] for layer in layers)
    offsets = tuple(stored[f"kernel_offset_{k}_{layer}"] for layer in layers)
    return Network(kernels, offsets, *(stored[f"{name}_{k}"] for name in DENSE))


def _convolved(values: Singles, kernel: Singles, offset: Singles) -> Singles:
    """(..., n, outputs, H, W) positive part of (..., n, inputs, H, W) correlated with kernels, zeros around.

    Row by row: products of this size stay in one thread, and threads would cost more than they bring.
    """
    edge, *before, height, width = KERNEL // 2, *values.shape
    padded = np.zeros((*before, height + 2 * edge, width + 2 * edge), dtype=np.float32)
    padded[..., edge : edge + height, edge : edge + width] = values
    windows = np.moveaxis(sliding_window_view(padded, (KERNEL, KERNEL), axis=(-2, -1)), (-5, -3), (-4, -1))
    rows = kernel.reshape(*kernel.shape[:-4], 1, 1, kernel.shape[-4], -1) @ windows.reshape(
        *before[:-1], height, -1, width
    )
    found: Singles = np.maximum(rows + offset[..., None, None, :, None], 0.0).swapaxes(-3, -2)
    return found


def _greatest_of_four(values: Singles) -> Singles:
    """(..., C, H / 2, W / 2) the greatest of every 2 x 2."""
    of_rows = np.maximum(values[..., ::2, :], values[..., 1::2, :])
    found: Singles = np.maximum(of_rows[..., ::2], of_rows[..., 1::2])
    return found
