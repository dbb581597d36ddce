"""Errors of every resolved echo, not of the strongest alone."""

from __future__ import annotations

import numpy as np
from scipy.signal import find_peaks

from obstaclewatch.support.arrays import Complexes, Floats

AUDIBLE_DB = -45.0  # re the free field at 1 m: a quiet street's noise after the matched filter
DIP_DB = 3.0  # between an echo and any louder one
NEAR_SAMPLES = 12.0  # of 192 kHz, either way: where the same echo is looked for


def resolved_errors(ours: Complexes, theirs: Complexes, rate_hz: float) -> dict[str, list[float]]:
    """Of all resolved echoes in compressed ones (R, L) what ours differ in from better ones.

    Returns:
        "resolved_db" and "resolved_samples" (192 kHz), one entry an echo: our highest value near its peak.
    """
    lags = theirs.shape[1]
    reach = round(NEAR_SAMPLES * rate_hz / 192_000.0)
    near = np.arange(-reach, reach + 1)
    louder, later = [], []
    for got, best in zip(levels_db(ours), levels_db(theirs), strict=True):
        peak, _ = find_peaks(best, height=AUDIBLE_DB, prominence=DIP_DB)
        found = got[(peak[:, None] + near) % lags]
        louder += (found.max(axis=1) - best[peak]).tolist()
        later += (near[found.argmax(axis=1)] * 192_000.0 / rate_hz).tolist()
    return {"resolved_db": louder, "resolved_samples": later}


def levels_db(envelopes: Complexes) -> Floats:
    """Levels of compressed echoes (R, L), dB re the free field at 1 m; -240 where there is nothing."""
    return 20.0 * np.log10(np.abs(envelopes) + 1e-12)
