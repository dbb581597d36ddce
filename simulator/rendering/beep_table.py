"""The emitted beep, as each Chebyshev polynomial of frequency filters it, with the chirp's own phase taken out.

A linear chirp that is filtered stays close to itself: what is left of it when its phase is taken out follows the window
and the filter at the instantaneous frequency, over milliseconds. Cubic splines of that through 24,000 nodes a second
are right to 5e-7 of the peak for the paper's beep; a beep that changes faster is given more nodes.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.fft
from numpy.polynomial import chebyshev
from scipy.ndimage import spline_filter1d

from obstaclewatch.beep import BeepDesign
from obstaclewatch.support.arrays import Complexes, Floats, Singles
from simulator.phone.transducers import Transducer
from simulator.waves import band
from simulator.waves.band import REFERENCE_HZ

SKIRT_S = 2.5e-4  # kept before and after the beep; a galaxy-s5's speaker rings on there with 3e-4 of the peak
TOLERANCE = 6e-7  # of the peak
LEAD = 20  # nodes beyond the skirt, which the ends of a spline spoil
MOST_STEPS = 64  # 1.5 MHz, for beeps of 1 ms
QUIET_S = 1.2  # of silence in the circle of the Fourier transform; what a galaxy-s5's speaker rings past it: 4e-7
KEPT = 8  # tables, 0.2 MB each for the paper's beep
FINE = 2  # samples a node in that transform
GROUP = 5  # terms that are weighted and added at a time
LINE = 16  # numbers in a line of the cache: rows that begin within one take half as long again to read


class BeepTable(NamedTuple):
    """Cubic splines of K filtered beeps, chirp taken out; a tuple, as compiled functions take it.

    Attributes:
        splines: (G, 2, GROUP, n) float32 coefficients at the nodes, real and imaginary part; 0 past the K-th.
        lead: number of the node at the beep's first instant.
        steps: nodes a sample of the envelopes that are summed.
        duration_s: of the beep.
        start_hz, slope_hz_s: instantaneous frequency at first, and its slope.
    """

    splines: Singles
    lead: int
    steps: int
    duration_s: float
    start_hz: float
    slope_hz_s: float


def beep_table(beep: BeepDesign, speaker: Transducer, terms: int, rate_hz: float) -> BeepTable:
    """The beep from a speaker through the first Chebyshev polynomials of frequency, for envelopes of a rate.

    Raises:
        ValueError: a beep so short that `MOST_STEPS` nodes a sample miss it by more than `TOLERANCE`.
    """
    hz, db = (np.asarray(column, dtype=np.float64) for column in (speaker.response_hz, speaker.response_db))
    return _kept(beep, hz.tobytes(), db.tobytes(), terms, rate_hz)


@lru_cache(KEPT)
def _kept(beep: BeepDesign, response_hz: bytes, response_db: bytes, terms: int, rate_hz: float) -> BeepTable:
    """`beep_table` by the content of the speaker's table; what it directs where is not in it."""
    speaker = Transducer(np.frombuffer(response_hz), np.frombuffer(response_db))
    steps = 1
    while True:
        lead = LEAD + round(SKIRT_S * steps * rate_hz)
        fine = _filtered_beeps(beep, speaker, terms, steps * rate_hz, lead, QUIET_S / np.sqrt(steps))
        nodes, between = fine[:, ::FINE], fine[:, FINE // 2 :: FINE]
        splines = np.stack([spline_filter1d(part, axis=1) for part in (nodes.real, nodes.imag)], axis=1)
        error = np.abs(_halfway(splines) - between[:, 1:-2])[:, LEAD:-LEAD].max() / np.abs(nodes[0]).max()
        if error < TOLERANCE:
            chirp = beep.duration_s, beep.start_hz, beep.chirp_rate_hz_s
            return BeepTable(_laid_out(splines), lead, steps, *chirp)
        if steps == MOST_STEPS:
            raise ValueError(f"the beep must last, and rise and fall within, about 1 ms or more, got {beep}")
        steps *= 2


def _laid_out(splines: Floats) -> Singles:
    """(G, 2, GROUP, n) single precision of (K, 2, n), filled up with zeros, each row from the start of a line."""
    terms, _, nodes = splines.shape
    shape = -(-terms // GROUP), 2, GROUP, -(-nodes // LINE) * LINE
    room = np.zeros(np.prod(shape) + LINE, dtype=np.float32)
    first = -room.ctypes.data // room.itemsize % LINE
    table = room[first : first + np.prod(shape)].reshape(shape)
    for k in range(terms):
        table[k // GROUP, :, k % GROUP, :nodes] = splines[k]
    table.flags.writeable = False
    return table


def _filtered_beeps(
    beep: BeepDesign, speaker: Transducer, terms: int, rate_hz: float, lead: int, quiet_s: float
) -> Complexes:
    """(K, n) filtered beeps over their chirp, `FINE` samples a node, `lead` nodes before the beep and after it."""
    count = FINE * (2 * lead + int(np.ceil(beep.duration_s * rate_hz)) + 1)
    time = (np.arange(count) - FINE * lead) / (FINE * rate_hz)
    chirp = np.exp(1j * (beep.phase_rad(time) - 2.0 * np.pi * REFERENCE_HZ * time))
    size = scipy.fft.next_fast_len(count + round(quiet_s * FINE * rate_hz))
    frequency = scipy.fft.fftfreq(size, 1.0 / (FINE * rate_hz)) + REFERENCE_HZ
    unit = np.clip(band.to_unit(frequency), -1.0, 1.0)
    filters = chebyshev.chebvander(unit, terms - 1).T * speaker.response(frequency)
    spectrum = scipy.fft.fft(beep.window(time) * chirp, n=size)
    return scipy.fft.ifft(spectrum * filters, axis=1)[:, :count] / chirp


def _halfway(splines: Floats) -> Complexes:
    """(K, n - 3) values halfway between nodes, from the second on."""
    near, far = splines[..., 1:-2] + splines[..., 2:-1], splines[..., :-3] + splines[..., 3:]
    halfway = (23.0 * near + far) / 48.0
    return halfway[:, 0] + 1j * halfway[:, 1]
