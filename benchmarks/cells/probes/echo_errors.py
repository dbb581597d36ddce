"""Errors of compressed echoes: of the strongest, and of every one that is resolved."""

from __future__ import annotations

import numpy as np
import scipy

from benchmarks.cells.probes.compressed_echoes import levels_db
from obstaclewatch.support.arrays import Complexes

AUDIBLE_DB = -45.0  # re the free field at 1 m: a quiet street's noise after the matched filter
MATTERS_DB = AUDIBLE_DB - 15.0  # well under that noise
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
        peak, _ = scipy.signal.find_peaks(best, height=AUDIBLE_DB, prominence=DIP_DB)
        found = got[(peak[:, None] + near) % lags]
        louder += (found.max(axis=1) - best[peak]).tolist()
        later += (near[found.argmax(axis=1)] * 192_000.0 / rate_hz).tolist()
    return {"resolved_db": louder, "resolved_samples": later}


def envelope_errors(ours: Complexes, theirs: Complexes, rate_hz: float) -> dict[str, list[float]]:
    """Level, delay (samples of 192 kHz) and correlation of compressed echoes (R, L) against better ones, where these
    are above `MATTERS_DB`."""
    level, best = (levels_db(each).max(axis=1) for each in (ours, theirs))
    loud = np.flatnonzero(best > MATTERS_DB)
    late = (np.abs(ours).argmax(axis=1) - np.abs(theirs).argmax(axis=1)) * 192_000.0 / rate_hz
    inner = np.real(np.sum(ours * np.conj(theirs), axis=1))
    norms = np.linalg.norm(ours, axis=1) * np.linalg.norm(theirs, axis=1)
    return {
        "level_db": (level - best)[loud].tolist(),
        "delay_samples": late[loud].tolist(),
        "correlation": (inner / np.maximum(norms, 1e-300))[loud].tolist(),
    }
