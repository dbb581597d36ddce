"""Exact echo of an endless rigid cylinder from a point source: its integral over axial wavenumbers.

    p_s = -(i/2) int dkz e^{i kz z} sum e_n [J_n'(Ka) / H_n'(Ka)] H_n(K r_s) H_n(K r_r) cos(n phi),  K^2 = k^2 - kz^2

with e^{-iwt}, as in Bowman, Senior, Uslenghi (1969), section 2.4; what leaves this file is conjugated to e^{+jwt}.
With kz = k sin w the path of integration runs down the steepest slope from w = 0 to one side and from the saddle w_0
to the other, and along the real axis between the two: Im K >= 0 everywhere, so that no zero of H_n'(Ka), a creeping
wave, is crossed. Straight through the saddle at 45 degrees it would be, as soon as the two points differ in z.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import hankel1e, jve

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

DECAY = 40.0  # the integrand is followed down to e^-40


def scattered(
    radius_m: float, source_m: ArrayLike, receiver_m: ArrayLike, frequency_hz: ArrayLike, speed_m_s: float
) -> Complexes:
    """(F,) pressure scattered by a rigid cylinder about the z axis, incident e^{-jkR}/R, e^{+jwt}.

    Args:
        radius_m: radius of the cylinder.
        source_m, receiver_m: (3,), outside it.
        frequency_hz: (F,).
        speed_m_s: of sound.
    """
    source, receiver = np.asarray(source_m, float), np.asarray(receiver_m, float)
    k = 2.0 * np.pi * np.atleast_1d(np.asarray(frequency_hz, float)) / speed_m_s
    return np.conj([_integral(each, radius_m, source, receiver) for each in k])


def _integral(k: float, radius_m: float, source: Floats, receiver: Floats) -> complex:
    r_s, r_r = np.hypot(*source[:2]), np.hypot(*receiver[:2])
    angle = np.arctan2(source[1], source[0]) - np.arctan2(receiver[1], receiver[0])
    height = abs(source[2] - receiver[2])
    across = max(r_s + r_r - 2.0 * radius_m, 1e-3)
    w, dw = contour(np.arctan2(height, across), k * np.hypot(across, height))
    wave = k * np.cos(w)
    n = np.arange(int(np.ceil(k * radius_m + 8.0 * (k * radius_m) ** (1 / 3) + 12.0)))[:, None]
    scale = np.exp(
        np.imag(wave * radius_m) - 1j * wave * radius_m + 1j * wave * (r_s + r_r) + 1j * k * np.sin(w) * height
    )
    inside = _derivative(jve, n, wave * radius_m) / _derivative(hankel1e, n, wave * radius_m)
    terms = np.where(n == 0, 1.0, 2.0) * np.cos(n * angle) * inside * hankel1e(n, wave * r_s) * hankel1e(n, wave * r_r)
    return -0.5j * np.sum(terms.sum(axis=0) * scale * k * np.cos(w) * dw)


def contour(saddle_rad: float, phase: float, nodes: int = 40) -> tuple[Complexes, Complexes]:
    """Nodes w and weights dw: down the slope to w = 0, along the axis to the saddle, down the slope beyond it."""
    x, weight = np.polynomial.legendre.leggauss(nodes)
    step = np.exp(-0.25j * np.pi) * np.sqrt(2.0 * DECAY / phase)
    s, ds = 0.5 * (x + 1.0) * step, 0.5 * weight * step
    middle = 0.5 * (x + 1.0) * saddle_rad
    return np.concatenate([-s, middle, saddle_rad + s]), np.concatenate([ds, 0.5 * weight * saddle_rad, ds])


def _derivative(function, order: NDArray, argument: Complexes) -> Complexes:
    """Derivative of a cylinder function: half of the difference of its neighbours in order (n = 0: minus order 1)."""
    below = np.where(order == 0, -function(1, argument), function(np.abs(order - 1), argument))
    return 0.5 * (below - function(order + 1, argument))
