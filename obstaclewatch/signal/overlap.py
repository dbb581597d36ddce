"""Two echoes within one pulse: the pair of delays that explains a crest best, both amplitudes free.

After compression noise has the pulse's own autocorrelation, so that the likelihood of two delays needs the envelope at
these two alone: with y the envelope there and rho the pulse at their distance,
    J = (|y1|^2 + |y2|^2 - 2 rho Re(y1* y2)) / (1 - rho^2)
is the energy that they explain, and the amplitudes follow from the same two equations: least squares with what is
linear eliminated (Golub and Pereyra 1973, SIAM J. Numer. Anal. 10:413).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.beep import BeepDesign
from obstaclewatch.signal.echoes import Echoes, refined_peak
from obstaclewatch.signal.matched_filter import EchoProfile, MatchedFilter
from obstaclewatch.support.arrays import Complexes, Floats
from obstaclewatch.support.compiled import compiled, inlined

TABLE_S, FINE = 5e-3, 16
"""Of the pulse's table: reach of the filter that makes it, and entries per sample of the envelope."""
REACH = 10
"""Samples on either side of a peak in which its echoes are looked for: 14 cm of path."""
CLOSEST, FARTHEST = 2, 14
"""Samples between two echoes in the search: nearer than 3 cm of path amplitudes grow without bound, farther pulses
part."""
SKIRT = 6
"""Samples beside the echoes over which they must explain the crest."""
APART = 3.5
"""Samples, 5 cm of path, that two echoes must be apart: what seems nearer a phone's response makes of one."""
STENCIL, MOST_STENCILS = 0.25, 4.0
"""Step, in samples, of the parabolas by which the best of every other sample is refined, and how many it moves."""
CLIMBS, CLOSE_ENOUGH = 8, 0.02
"""Steps at most, and the share of a stencil that ends them: 0.07 mm of path."""
LEAST_GAIN = 20.0
"""Energy that the second echo must explain, over noise power."""
LEAST_SHARE = 0.45
"""Of the stronger echo's amplitude that the weaker must have: less moves a peak little, and a phone's own response
makes as much of a single echo."""
MOST_LEFT, NOISE_LEFT = 0.06, 3.5
"""Of the stronger amplitude, and of the noise's rms, that may be left: more has other causes than two echoes."""
AS_ONE, AS_ONE_NOISE = 0.03, 2.5
"""The same of a single pulse, for a crest not to be parted."""


class Pair(NamedTuple):
    """Two echoes: positions and their deviations by noise in samples, complex amplitudes.

    `found` says whether they explain the crest.
    """

    position: tuple[float, float]
    std: tuple[float, float]
    amplitude: tuple[complex, complex]
    found: bool


class Crests(NamedTuple):
    """Echoes of one channel, crests parted, in order.

    Attributes:
        position: (n,) in samples.
        std: (n,) deviation of it by noise where a crest was parted, 0 elsewhere.
        amplitude: (n,) complex.
    """

    position: Floats
    std: Floats
    amplitude: Complexes

    def echoes(self, profile: EchoProfile) -> Echoes:
        """The same on the profile's delay axis."""
        delay_s = profile.start_s + self.position / profile.rate_hz
        return Echoes(delay_s, np.abs(self.amplitude), np.round(self.position).astype(np.intp))


@lru_cache(maxsize=8)
def pulse_table(beep: BeepDesign) -> Floats:
    """The compressed pulse from its middle on, at every `FINE`th of a sample of the filter's; it is even."""
    compressor = MatchedFilter(beep, TABLE_S)
    count, middle = 2 * (REACH + FARTHEST), 20
    time_s = np.arange(compressor.block_samples) / beep.sample_rate_hz
    table = np.empty(count * FINE)
    for part in range(FINE):
        profile = compressor.compress(beep.waveform(time_s - (middle - part / FINE) / compressor.rate_hz)[None])
        first = profile.position(0.0) + middle
        table[part::FINE] = profile.magnitude[0, first : first + count]
    return table


@compiled
def parted_crests(envelope: Complexes, peaks: NDArray[np.intp], table: Floats, noise: float) -> Crests:
    """Echoes of the crests about given peaks, in order: one each, or two where two explain what one does not.

    Args:
        envelope: (M,) of one channel.
        peaks: (n,) samples, in order.
        table: from `pulse_table`.
        noise: rms of the envelope's noise.
    """
    position, std = np.empty(2 * len(peaks)), np.zeros(2 * len(peaks))
    amplitude = np.empty(2 * len(peaks), dtype=np.complex128)
    count, last = 0, -np.inf
    margin = REACH + CLIMBS + SKIRT + 3  # a climb moves a sample at most
    for peak in peaks:
        if peak < last + CLOSEST:
            continue
        if margin <= peak < len(envelope) - margin and not is_one_pulse(envelope, peak, table, noise):
            pair = two_echoes(envelope, peak, table, noise)
            if pair.found and pair.position[0] > last:
                for which in range(2):
                    position[count], std[count] = pair.position[which], pair.std[which]
                    amplitude[count] = pair.amplitude[which]
                    count += 1
                last = pair.position[1]
                continue
        position[count], amplitude[count] = _single(envelope, peak)
        last = position[count]
        count += 1
    return Crests(position[:count], std[:count], amplitude[:count])


@compiled
def nearest_echoes(crests: Crests, position: Floats) -> tuple[Floats, Floats]:
    """(n,) phases, rad, and (n,) deviations, samples, of the echoes next to positions; NaN stays NaN."""
    phase, std = np.full(len(position), np.nan), np.full(len(position), np.nan)
    for row in range(len(position)):
        if np.isfinite(position[row]):
            nearest = np.argmin(np.abs(crests.position - position[row]))
            phase[row], std[row] = np.angle(crests.amplitude[nearest]), crests.std[nearest]
    return phase, std


@inlined
def is_one_pulse(envelope: Complexes, peak: int, table: Floats, noise: float) -> bool:
    """Whether a single pulse leaves little of the crest about a peak."""
    middle, amplitude = _single(envelope, peak)
    left = 0.0
    for sample in range(peak - SKIRT, peak + SKIRT + 1):
        left = max(left, abs(envelope[sample] - amplitude * pulse_at(table, sample - middle)))
    return left <= AS_ONE * abs(amplitude) + AS_ONE_NOISE * noise


@inlined
def two_echoes(envelope: Complexes, peak: int, table: Floats, noise: float) -> Pair:
    """The pair of echoes about a peak that explains most; arguments as of `parted_crests`."""
    energy, early, late, sharpness = _refined(envelope, _coarse(envelope, peak, table), table)
    rho = pulse_at(table, late - early)
    first, second = smooth_at(envelope, early), smooth_at(envelope, late)
    one, other = (first - rho * second) / (1.0 - rho * rho), (second - rho * first) / (1.0 - rho * rho)
    strong, weak = max(abs(one), abs(other)), min(abs(one), abs(other))
    gains = energy - abs(envelope[peak]) ** 2 > LEAST_GAIN * noise**2
    left = 0.0
    for sample in range(min(int(early), peak) - SKIRT, max(int(late), peak) + SKIRT + 1):
        modelled = one * pulse_at(table, sample - early) + other * pulse_at(table, sample - late)
        left = max(left, abs(envelope[sample] - modelled))
    explains = gains and left <= MOST_LEFT * strong + NOISE_LEFT * noise
    std = noise * np.sqrt(sharpness[0]), noise * np.sqrt(sharpness[1])
    is_top = np.isfinite(std[0]) and np.isfinite(std[1])
    found = explains and is_top and late - early >= APART and weak >= LEAST_SHARE * strong
    return Pair((early, late), std, (one, other), found)


@compiled
def pulse_at(table: Floats, offset: float) -> float:
    """The pulse so many samples beside its middle."""
    along = abs(offset) * FINE
    low = int(along)
    if low >= len(table) - 1:
        return 0.0
    return float(table[low] + (along - low) * (table[low + 1] - table[low]))


@compiled
def smooth_at(envelope: Complexes, position: float) -> complex:
    """An envelope between its samples, by the cubic through four."""
    low = int(position)
    t = position - low
    return (
        -t * (t - 1.0) * (t - 2.0) / 6.0 * envelope[low - 1]
        + (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0 * envelope[low]
        - (t + 1.0) * t * (t - 2.0) / 2.0 * envelope[low + 1]
        + (t + 1.0) * t * (t - 1.0) / 6.0 * envelope[low + 2]
    )


@compiled
def explained(first: complex, second: complex, rho: float) -> float:
    """J of the envelope at two places whose pulses overlap by rho."""
    cross = first.real * second.real + first.imag * second.imag
    own = first.real**2 + first.imag**2 + second.real**2 + second.imag**2
    return (own - 2.0 * rho * cross) / (1.0 - rho * rho)


@compiled
def _single(envelope: Complexes, peak: int) -> tuple[float, complex]:
    """Position and complex amplitude of a peak that is one echo's."""
    if not 2 <= peak < len(envelope) - 3:
        return float(peak), envelope[peak]
    crest = np.abs(envelope[peak - 1 : peak + 2])
    offset, height = refined_peak(crest, len(crest) // 2)
    position = peak - 1 + offset
    here = smooth_at(envelope, position)
    return position, height * here / abs(here)


@inlined
def _coarse(envelope: Complexes, peak: int, table: Floats) -> tuple[float, float, float]:
    """Energy and places of the best pair of every other sample about a peak."""
    best, early, late = -1.0, 0.0, 0.0
    for one in range(peak - REACH, peak + REACH - CLOSEST + 1, 2):
        for other in range(one + CLOSEST, min(one + FARTHEST, peak + REACH) + 1, 2):
            energy = explained(envelope[one], envelope[other], table[(other - one) * FINE])
            if energy > best:
                best, early, late = energy, float(one), float(other)
    return best, early, late


@inlined
def _refined(
    envelope: Complexes, start: tuple[float, float, float], table: Floats
) -> tuple[float, float, float, tuple[float, float]]:
    """The same, climbed to the top by parabolas through nine neighbours: two delays trade off along a ridge.

    With them the delays' variances over the noise power: J over that is the logarithm of the likelihood, so that they
    are the diagonal of the inverse of minus its second derivatives.
    """
    best, early, late = start
    energy, side = np.empty((3, 3)), np.empty((2, 3), dtype=np.complex128)
    spread = (np.inf, np.inf)
    for _ in range(CLIMBS):
        for step in range(3):
            side[0, step] = smooth_at(envelope, early + (step - 1) * STENCIL)
            side[1, step] = smooth_at(envelope, late + (step - 1) * STENCIL)
        for one in range(3):
            for other in range(3):
                rho = pulse_at(table, late - early + (other - one) * STENCIL)
                energy[one, other] = explained(side[0, one], side[1, other], rho)
        best = energy[1, 1]
        climb, widen, spread = _to_top(energy)
        early, late = early + STENCIL * climb, max(late + STENCIL * widen, early + STENCIL * climb + CLOSEST)
        if max(abs(climb), abs(widen)) < CLOSE_ENOUGH:
            break
    return best, early, late, (spread[0] * STENCIL**2, spread[1] * STENCIL**2)


@inlined
def _to_top(energy: Floats) -> tuple[float, float, tuple[float, float]]:
    """Steps to the top of the paraboloid through (3, 3) values, and its inverse curvatures.

    Where there is no top, to the highest of the values; the curvatures' inverses are then infinite.
    """
    along = 0.5 * (energy[2, 1] - energy[0, 1])
    across = 0.5 * (energy[1, 2] - energy[1, 0])
    bend = energy[2, 1] - 2.0 * energy[1, 1] + energy[0, 1]
    bend2 = energy[1, 2] - 2.0 * energy[1, 1] + energy[1, 0]
    twist = 0.25 * (energy[2, 2] - energy[2, 0] - energy[0, 2] + energy[0, 0])
    determinant = bend * bend2 - twist * twist
    if bend < 0.0 and determinant > 0.0:
        first = (twist * across - bend2 * along) / determinant
        second = (twist * along - bend * across) / determinant
        most = max(abs(first), abs(second), MOST_STENCILS) / MOST_STENCILS
        return first / most, second / most, (-bend2 / determinant, -bend / determinant)
    highest = int(np.argmax(energy))
    return highest // 3 - 1.0, highest % 3 - 1.0, (np.inf, np.inf)
