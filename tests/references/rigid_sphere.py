"""Exact echo of a rigid sphere: the separated series, summed with quantities that can neither overflow nor cancel.

Bowman, Senior, Uslenghi, Electromagnetic and Acoustic Scattering by Simple Shapes (1969), section 10.3. The series
is written with e^{-iwt}, as there; what leaves this file is conjugated to the project's e^{+jwt}.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def scattered(
    radius_m: float, source_m: ArrayLike, receiver_m: ArrayLike, frequency_hz: ArrayLike, speed_m_s: float
) -> Complexes:
    """(..., F) pressure scattered by a rigid sphere about the origin, incident e^{-jkR}/R, e^{+jwt}.

    p_s = -ik sum (2n + 1) [j_n'(ka) / h_n'(ka)] h_n(k r_s) h_n(k r_r) P_n(cos), conjugated.

    Args:
        radius_m: radius of the sphere.
        source_m, receiver_m: (..., 3).
        frequency_hz: (F,).
        speed_m_s: of sound.

    Raises:
        ValueError: a point so close to the surface that the series needs orders beyond k r, where h_n grows.
    """
    source, receiver = np.broadcast_arrays(np.asarray(source_m, float), np.asarray(receiver_m, float))
    k = 2.0 * np.pi * np.asarray(frequency_hz, float) / speed_m_s
    r_s, r_r = np.linalg.norm(source, axis=-1), np.linalg.norm(receiver, axis=-1)
    cosine = np.sum(source * receiver, axis=-1) / (r_s * r_r)
    needed, nearest = series_orders(k * radius_m), min(r_s.min(), r_r.min())
    if (needed > k * nearest).any():
        raise ValueError(f"points must be farther than {(needed / k).max():.3f} m from the centre, got {nearest}")
    orders = int(needed.max())
    reflection = reflection_coefficients(k * radius_m, orders)
    reflection[np.arange(orders)[:, None] >= needed] = 0.0
    h_s, h_r = hankel(k * r_s[..., None], orders), hankel(k * r_r[..., None], orders)
    weight = 2.0 * np.arange(orders) + 1.0
    total = np.einsum("n,nf,n...f,n...f,n...->...f", weight, reflection, h_s, h_r, legendre(cosine, orders))
    return np.conj(-1j * k * total)


def series_orders(argument: Floats) -> NDArray[np.int64]:
    """(F,) orders after which j_n'/h_n' is below 1e-16: they fall as exp(-(4 sqrt 2 / 3) ((n - x) / x^{1/3})^{3/2})."""
    return np.ceil(argument + 8.0 * argument ** (1.0 / 3.0) + 12.0).astype(np.int64)


def hankel_ratios(x: Floats, orders: int) -> Complexes:
    """(orders, ...) h_n(x) / h_{n-1}(x), from h_0 / h_{-1} = -i upwards, the direction in which h_n is stable."""
    ratio = np.empty((orders, *np.shape(x)), dtype=np.complex128)
    ratio[0] = -1j
    for n in range(1, orders):
        ratio[n] = (2.0 * n - 1.0) / x - 1.0 / ratio[n - 1]
    return ratio


def hankel(x: Floats, orders: int) -> Complexes:
    """(orders, ...) h_n(x); bounded while n < x."""
    ratio = hankel_ratios(x, orders)
    ratio[0] = -1j * np.exp(1j * x) / x
    return np.cumprod(ratio, axis=0)


def reflection_coefficients(x: Floats, orders: int) -> Complexes:
    """(orders, ...) j_n'(x) / h_n'(x) = (1 + conj(h_n') / h_n') / 2, from the phase of h_n' alone."""
    ratio = hankel_ratios(x, orders)
    phase = ratio / np.abs(ratio)
    phase[0] = -1j * np.exp(1j * x)
    n = np.arange(orders).reshape((-1,) + (1,) * np.ndim(x))
    derivative = np.cumprod(phase, axis=0) * (1.0 / ratio - (n + 1.0) / x)  # h_n' = h_{n-1} - (n + 1) h_n / x
    return 0.5 * (1.0 + np.conj(derivative) / derivative)


def legendre(cosine: Floats, orders: int) -> Floats:
    """(orders, ...) Legendre polynomials."""
    value = np.empty((orders, *np.shape(cosine)))
    value[0] = 1.0
    value[1] = cosine
    for n in range(2, orders):
        value[n] = ((2.0 * n - 1.0) * cosine * value[n - 1] - (n - 1.0) * value[n - 2]) / n
    return value
