"""Waves of one facet, compiled: means of e^{j phase} over a triangle on which the phase runs linearly.

Float32 without a branch, so that the compiler works on eight facets at a time. What a rounded surface has beyond a flat
one is kept to first order in how far it stands off: without it facets of 8 cm moved the echo of a sphere of 15 cm by
1.0 dB, with it by 0.26. Both follow from the sines and cosines of half the lowest and half the highest phase.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.compiled import inlined

SINGLE = np.float32
ONE, TWO, HALF, THIRD, NONE = SINGLE(1), SINGLE(2), SINGLE(0.5), SINGLE(1 / 3), SINGLE(0)
_THREE, _FOUR = SINGLE(3), SINGLE(4)
_PER_PI, _PI_HIGH, _PI_LOW = SINGLE(0.3183098861837907), SINGLE(3.140625), SINGLE(9.67653589793e-4)
_C0, _C1, _C2 = SINGLE(-0.5), SINGLE(4.166665935e-2), SINGLE(-1.388865130e-3)
_C3, _C4 = SINGLE(2.477455312e-5), SINGLE(-2.629690133e-7)
_S0, _S1, _S2, _S3 = SINGLE(-1.666666596e-1), SINGLE(8.333242e-3), SINGLE(-1.982272122e-4), SINGLE(2.634697212e-6)
_FLAT = SINGLE(0.1)  # rad of phase across a facet: what is less takes the series
_NEAR, _NEARER, _STEEP = SINGLE(1e-3), SINGLE(1e-6), SINGLE(1e8)
_M2, _M3, _M4 = SINGLE(-1 / 12), SINGLE(1 / 60), SINGLE(1 / 360)
_A0, _A1, _A2, _A3, _A4, _A5 = (SINGLE(1 / each) for each in (3, 4, 10, 36, 168, 960))
_B0, _B1, _B2, _B3, _B4, _B5 = (SINGLE(1 / each) for each in (4, 5, 12, 42, 192, 1080))


@inlined
def facet_wave(x, y, u, v, w):
    """Means over a triangle on which the phase is linear, x and y at two corners, 0 in the middle.

    Of e^{j phase}; of its growth, the derivative where all phases grow alike, as they do with frequency; and of
    q e^{j phase} for a quadratic q: 0 at the corners and u, v, w in the middle of the edge across from each.
    """
    low, mid, u, v = _in_order(x, y, u, v)
    mid, high, v, w = _in_order(mid, -(x + y), v, w)
    low, mid, u, v = _in_order(low, mid, u, v)
    halves = _halves(low, high)
    real, imag, more_real, more_imag = _mean_wave(low, mid, high, halves)
    bent_real, bent_imag = _bent_wave(low, mid, high, u, v, w, halves)
    return real, imag, more_real, more_imag, bent_real, bent_imag


@inlined
def _halves(low, high):
    """Sines and cosines of half the lowest and half the highest phase, and of half of what each is off the middle one.

    All phases add up to 0: half of the highest less the middle one is the highest and half of the lowest.
    """
    sin_low, cos_low = turn(HALF * low)
    sin_high, cos_high = turn(HALF * high)
    sin_twice_low, cos_twice_low = _doubled(sin_low, cos_low)
    sin_twice_high, cos_twice_high = _doubled(sin_high, cos_high)
    sin_up = sin_twice_high * cos_low + cos_twice_high * sin_low
    cos_up = cos_twice_high * cos_low - sin_twice_high * sin_low
    sin_down = -(sin_twice_low * cos_high + cos_twice_low * sin_high)
    cos_down = cos_twice_low * cos_high - sin_twice_low * sin_high
    return sin_low, cos_low, sin_high, cos_high, sin_up, cos_up, sin_down, cos_down


@inlined
def _doubled(sine, cosine):
    """Sine and cosine of twice an angle."""
    return TWO * sine * cosine, ONE - TWO * sine * sine


@inlined
def _mean_wave(low, mid, high, halves):
    """Mean of e^{j phase}, a divided difference of the exponential, and its growth."""
    sin_low, cos_low, sin_high, cos_high, sin_up, cos_up, sin_down, cos_down = halves
    up, down, span = HALF * (high - mid), HALF * (mid - low), high - low
    safe_up, safe_down = max(up, _NEAR), max(down, _NEAR)
    sinc_up, sinc_down = (sin_up + (safe_up - up)) / safe_up, (sin_down + (safe_down - down)) / safe_down
    rise_up, rise_down = cos_up - sinc_up, cos_down - sinc_down
    per = TWO / max(span, _FLAT)
    real, imag = per * (sin_high * sinc_down - sin_low * sinc_up), per * (cos_high * sinc_down - cos_low * sinc_up)
    low_real = HALF * (high * cos_high * sinc_down - low * cos_low * sinc_up)
    low_imag = HALF * (low * sin_low * sinc_up - high * sin_high * sinc_down)
    more_real = low_real + sin_high * rise_down - sin_low * rise_up
    more_imag = low_imag + cos_high * rise_down - cos_low * rise_up
    square, cube = HALF * (low * low + mid * mid + high * high), low * mid * high
    wide = either(span - _FLAT)
    flat_real, flat_imag = ONE + square * (_M2 + square * _M4), -cube * _M3
    growth_real, growth_imag = square * (TWO * _M2 + square * _FOUR * _M4), -_THREE * cube * _M3
    return (
        flat_real + wide * (real - flat_real),
        flat_imag + wide * (imag - flat_imag),
        growth_real + wide * (per * more_real - real - growth_real),
        growth_imag + wide * (per * more_imag - imag - growth_imag),
    )


@inlined
def _bent_wave(low, mid, high, u, v, w, halves):
    """Mean of q e^{j phase}, q in the middle of the edges across from the lowest, middle and highest corner.

    Over lines of equal phase its mean is quadratic on either side of the middle corner, and these lines are as long as
    they are far from the outer one.
    """
    sin_low, cos_low, sin_high, cos_high, sin_up, cos_up, sin_down, cos_down = halves
    sin_low, cos_low = _doubled(sin_low, cos_low)
    sin_high, cos_high = _doubled(sin_high, cos_high)
    sin_up, cos_up = _doubled(sin_up, cos_up)
    sin_down, cos_down = _doubled(sin_down, cos_down)
    down, up = mid - low, high - mid
    share = down / max(high - low, _NEARER)
    a, b, c, d = _moments(down, sin_down, cos_down)
    linear, square = _along(u, v, w, share)
    real, imag = linear * a + square * c, linear * b + square * d
    low_real, low_imag = cos_low * real - sin_low * imag, cos_low * imag + sin_low * real
    a, b, c, d = _moments(up, sin_up, cos_up)
    linear, square = _along(w, v, u, ONE - share)
    real, imag = linear * a + square * c, -(linear * b + square * d)
    return low_real + cos_high * real - sin_high * imag, low_imag + cos_high * imag + sin_high * real


@inlined
def _along(far, beside, near, share):
    """Factors of s^2 and s^3 in twice the mean of q over lines of equal phase, times their share of the triangle.

    s runs from 0 at an outer corner to 1 at the middle one; `near` is q on the edge between them, `beside` on the one
    between the outer corners, `far` on the third.
    """
    linear = share * _FOUR * (near + beside * share)
    falling = near + near + share * (near + beside - far + TWO * beside * share)
    return linear, -share * _FOUR * THIRD * falling


@inlined
def _moments(x, sine, cosine):
    """Integrals of s^2 e^{jxs} and s^3 e^{jxs} over s from 0 to 1, x at least 0: by parts, below 1 by their series."""
    per, wide, small = ONE / max(x, ONE), either(x - ONE), min(x, ONE)
    real, imag = (sine - (ONE - cosine) * per) * per, (sine * per - cosine) * per  # of s e^{jxs}
    a, b = (sine - TWO * imag) * per, (TWO * real - cosine) * per
    c, d = (sine - _THREE * b) * per, (_THREE * a - cosine) * per
    low_a, low_b = _series(small, _A0, _A1, _A2, _A3, _A4, _A5)
    low_c, low_d = _series(small, _B0, _B1, _B2, _B3, _B4, _B5)
    return (
        low_a + wide * (a - low_a),
        low_b + wide * (b - low_b),
        low_c + wide * (c - low_c),
        low_d + wide * (d - low_d),
    )


@inlined
def _series(x, a, b, c, d, e, f):
    """a + jbx - cx^2 - jdx^3 + ex^4 + jfx^5, real and imaginary part."""
    square = x * x
    return a - square * (c - square * e), x * (b - square * (d - square * f))


@inlined
def _in_order(x, y, u, v):
    """Two phases with what belongs to them, the lower one first."""
    swap = either(x - y)
    return min(x, y), max(x, y), u + swap * (v - u), v + swap * (u - v)


@inlined
def turn(phase):
    """Sine and cosine: half turns taken off, then polynomials, fitted at Chebyshev's nodes to 1e-7."""
    turns = np.floor(phase * _PER_PI + HALF)
    rest = (phase - turns * _PI_HIGH) - turns * _PI_LOW
    sign = ONE - TWO * (turns - TWO * np.floor(turns * HALF))
    square = rest * rest
    cosine = sign * (ONE + square * (_C0 + square * (_C1 + square * (_C2 + square * (_C3 + square * _C4)))))
    sine = sign * rest * (ONE + square * (_S0 + square * (_S1 + square * (_S2 + square * _S3))))
    return sine, cosine


@inlined
def either(value):
    """1 above 0, 0 below: arithmetic, where a branch would stop the compiler."""
    return min(max(value * _STEEP, NONE), ONE)
