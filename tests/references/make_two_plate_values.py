"""Make two_plate_values.npz: full-wave echoes of a plate that another one hides in part. From the repository root:

python -m tests.references.make_two_plate_values

takes about 10 minutes on one core. Against grids of steps 0.6 times as long: 0.02 dB.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.references import two_plates

SPEED_M_S = 343.0
STORED = Path(__file__).with_name("two_plate_values.npz")
FREQUENCY_HZ = np.arange(18_000.0, 23_001.0, 250.0)
SIZE_M, STEPS = (0.2, 0.2), (60, 60)
BEHIND_M, ASIDE_M = 0.12, 0.12  # of the plate behind re the one before
DISTANCE_M, HEIGHT_M = 1.5, 0.02  # of the speaker
PAST_EDGE_M = np.array([-0.08, -0.05, -0.03, -0.02, -0.01, 0.0, 0.01, 0.02, 0.03, 0.05, 0.08])  # of the plate before
RECEIVERS_M = np.array([[0.0, 0.0, 0.0], [0.0, 0.07, 0.03]])  # from the speaker


def speaker(past_edge_m: float) -> np.ndarray:
    """(3,) so far beyond the edge of the plate before."""
    return np.array([DISTANCE_M, 0.5 * SIZE_M[0] + past_edge_m, HEIGHT_M])


def main() -> None:
    """Compute and store (C, 2, F) transfer functions of all places of the speaker."""
    echoes = np.empty((len(PAST_EDGE_M), len(RECEIVERS_M), len(FREQUENCY_HZ)), dtype=complex)
    for i, past_m in enumerate(PAST_EDGE_M):
        source = speaker(past_m)
        for n, frequency in enumerate(FREQUENCY_HZ):
            wavenumber = 2.0 * np.pi * frequency / SPEED_M_S
            echoes[i, :, n] = two_plates.echo(
                SIZE_M, BEHIND_M, ASIDE_M, wavenumber, source, source + RECEIVERS_M, STEPS
            )
    np.savez(STORED, transfer=echoes)


if __name__ == "__main__":
    main()
