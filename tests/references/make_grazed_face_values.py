"""Make grazed_face_values.npz: full-wave echoes of free pillars with a side edge-on. From the repository root:

python -m tests.references.make_grazed_face_values

takes about 20 s on one core. Against quadrature with Gauss panels graded to the corners: within 0.001 of a wall's echo.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.references import prism
from tests.references.make_pillar_values import DAMPING_1_S, SPEED_M_S

STORED = Path(__file__).with_name("grazed_face_values.npz")
FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 5)
BESIDE_M, STEP_M = 0.02, 0.7e-3
TURN = np.radians([0.0, 120.0, 240.0])
TRIANGLE = 0.2 / np.sqrt(3.0) * np.column_stack([np.cos(TURN), np.sin(TURN)])
BOX = np.array([[0.0, -0.15], [0.05, -0.15], [0.05, 0.15], [0.0, 0.15]])


def round_about() -> np.ndarray:
    """(S, 2) speakers 0.7 m from the triangle's middle: from 20 to 35 degrees its second side drops out of view."""
    angle = np.radians(np.arange(20.0, 36.0, 2.5))
    return 0.7 * np.column_stack([np.cos(angle), np.sin(angle)])


def past_box() -> np.ndarray:
    """(S, 2) speakers 1 m before the box, from before its middle to beside it."""
    aside = np.arange(0.003, 0.21, 0.025)
    return np.column_stack([np.full(len(aside), -1.0), aside])


CASES = {"triangle": (TRIANGLE, round_about()), "box": (BOX, past_box())}


def microphones(source_m: np.ndarray) -> np.ndarray:
    """(S, 2) beside the speakers, square to the way to the pillar."""
    across = np.column_stack([-source_m[:, 1], source_m[:, 0]])
    return source_m + BESIDE_M * across / np.linalg.norm(source_m, axis=1)[:, None]


def main() -> None:
    """Compute and store (S, F) echoes, times sqrt(L)."""
    stored = {}
    for name, (corner, source) in CASES.items():
        outline, each = prism.elements(corner, STEP_M), np.arange(len(source))
        values = []
        for k in (2.0 * np.pi * FREQUENCY_HZ - 1j * DAMPING_1_S) / SPEED_M_S:
            field = prism.scattered(outline, k, source, microphones(source))[each, each]
            values.append(prism.as_point_source(field, k))
        stored[name] = np.stack(values, axis=1)
    np.savez(STORED, **stored)


if __name__ == "__main__":
    main()
