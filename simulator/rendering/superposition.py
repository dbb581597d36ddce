"""The sum of all paths: each one's beep at its retarded times.

Time runs over the samples of the sum. A path's beep is emitted at t - travel(t); its spline is read there, rotated by
the chirp's phase there, and scaled. A few dozen samples at a time share a Taylor expansion about their middle: there
phases and times are double precision. From there on they are within a few cycles and nodes, and single precision is
enough: 1e-7 of a path's peak. Every loop runs over contiguous samples, so that it is compiled to vector instructions.
Nothing is summed in an order that a compiler may choose.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from obstaclewatch.support.compiled import fused, fused_inline
from simulator.field.motion import Motion
from simulator.rendering.beep_table import GROUP, SKIRT_S, BeepTable
from simulator.waves.band import REFERENCE_HZ

NEGLIGIBLE = 1e-7  # of a path's strongest Chebyshev term; weaker ones are left out
BLOCK_SAMPLES = 64  # samples that share an expansion, at most
VECTOR = 16
DRIFT = 0.2  # nodes by which splines may be read past a node: 1.5e-7 of a galaxy-s5's peak
TURN = 0.1  # cycles of a chirp about its tangent, which single precision has to 1e-8
CYCLE_STEPS = 4096.0  # of a cycle: multiples are exact in single precision
ZERO, ONE, TWO, HALF, SIXTH, TWO_THIRDS = (np.float32(value) for value in (0.0, 1.0, 2.0, 1 / 2, 1 / 6, 2 / 3))


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


class _Rows(NamedTuple):
    """P sounds as `_add` takes them.

    Attributes:
        start: (P,) emission, s.
        mic: (P,) microphone.
        weight: (P, K) Chebyshev coefficients of the gain.
        first, end: (P,) between which samples of the sum each may arrive.
        middle: (P,) instant about which its motion is given, s.
        delay, strength: (P, D + 1) by powers of the time from there, 1 at the end of the motion.
    """

    start: Floats
    mic: Ints
    weight: Complexes
    first: Ints
    end: Ints
    middle: Floats
    delay: Floats
    strength: Floats


def add_sounds(total: Floats, rate_hz: float, table: BeepTable, sounds: Sounds) -> None:
    """Add the envelopes about 20 kHz of sounds to a sum (2, 2, n) of real and imaginary parts, row by row."""
    motion = sounds.motion
    powers = _to_powers(motion.delay_s.shape[1])
    reach = sounds.reach_s(table.duration_s)
    first = np.maximum(np.ceil((motion.middle_s - reach) * rate_hz), 0.0).astype(np.int64)
    last = np.minimum((motion.middle_s + reach) * rate_hz, total.shape[2] - 1).astype(np.int64)
    strength = motion.strength * sounds.center_delay_s[:, None]
    scale = 1.0 / motion.half_width_s
    rows = _Rows(
        sounds.start_s, sounds.mic, sounds.weight, first, last + 1, motion.middle_s, motion.delay_s @ powers,
        strength @ powers,
    )  # fmt: skip
    _add(total, rate_hz, table, rows, scale)  # type: ignore[call-arg]


def _to_powers(terms: int) -> Floats:
    """(D + 1, D + 1) from Chebyshev coefficients, a row, to those of the powers."""
    rows = [chebyshev.cheb2poly(row) for row in np.eye(terms)]
    return np.array([np.pad(row, (0, terms - len(row))) for row in rows])


@fused
def _add(total, rate, table, rows, scale):
    """Every row in turn, block by block; `scale` times seconds from the middle of a motion is 1 at its end."""
    splines, lead, steps, duration, start_hz, slope_hz_s = table
    start, mic, weight, first, end, middle, delay, strength = rows
    half_slope = 0.5 * slope_hz_s
    margin, longest = BLOCK_SAMPLES * steps, 0
    for p in range(len(start)):
        longest = max(longest, end[p] - first[p])
    values, node = np.empty((2, longest), np.float32), np.empty(longest, np.int64)
    part = np.empty((longest, 14), np.float32)
    beep = np.zeros((2, splines.shape[3] + 2 * margin), np.float32)
    filtered = beep[:, margin : margin + splines.shape[3]]
    ramp, grouped = np.empty(2 * BLOCK_SAMPLES, np.float32), np.zeros((len(splines), 2, GROUP), np.float32)
    for i in range(2 * BLOCK_SAMPLES):
        ramp[i] = np.float32(i - BLOCK_SAMPLES)
    for p in range(len(start)):
        for g in range(_group(weight[p], grouped)):
            _weigh(filtered[0], filtered[1], grouped[g, 0], grouped[g, 1], splines[g, 0], splines[g, 1], g == 0)
        begin, past = _arrival(delay[p], middle[p], scale, first[p], end[p], start[p], rate, duration)
        size = _block(delay[p], steps * scale, half_slope / rate**2)
        blocks = (past - begin + size - 1) // size
        for b in range(blocks):  # in a loop of its own, where one expansion need not wait for another
            half = min(size, past - begin - b * size) // 2
            time = (begin + b * size + half) / rate
            x = (time - middle[p]) * scale
            travel, way = _taylor(delay[p], x, scale / rate), _taylor(strength[p], x, scale / rate)
            emitted = time - start[p] - travel[0]
            here = -SKIRT_S <= emitted <= duration + SKIRT_S  # else it runs off on its way
            before = _place(emitted, travel, rate * steps, lead + margin, part[b, :4])
            node[b] = before - 1 - steps * half if here else -1
            _phase(emitted, travel, time, rate, start_hz, half_slope, part[b, 4:10])
            _level(way, travel, part[b, 10:])
        for b in range(blocks):
            i, k = b * size, min((b + 1) * size, past - begin)
            if node[b] >= 0:
                nearby = ramp[BLOCK_SAMPLES - (k - i) // 2 :]
                _read(values[0, i:k], values[1, i:k], beep, node[b], steps, nearby, part[b])
            else:
                values[:, i:k] = ZERO
        for c in range(2):
            _add_to(total[mic[p], c, begin:past], values[c])


@fused_inline
def _add_to(total, values):
    """Sums are double precision: single echoes are 60 dB under the direct sound."""
    for i in range(len(total)):
        total[i] += values[i]


@fused
def _group(weight, grouped):
    """Fill in real and imaginary parts of the weights that count, `GROUP` by `GROUP`, and say how many groups do."""
    most, last = 0.0, 0
    for k in range(len(weight)):
        most = max(most, weight[k].real ** 2 + weight[k].imag ** 2)
    for k in range(len(weight)):
        kept = weight[k].real ** 2 + weight[k].imag ** 2 > NEGLIGIBLE * NEGLIGIBLE * most
        grouped[k // GROUP, 0, k % GROUP] = np.float32(weight[k].real if kept else 0.0)
        grouped[k // GROUP, 1, k % GROUP] = np.float32(weight[k].imag if kept else 0.0)
        last = k if kept else last
    return last // GROUP + 1


@fused
def _weigh(x, y, real, imag, a, b, alone):
    """Add five rows a + j b times five complex weights to x + j y, or put them there: what is read takes the time."""
    r0, r1, r2, r3, r4 = real[0], real[1], real[2], real[3], real[4]
    i0, i1, i2, i3, i4 = imag[0], imag[1], imag[2], imag[3], imag[4]
    a0, a1, a2, a3, a4 = a[0], a[1], a[2], a[3], a[4]
    b0, b1, b2, b3, b4 = b[0], b[1], b[2], b[3], b[4]
    kept = ZERO if alone else ONE
    for i in range(len(x)):
        x[i] = kept * x[i] + (
            r0 * a0[i] - i0 * b0[i] + (r1 * a1[i] - i1 * b1[i]) + (r2 * a2[i] - i2 * b2[i])
            + (r3 * a3[i] - i3 * b3[i]) + (r4 * a4[i] - i4 * b4[i])
        )  # fmt: skip
        y[i] = kept * y[i] + (
            r0 * b0[i] + i0 * a0[i] + (r1 * b1[i] + i1 * a1[i]) + (r2 * b2[i] + i2 * a2[i])
            + (r3 * b3[i] + i3 * a3[i]) + (r4 * b4[i] + i4 * a4[i])
        )  # fmt: skip


@fused_inline
def _arrival(delay, middle, scale, first, end, start, rate, duration):
    """First sample at which the beep or its skirt arrives, and the first past it."""
    begin, past = first, end
    while begin < past and _emission(delay, middle, scale, begin / rate) - start < -SKIRT_S:
        begin += 1
    while begin < past and _emission(delay, middle, scale, (past - 1) / rate) - start > duration + SKIRT_S:
        past -= 1
    return begin, past


@fused
def _emission(delay, middle, scale, time):
    """When what arrives at an instant was emitted."""
    x, travel = (time - middle) * scale, 0.0
    for k in range(len(delay) - 1, -1, -1):
        travel = travel * x + delay[k]
    return time - travel


@fused_inline
def _block(delay, scale, bend):
    """How many samples are expanded about their middle: multiples of a vector's, but where that is too many.

    On their way to either end, splines drift from node to node by `DRIFT` at most, and the chirp turns by `TURN`.
    """
    drift = 1e-9
    for k in range(1, len(delay)):
        drift += abs(k * delay[k] * scale)
    size = int(min(2.0 * DRIFT / drift, 2.0 * np.sqrt(TURN / abs(bend)), BLOCK_SAMPLES))
    return max(size - size % VECTOR if size > VECTOR else size, 1)


@fused
def _taylor(power, x, step):
    """A polynomial about x: coefficients of the powers of steps, as far as the third."""
    a = b = c = d = 0.0
    for k in range(len(power) - 1, -1, -1):
        d = d * x + c
        c = c * x + b
        b = b * x + a
        a = a * x + power[k]
    return a, b * step, c * step * step, d * step * step * step


@fused_inline
def _place(emitted, travel, nodes, lead, way):
    """The node before the middle of a block; fill in how far past it its samples are read, each a node further on."""
    place = emitted * nodes + lead
    node = int(np.floor(place))
    way[0] = place - node
    way[1], way[2], way[3] = -travel[1] * nodes, -travel[2] * nodes, -travel[3] * nodes
    return node


@fused_inline
def _phase(emitted, travel, time, rate, start_hz, half_slope, turn):
    """Fill in the phase over the samples of a block, cycles: whole `CYCLE_STEPS` of a cycle, and what is left."""
    frequency, pace = start_hz + 2.0 * half_slope * emitted, 1.0 / rate - travel[1]
    cycles = (start_hz + half_slope * emitted) * emitted - REFERENCE_HZ * time
    slope = frequency * pace - REFERENCE_HZ / rate
    cycles, slope = cycles - np.rint(cycles), slope - np.rint(slope)
    parts, rise = np.rint(cycles * CYCLE_STEPS) / CYCLE_STEPS, np.rint(slope * CYCLE_STEPS) / CYCLE_STEPS
    turn[0], turn[1], turn[2], turn[3] = parts, rise, cycles - parts, slope - rise
    turn[4] = half_slope * pace * pace - frequency * travel[2]
    turn[5] = -frequency * travel[3] - 2.0 * half_slope * pace * travel[2]


@fused_inline
def _level(way, travel, level):
    """Fill in strength over travel time, over the samples of a block."""
    inverse = 1.0 / travel[0]
    a = way[0] * inverse
    b = (way[1] - a * travel[1]) * inverse
    c = (way[2] - a * travel[2] - b * travel[1]) * inverse
    d = (way[3] - a * travel[3] - b * travel[2] - c * travel[1]) * inverse
    level[0], level[1], level[2], level[3] = a, b, c, d


SINE = np.array([(-1) ** k * np.pi ** (2 * k + 1) / factorial(2 * k + 1) for k in range(6)], np.float32)
COSINE = np.array([(-1) ** k * np.pi ** (2 * k) / factorial(2 * k) for k in range(7)], np.float32)
"""Taylor series of the sine and cosine of half an angle in cycles: below 6e-8 from -1/2 to 1/2."""


@fused_inline
def _read(x, y, beep, first, steps, ramp, part):
    """Fill in the samples of one block; the loop over neighbouring nodes is compiled to vector instructions.

    Args:
        part: (14,) what `_place`, `_phase` and `_level` filled in.
    """
    real, imag = beep[0, first:], beep[1, first:]
    place, turn = (part[0], part[1], part[2], part[3]), (part[4], part[5], part[6], part[7], part[8], part[9])
    level = part[10], part[11], part[12], part[13]
    if steps == 1:
        for i in range(len(x)):
            a, b, c, d = _weights(ramp[i], place)
            p = a * real[i] + b * real[i + 1] + c * real[i + 2] + d * real[i + 3]
            q = a * imag[i] + b * imag[i + 1] + c * imag[i + 2] + d * imag[i + 3]
            cosine, sine = _rotation(ramp[i], turn, level)
            x[i], y[i] = p * cosine - q * sine, p * sine + q * cosine
    else:
        for i in range(len(x)):
            a, b, c, d = _weights(ramp[i], place)
            r, s = real[steps * i :], imag[steps * i :]
            p, q = a * r[0] + b * r[1] + c * r[2] + d * r[3], a * s[0] + b * s[1] + c * s[2] + d * s[3]
            cosine, sine = _rotation(ramp[i], turn, level)
            x[i], y[i] = p * cosine - q * sine, p * sine + q * cosine


@fused
def _weights(j, place):
    """Cubic B-splines about u between b and c: (1 - u)^3 / 6, 2/3 - u^2 + u^3 / 2, and their mirror images."""
    u = place[0] + j * (place[1] + j * (place[2] + j * place[3]))
    v = ONE - u
    a, b, d = SIXTH * (v * v * v), TWO_THIRDS - u * u * (ONE - HALF * u), SIXTH * (u * u * u)
    return a, b, ONE - a - b - d, d


@fused
def _rotation(j, turn, level):
    """Cosine and sine of the phase times the level; they are those of half the phase, twice."""
    cycles = turn[0] + j * turn[1]
    cycles = cycles - np.rint(cycles) + (turn[2] + j * (turn[3] + j * (turn[4] + j * turn[5])))
    cycles -= np.rint(cycles)
    z = cycles * cycles
    s = SINE[0] + z * (SINE[1] + z * (SINE[2] + z * (SINE[3] + z * (SINE[4] + z * SINE[5]))))
    t = COSINE[3] + z * (COSINE[4] + z * (COSINE[5] + z * COSINE[6]))
    t = COSINE[0] + z * (COSINE[1] + z * (COSINE[2] + z * t))
    s *= cycles
    size = level[0] + j * (level[1] + j * (level[2] + j * level[3]))
    return size * (t * t - s * s), size * (TWO * s * t)
