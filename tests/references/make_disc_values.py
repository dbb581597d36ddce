"""Make disc_values.npz: full-wave echoes of discs and drums in the open. Run from the repository root:

python -m tests.references.make_disc_values    # some minutes on one core
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.references.make_revolved_values import FREQUENCY_HZ, SPEED_M_S, transfer
from tests.references.revolved_body import Body, Piece

RADIUS_AND_LENGTH_M = {"disc": (0.2, 0.01), "drum": (0.15, 0.2), "short post": (0.08, 0.3)}
"""About the z axis, whose origin is in the middle."""
DISTANCE_AND_ANGLE_DEG = [(d, a) for d in (1.2, 2.0) for a in (0.0, 3.0, 7.0, 15.0, 30.0, 50.0, 70.0, 85.0)]
"""Of the speaker from the middle, and from the axis."""
STORED = Path(__file__).with_name("disc_values.npz")


def meridian(name: str) -> list[Piece]:
    """Face, side and face."""
    radius, length = RADIUS_AND_LENGTH_M[name]
    low, high = -0.5 * length, 0.5 * length
    return [Piece((0.0, low), (radius, low)), Piece((radius, low), (radius, high)), Piece((radius, high), (0.0, high))]


def speakers() -> NDArray[np.float64]:
    """(16, 3) where the speaker is."""
    distance, angle = np.array(DISTANCE_AND_ANGLE_DEG).T
    sine, cosine = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    return distance[:, None] * np.column_stack([sine, np.zeros(len(sine)), cosine])


def echoes(name: str, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    """(16, 2, F) transfer functions from speakers to microphones at w - j sigma."""
    body = Body.of(meridian(name), [False, True, True, False], FREQUENCY_HZ[-1], SPEED_M_S, ground=False)
    return transfer(body, speakers(), frequency_hz)


def main() -> None:
    """Compute and store (3 bodies, 16 speakers, 2 microphones, F) transfer functions."""
    every = np.stack([echoes(name, FREQUENCY_HZ) for name in RADIUS_AND_LENGTH_M])
    np.savez_compressed(STORED, name=np.array(list(RADIUS_AND_LENGTH_M)), frequency_hz=FREQUENCY_HZ, transfer=every)


if __name__ == "__main__":
    main()
