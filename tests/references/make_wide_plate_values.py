"""Make wide_plate_values.npz: echoes of plates too wide for boundary elements at hand. From the repository root:

python -m tests.references.make_wide_plate_values

takes about 20 minutes on one core. Yaws at which no mirror image is seen: the edges send everything.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.references import edge_equation
from tests.references.make_plate_values import SPEED_M_S, points

STORED = Path(__file__).with_name("wide_plate_values.npz")
FREQUENCY_HZ = np.arange(18_000.0, 23_001.0, 200.0)
ORDERS, PIECE_M = 6, 0.01
SIZE_M, HEIGHT_M = (0.9, 0.9), 0.03
YAWS_DEG = (75.0, 60.0, 85.0, 40.0)


def main() -> None:
    """Compute and store (C, 3, F) transfer functions of all cases."""
    ends = [points(HEIGHT_M, yaw) for yaw in YAWS_DEG]
    wavenumber = 2.0 * np.pi * FREQUENCY_HZ / SPEED_M_S
    done = []
    for source, receivers in ends:
        done.append(edge_equation.echo(SIZE_M, wavenumber, source, receivers, ORDERS, PIECE_M).sum(axis=0))
        count = len(done)
        np.savez(
            STORED, frequency_hz=FREQUENCY_HZ, size_m=np.tile(SIZE_M, (count, 1)), height_m=np.full(count, HEIGHT_M),
            yaw_deg=np.array(YAWS_DEG[:count]), source_m=np.array([end[0] for end in ends[:count]]),
            receiver_m=np.array([end[1] for end in ends[:count]]), transfer=np.array(done),
        )  # fmt: skip


if __name__ == "__main__":
    main()
