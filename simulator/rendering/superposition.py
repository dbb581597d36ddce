"""The sum of all paths: each one's beep at its retarded times.

Time runs over the samples of the sum. A path's beep is emitted at t - travel(t); its spline is read there, rotated by
the chirp's phase there, and scaled. Phases and times are double precision; once they are within one cycle and one node,
single precision is enough: 1e-7 of a path's peak. Every loop runs over contiguous samples, so that it is compiled to
vector instructions. Nothing is summed in an order that a compiler may choose.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.polynomial import chebyshev

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from simulator.field.motion import Motion
from simulator.rendering.beep_table import SKIRT_S, BeepTable
from simulator.waves.band import REFERENCE_HZ

NEGLIGIBLE = 1e-7  # of a path's strongest Chebyshev term; weaker ones are left out
BLOCK = 64  # samples that fill whole vectors
COMPARED = 16
ONE, HALF, SIXTH, TWO_THIRDS = (np.float32(value) for value in (1.0, 1 / 2, 1 / 6, 2 / 3))


@dataclass(frozen=True)
class Sounds:
    """P beeps under way: when each leaves, the microphone it reaches, its gain over frequency, and its motion.

    Attributes:
        start_s: (P,) emission of the beep's first sample.
        mic: (P,) microphone.
        weight: (P, K) Chebyshev coefficients of the gain.
        motion: delay and strength as they change within the beep.
        center_delay_s: (P,) travel time of the beep's middle, to which the gain belongs.
    """

    start_s: Floats
    mic: Ints
    weight: Complexes
    motion: Motion
    center_delay_s: Floats

    def reach_s(self, duration_s: float) -> Floats:
        """(P,) how far from the motion's middle a beep may arrive."""
        delay = self.motion.delay_s
        late = np.abs(chebyshev.chebval(0.0, delay.T) - self.center_delay_s)
        receding = delay[:, 1] / self.motion.half_width_s if delay.shape[1] > 1 else 0.0  # over c; stretches the beep
        return (0.5 * duration_s + late) * np.maximum(1.02, 1.001 / (1.0 - receding)) + SKIRT_S

    def end_s(self, duration_s: float) -> float:
        """When all have arrived."""
        return float((self.motion.middle_s + self.reach_s(duration_s)).max(initial=0.0))


def add_sounds(total: Complexes, rate_hz: float, table: BeepTable, sounds: Sounds) -> None:
    """Add the envelopes about 20 kHz of sounds to a sum (2, n), row by row."""
    motion = sounds.motion
    powers = _to_powers(motion.delay_s.shape[1])
    reach = sounds.reach_s(table.duration_s)
    first = np.maximum(np.ceil((motion.middle_s - reach) * rate_hz), 0.0).astype(np.int64)
    last = np.minimum((motion.middle_s + reach) * rate_hz, total.shape[1] - 1).astype(np.int64)
    strength = motion.strength * sounds.center_delay_s[:, None]
    size = np.abs(sounds.weight)
    weight = np.where(size > NEGLIGIBLE * size.max(axis=1, keepdims=True), sounds.weight, 0.0)
    _add(
        total, rate_hz, table.splines, table.lead, table.steps, table.duration_s, table.start_hz,
        0.5 * table.slope_hz_s, sounds.start_s, sounds.mic, weight, first, last + 1, motion.middle_s,
        1.0 / motion.half_width_s, motion.delay_s @ powers, strength @ powers,
    )  # fmt: skip


def _to_powers(terms: int) -> Floats:
    """(D + 1, D + 1) from Chebyshev coefficients, a row, to those of the powers."""
    rows = [chebyshev.cheb2poly(row) for row in np.eye(terms)]
    return np.array([np.pad(row, (0, terms - len(row))) for row in rows])


@compiled
def _add(
    total, rate, splines, lead, steps, duration, start_hz, half_slope, start, mic, weight, first, end, middle, scale,
    delay, strength,
):  # fmt: skip
    """Every row in turn, in buffers as long as the longest."""
    longest = 0
    for p in range(len(start)):
        longest = max(longest, end[p] - first[p])
    x, travel, level = np.empty(longest), np.empty(longest), np.empty(longest)
    shift, part = np.empty(longest, np.int32), np.zeros((5, longest + BLOCK), np.float32)
    beep = np.zeros((2, splines.shape[2] + steps * BLOCK), np.float32)
    for p in range(len(start)):
        count = end[p] - first[p]
        for i in range(count):
            x[i] = ((first[p] + i) / rate - middle[p]) * scale
        _polynomial(delay[p], x[:count], travel)
        _polynomial(strength[p], x[:count], level)
        begin, past = _arrival(travel, first[p], end[p], start[p], rate, duration)
        kept = slice(begin - first[p], past - first[p])
        _places(
            travel[kept], level[kept], begin, rate, start[p], duration, start_hz, half_slope, lead, steps, shift, part
        )
        _filter(splines, weight[p], beep)
        _read(beep, steps, shift[: past - begin], part)
        _rotate(total[mic[p], begin:past], part)


@compiled
def _polynomial(power, x, value):
    """Horner's scheme, one power after another over all samples."""
    for i in range(len(x)):
        value[i] = power[-1]
    for k in range(len(power) - 2, -1, -1):
        constant = power[k]
        for i in range(len(x)):
            value[i] = value[i] * x[i] + constant


@inlined
def _arrival(travel, first, end, start, rate, duration):
    """First sample at which the beep or its skirt arrives, and the first past it."""
    begin, past = first, end
    while begin < past and begin / rate - travel[begin - first] - start < -SKIRT_S:
        begin += 1
    while begin < past and (past - 1) / rate - travel[past - 1 - first] - start > duration + SKIRT_S:
        past -= 1
    return begin, past


@inlined
def _places(travel, level, begin, rate, start, duration, start_hz, half_slope, lead, steps, shift, part):
    """Node less the sample's number, way to the next node, phase in cycles, and level of every sample.

    What was emitted outside the beep and its skirts is taken at their ends: the table has no more.
    """
    for i in range(len(travel)):
        time = (begin + i) / rate
        emitted = min(max(time - travel[i] - start, -SKIRT_S), duration + SKIRT_S)
        place = emitted * (steps * rate) + lead
        cycles = (start_hz + half_slope * emitted) * emitted - REFERENCE_HZ * time
        node = np.floor(place)
        shift[i] = np.int32(node) - steps * i
        part[0, i] = np.float32(place - node)
        part[3, i] = np.float32(cycles - np.rint(cycles))
        part[4, i] = np.float32(level[i] / travel[i])


@inlined
def _filter(splines, weight, beep):
    """One beep through one gain."""
    for i in range(beep.shape[1]):
        beep[0, i] = beep[1, i] = np.float32(0.0)
    for k in range(len(weight)):
        if weight[k] != 0.0:
            a, b = np.float32(weight[k].real), np.float32(weight[k].imag)
            for i in range(splines.shape[2]):
                beep[0, i] += a * splines[k, 0, i] - b * splines[k, 1, i]
                beep[1, i] += a * splines[k, 1, i] + b * splines[k, 0, i]


@inlined
def _read(beep, steps, shift, part):
    """Spline values in rows 1 and 2 from places in row 0, over runs of samples that meet one node after another.

    What a run writes past its end, to fill its last vector, the next one mends.
    """
    begin = 0
    while begin < len(shift):
        end = _run_end(shift, begin)
        first, filled = shift[begin] + steps * begin - 1, begin + BLOCK * ((end - begin - 1) // BLOCK + 1)
        for k in (0, 1):
            _spline(beep[k, first:], steps, part[0, begin:filled], part[1 + k, begin:filled])
        begin = end


@inlined
def _run_end(shift, begin):
    """Where a run of equal numbers ends, some of them compared at once."""
    end = begin + 1
    while end + COMPARED <= len(shift):
        others = 0
        for i in range(end, end + COMPARED):
            others += shift[i] != shift[begin]
        if others > 0:
            break
        end += COMPARED
    while end < len(shift) and shift[end] == shift[begin]:
        end += 1
    return end


@inlined
def _spline(coefficient, steps, place, value):
    """(n,) values of a cubic spline; a loop over neighbouring coefficients is compiled to vector instructions."""
    if steps == 1:
        for i in range(len(place)):
            value[i] = _cubic(place[i], coefficient[i], coefficient[i + 1], coefficient[i + 2], coefficient[i + 3])
        return
    for i in range(len(place)):
        near = coefficient[steps * i : steps * i + 4]
        value[i] = _cubic(place[i], near[0], near[1], near[2], near[3])


@compiled
def _cubic(u, a, b, c, d):
    """Cubic B-splines about u between b and c: (1 - u)^3 / 6, 2/3 - u^2 + u^3 / 2, and their mirror images."""
    v = ONE - u
    return (
        SIXTH * (v * v * v * a + u * u * u * d)
        + (TWO_THIRDS - u * u * (ONE - HALF * u)) * b
        + (TWO_THIRDS - v * v * (ONE - HALF * v)) * c
    )


_SINE = np.array([(-1) ** k * np.pi ** (2 * k + 1) / factorial(2 * k + 1) for k in range(7)], np.float32)
_COSINE = np.array([(-1) ** k * np.pi ** (2 * k) / factorial(2 * k) for k in range(8)], np.float32)
"""Taylor series of the sine and cosine of half an angle in cycles: below 1e-9 from -1/2 to 1/2."""


@inlined
def _rotate(total, part):
    """Add values, rotated by their phases and scaled; the rotation is that by half the phase, twice."""
    for i in range(len(total)):
        x = part[3, i]
        y = x * x
        s, c = _SINE[6], _COSINE[7]
        for k in range(5, -1, -1):
            s = s * y + _SINE[k]
        for k in range(6, -1, -1):
            c = c * y + _COSINE[k]
        s *= x
        real, imag = part[4, i] * (c * c - s * s), part[4, i] * (np.float32(2.0) * c * s)
        total[i] += complex(part[1, i] * real - part[2, i] * imag, part[1, i] * imag + part[2, i] * real)
