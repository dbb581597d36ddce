"""How reflectors send sound on, and the numbers by which `Paths.sequence` counts them through."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Ints


class Interaction(IntEnum):
    """What happens to sound at one point of a path; -1 stands for a point that a shorter path does not have."""

    SPECULAR = 0  # at a planar patch
    CURVED = 1  # at a smooth surface
    EDGE = 2
    KIRCHHOFF = 3  # over a body by the integral


@dataclass(frozen=True)
class Numbering:
    """All reflectors of a world in one row: patches, smooth surfaces, edges, then obstacles as bodies.

    Attributes:
        first: (4,) number of the first reflector of every interaction.
    """

    first: Ints

    def number(self, interaction: Interaction, index: ArrayLike) -> Ints:
        """Numbers of the reflectors that are `index` among those of one interaction."""
        return self.first[interaction] + np.asarray(index)

    def interaction(self, number: Ints) -> Ints:
        """The interaction of every number; -1 for -1."""
        return np.searchsorted(self.first, number, side="right") - 1
