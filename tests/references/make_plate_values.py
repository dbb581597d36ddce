"""Make plate_values.npz: full-wave echoes of thin plates from square-on to edge-on. From the repository root:

python -m tests.references.make_plate_values

takes about 50 minutes on one core. Against grids half as fine again: 0.02 dB at 75 degrees of yaw, 0.4 dB at 85.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.references import thin_plate

SPEED_M_S = 343.0
STORED = Path(__file__).with_name("plate_values.npz")
FREQUENCY_HZ = np.arange(18_000.0, 23_001.0, 250.0)
DISTANCE_M = 1.5
# plate along y and z, steps of the coarser grid, height of the phone over the plate's centre, yaws in degrees
SERIES = (
    ((0.20, 0.30), (120, 180), 0.03, (75, 90, 60, 85, 80, 70, 65, 45, 30, 15, 55, 50, 40, 35, 25, 20, 10, 5, 0)),
    ((0.20, 0.30), (120, 180), 0.50, (75, 90, 60, 85, 80, 70, 65, 45, 30, 15)),
    ((0.45, 0.45), (400, 200), 0.03, (75, 90, 60)),
)
RECEIVERS_M = np.array([[0.0, 0.16, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.16]])  # from the speaker, plate square-on


def points(height_m: float, yaw_deg: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(3,) speaker and (3, 3) receivers round the plate's upright axis: 16 cm aside, at the speaker, 16 cm above."""
    c, s = np.cos(np.deg2rad(yaw_deg)), np.sin(np.deg2rad(yaw_deg))
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    speaker = np.array([DISTANCE_M, -0.08, height_m])
    return turn @ speaker, (speaker + RECEIVERS_M) @ turn.T


def main() -> None:
    """Compute and store (C, 3, F) transfer functions of all cases."""
    cases = [(size, steps, height, yaw) for size, steps, height, yaws in SERIES for yaw in yaws]
    echoes = np.empty((len(cases), len(RECEIVERS_M), len(FREQUENCY_HZ)), dtype=complex)
    for i, (size, steps, height, yaw) in enumerate(cases):
        source, receivers = points(height, yaw)
        for n, frequency in enumerate(FREQUENCY_HZ):
            wavenumber = 2.0 * np.pi * frequency / SPEED_M_S
            echoes[i, :, n] = thin_plate.echo(size, wavenumber, source, receivers, steps)
        _store(cases[: i + 1], echoes[: i + 1])


def _store(cases: list, echoes: NDArray[np.complex128]) -> None:
    ends = [points(height, yaw) for _, _, height, yaw in cases]
    np.savez(
        STORED, frequency_hz=FREQUENCY_HZ, size_m=np.array([size for size, _, _, _ in cases]),
        height_m=np.array([height for _, _, height, _ in cases]), yaw_deg=np.array([yaw for _, _, _, yaw in cases]),
        source_m=np.array([source for source, _ in ends]), receiver_m=np.array([each for _, each in ends]),
        transfer=echoes,
    )  # fmt: skip


if __name__ == "__main__":
    main()
