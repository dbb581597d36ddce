"""Make revolved_values.npz: full-wave echoes of round bodies on rigid ground. Run from the repository root:

python -m tests.references.make_revolved_values    # half an hour on one core
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.references.revolved_body import Body, Piece

SPEED_M_S, DAMPING_1_S = 343.0, 400.0
FREQUENCY_HZ = np.arange(17_500.0, 23_501.0, 200.0)
GAP_AND_HEIGHT_M = ((0.6, 1.2), (1.0, 1.0), (1.0, 1.35), (1.6, 1.3), (2.4, 1.2), (1.2, 0.45))  # of the speaker
MICS_M = np.array([[0.02, 0.07, 0.03], [-0.05, -0.06, -0.02]])  # from the speaker
STORED = Path(__file__).with_name("revolved_values.npz")

MERIDIANS: dict[str, list[Piece]] = {
    "upright": [Piece((0.15, 0.0), (0.15, 0.5)), Piece((0.15, 0.5), (0.0, 0.5))],
    "leaning back": [Piece((0.17, 0.0), (0.14, 0.5)), Piece((0.14, 0.5), (0.0, 0.5))],
    "leaning forward": [Piece((0.14, 0.0), (0.17, 0.5)), Piece((0.17, 0.5), (0.0, 0.5))],
    "leaning by half a degree": [Piece((0.15, 0.0), (0.1544, 0.5)), Piece((0.1544, 0.5), (0.0, 0.5))],
    "cone": [Piece((0.16, 0.0), (0.03, 0.5)), Piece((0.03, 0.5), (0.0, 0.5))],
    "domed": [Piece((0.1, 0.0), (0.1, 0.5)), Piece((0.1, 0.5), (0.0, 0.6), (0.0, 0.5))],
}
"""Round bodies on the ground; what closes them below lies on it."""
MERIDIANS["domed and clothed"] = MERIDIANS["domed"]
REFLECTION = {name: 0.56 if "clothed" in name else 1.0 for name in MERIDIANS}
"""At normal incidence. Surfaces react locally."""


def corners(name: str) -> list[bool]:
    """Whether the meridian has a corner at its foot, where it meets its image, at its rim and at its top."""
    return ["leaning" in name or name == "cone", "domed" not in name, False]


def speakers(name: str) -> NDArray[np.float64]:
    """(6, 3) where the speaker is, beside the body's widest place."""
    radius = max(piece.begin[0] for piece in MERIDIANS[name])
    return np.array([[-(radius + gap), 0.0, height] for gap, height in GAP_AND_HEIGHT_M])


def echoes(name: str, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    """(6, 2, F) transfer functions from speakers to microphones at w - j sigma."""
    admittance = (1.0 - REFLECTION[name]) / (1.0 + REFLECTION[name])
    body = Body.of(MERIDIANS[name], corners(name), FREQUENCY_HZ[-1], SPEED_M_S, True, admittance)
    return transfer(body, speakers(name), frequency_hz)


def transfer(body: Body, source_m: NDArray[np.float64], frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    """(S, 2, F) what a body returns from speakers (S, 3) to their microphones at w - j sigma."""
    wavenumber = (2.0 * np.pi * frequency_hz - 1j * DAMPING_1_S) / SPEED_M_S
    return np.stack([body.scattered(source_m, source_m[:, None] + MICS_M, k) for k in wavenumber], axis=-1)


def main() -> None:
    """Compute and store (7 bodies, 6 speakers, 2 microphones, F) transfer functions."""
    every = np.stack([echoes(name, FREQUENCY_HZ) for name in MERIDIANS])
    np.savez_compressed(STORED, name=np.array(list(MERIDIANS)), frequency_hz=FREQUENCY_HZ, transfer=every)


if __name__ == "__main__":
    main()
