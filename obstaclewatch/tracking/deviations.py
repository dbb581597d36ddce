"""Numbers as networks take them: centred, scaled and limited, so that nothing unusual can decide alone."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats

MOST_DEVIATIONS = 5.0
"""Beyond which a number counts as so many."""


def deviations(numbers: Floats, usual: Floats, spread: Floats) -> Floats:
    """(n, F) how far numbers (n, F) are from what is usual (F,), in its spread (F,); what is missing is usual."""
    return np.nan_to_num(np.clip((numbers - usual) / spread, -MOST_DEVIATIONS, MOST_DEVIATIONS))
