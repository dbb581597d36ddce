"""Make cylinder_values.npz: exact echoes of endless rigid cylinders. Run from the repository root:

python -m tests.references.make_cylinder_values
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.references import chirp, rigid_cylinder

SPEED_M_S = 343.0
RADIUS_M = np.array([0.03, 0.05, 0.1, 0.15, 0.25, 0.35])
GAP_M = np.array([0.3, 0.6, 1.5, 3.0, 5.0, 7.0])  # from the speaker to the surface
MIC_DISTANCE_M = np.array([0.05, 0.16])
STORED = Path(__file__).with_name("cylinder_values.npz")


def speakers(radius_m: float) -> NDArray[np.float64]:
    """(6, 3) speaker at every gap, on different sides."""
    angle = 0.3 + 1.1 * np.arange(len(GAP_M))
    return (radius_m + GAP_M)[:, None] * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)


def mics(speaker_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """(6, 2, 3) two microphones, 5 and 16 cm off, on one line tilted differently at every speaker."""
    outwards = speaker_m / np.linalg.norm(speaker_m, axis=1, keepdims=True)
    around, tilt = np.cross([0.0, 0.0, 1.0], outwards), np.array([0.2, 0.9, 1.4, -0.5, 0.6, 1.1])[:, None]
    turn = np.array([0.0, 0.7, 1.3, 0.4, 1.5, 0.1])[:, None]
    line = np.cos(tilt) * (np.cos(turn) * outwards + np.sin(turn) * around) + np.sin(tilt) * np.array([0.0, 0.0, 1.0])
    return speaker_m[:, None] + np.array([1.0, -1.0])[:, None] * MIC_DISTANCE_M[:, None] * line[:, None]


def main() -> None:
    """Compute and store (R, 6, 2, NODES) transfer functions; the worst Neumann residual goes with them."""
    source = np.stack([speakers(radius) for radius in RADIUS_M])
    receiver = np.stack([mics(each) for each in source])
    transfer = np.array([
        [
            [
                rigid_cylinder.scattered(radius, source[i, p], receiver[i, p, m], chirp.nodes_hz(), SPEED_M_S)
                for m in range(2)
            ]
            for p in range(len(GAP_M))
        ]
        for i, radius in enumerate(RADIUS_M)
    ])  # fmt: skip
    np.savez_compressed(
        STORED, radius_m=RADIUS_M, gap_m=GAP_M, source_m=source, receiver_m=receiver,
        frequency_hz=chirp.nodes_hz(), speed_m_s=SPEED_M_S, transfer=transfer,
    )  # fmt: skip


if __name__ == "__main__":
    main()
