"""Make pillar_values.npz: full-wave echoes of walls with pillars, a niche and a step. From the repository root:

python -m tests.references.make_pillar_values

takes about 20 minutes on one core. With elements 0.7 times as long: within 0.002 of a wall's echo, and of 0.005 for the
niche and the step.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.references import prism

SPEED_M_S = 343.0
STORED = Path(__file__).with_name("pillar_values.npz")
FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 11)
DAMPING_1_S = 300.0


@dataclass(frozen=True)
class Case:
    """Upright boxes before a wall or in the open, and a phone that looks at them.

    Attributes:
        boxes: near and far end in x, and both ends in y, of each, m.
        wall_m: x of the wall, at which boxes end that stand on it; None without one.
        away_m: x of the phone is minus this.
        beside_m: y of the microphone beyond the speaker's.
        aside_m: (Y,) y of the speaker.
        step_m: longest element.
    """

    boxes: tuple[tuple[float, float, float, float], ...]
    wall_m: float | None
    away_m: float
    beside_m: float
    aside_m: tuple[float, ...]
    step_m: float

    @property
    def source_m(self) -> np.ndarray:
        """(Y, 2) where the speaker stands."""
        return np.array([[-self.away_m, y] for y in self.aside_m])


PAST = (
    -0.301,
    -0.202,
    -0.151,
    -0.101,
    -0.051,
    0.011,
    0.052,
    0.091,
    0.121,
    0.133,
    0.141,
    0.149,
    0.161,
    0.202,
    0.251,
    0.301,
)
BEFORE = (-0.4, -0.301, -0.202, -0.151, -0.101, -0.05, 0.011, 0.052, 0.121, 0.161, 0.231, 0.331)
CASES = {
    "pillar": Case(((0.0, 0.0866, -0.15, 0.15),), 0.0866, 1.0, 0.02, PAST, 0.7e-3),
    "pilaster": Case(((0.0, 0.03, -0.15, 0.15),), 0.03, 1.0, 0.14, PAST, 0.7e-3),
    "pier": Case(((0.0, 0.2, -0.2, 0.2),), 0.2, 1.5, -0.12, PAST, 0.7e-3),
    "niche": Case(((0.0, 0.1, -0.5, -0.1), (0.0, 0.1, 0.1, 0.5)), 0.1, 1.0, 0.07, BEFORE, 1.2e-3),
    "step": Case(((0.0, 0.3, -0.3, 0.0), (0.1, 0.3, 0.0, 0.3)), None, 1.0, 0.07, BEFORE, 1.2e-3),
}


def wavenumbers() -> np.ndarray:
    """(F,) damped ones."""
    return (2.0 * np.pi * FREQUENCY_HZ - 1j * DAMPING_1_S) / SPEED_M_S


def echoes(case: Case, wavenumber: complex) -> np.ndarray:
    """(Y,) echoes, times sqrt(L). A wall is the images of boxes and speaker: a box on it is one prism with its own."""
    outline = tuple(np.concatenate(ends) for ends in zip(*_outlines(case), strict=True))
    source, each = case.source_m, np.arange(len(case.aside_m))
    receiver = source + [0.0, case.beside_m]
    if case.wall_m is None:
        return prism.as_point_source(prism.scattered(outline, wavenumber, source, receiver)[each, each], wavenumber)
    image = source * [-1.0, 1.0] + [2.0 * case.wall_m, 0.0]
    field = prism.scattered(outline, wavenumber, np.concatenate([source, image]), receiver)
    total = field[each, each] + field[len(each) + each, each] + prism.free(receiver, image, wavenumber)[each, each]
    return prism.as_point_source(total, wavenumber)


def _outlines(case: Case) -> list[tuple[np.ndarray, np.ndarray]]:
    found = []
    for near, far, low, high in case.boxes:
        far = far if case.wall_m is None else 2.0 * case.wall_m - near
        corner = np.array([[near, low], [far, low], [far, high], [near, high]])
        found.append(prism.elements(corner, case.step_m))
    return found


def main() -> None:
    """Compute and store (Y, F) echoes of all cases."""
    stored = {name: np.stack([echoes(case, k) for k in wavenumbers()], axis=1) for name, case in CASES.items()}
    np.savez(STORED, **stored)


if __name__ == "__main__":
    main()
