"""What is loud enough to be worth its cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats
from simulator.scene.fidelity import Fidelity


@dataclass(frozen=True)
class Audible:
    """Bounds under which a diffracted or scattered contribution is left out.

    Attributes:
        floor: gain under which a contribution is faint.
        share: of the strongest echo at the same pose and microphone: what exceeds it is kept even if it is faint.
        least: gain that nothing may stay below.
    """

    floor: float
    share: float
    least: float = 0.0

    @classmethod
    def of(cls, fidelity: Fidelity) -> Audible:
        """The bounds of a fidelity."""
        return cls(10.0 ** (fidelity.edge_floor_db / 20.0), 10.0 ** (fidelity.edge_share_db / 20.0))

    def __call__(self, gain: Floats, strongest: Floats) -> Flags:
        """(R,) whether gains are kept beside the strongest of their pose and microphone."""
        return gain >= np.maximum(np.minimum(self.floor, self.share * strongest), self.least)
