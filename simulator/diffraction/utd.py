"""Diffraction at an edge by the uniform theory: the apex alone, as if the edge had no ends.

Kouyoumjian and Pathak, Proc. IEEE 62 (1974) 1448-1461, for hard faces and a spherical wave. With the distances s', s
of source and receiver from the apex, L0 = s' + s, their radii r', r from the edge and nu = pi / open angle,

    D sqrt(s' / (s L0)) / s' = -sum_4 (nu / 2 L0) q_i T(k x_i),   x_i = 2 r' r sin^2(f_i / 2) / L0,
    q_i = sin(|f_i| / 2) / tan(nu f_i / 2),   T(y) = e^{jy} erfc(sqrt(jy)),

in the angles f_i of `edges.zone_angles`: their Eqs. 25-30, where F(y) = sqrt(pi y) e^{j pi / 4} T(y) and x_i is k L a.
In this form nothing diverges at a zone's border, where q_i = +-1 / nu and half the mirror path is made up for.

Measured against the exact line integral of an endless edge: 0.1 % of the strongest group at 1 m and 18-23 kHz, 0.025 %
at 4 m, as 1 / (k r); 2.5 instead of 4.7 us a row, and one row instead of three for each edge. What it costs is what the
ends would have sent: against full-wave plates of 0.2-0.45 m at 1.5-3 m, 1.3 dB where the echo is above -20 dB re wall,
1.6 dB to -30 dB and 2.1 dB below, where the integral has 0.04, 0.4 and 0.94 dB.
"""

from __future__ import annotations

import numpy as np
from scipy.special import wofz

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from simulator.diffraction.btm import check, zone_angles
from simulator.diffraction.edge_view import APEX, EdgeView


def utd_terms(view: EdgeView, part: Ints, wavenumber: Floats) -> Complexes:
    """Contributions of edges, in the form of `edges.edge_terms`; those of START and END are 0.

    Args:
        view: R edges.
        part: (R,) APEX, START or END.
        wavenumber: (K,) rad/m.

    Returns:
        (R, 3, K) without the travel phase; groups INCIDENT, FACE_0, FACE_N.

    Raises:
        ValueError: a radius of 0, an open angle outside pi to 2 pi, wavenumbers not positive.
    """
    check(view, wavenumber)
    angle, nu = zone_angles(view), np.pi / view.open_angle_rad[:, None]
    shortest = view.apex_path_m[:, None]
    product = (view.source_radius_m * view.receiver_radius_m)[:, None]
    half = np.sin(0.5 * np.abs(angle))
    on_border = angle == 0.0
    share = np.where(on_border, 1.0 / nu, half / np.tan(np.where(on_border, 1.0, 0.5 * nu * angle)))
    strength = np.where((part == APEX)[:, None], -0.5 * nu * share / shortest, 0.0)
    terms = strength[:, :, None] * _transition((2.0 * product * half**2 / shortest)[:, :, None] * wavenumber)
    return np.stack([terms[:, 0] + terms[:, 1], terms[:, 2], terms[:, 3]], axis=1)


def _transition(phase: Floats) -> Complexes:
    """T(y) = e^{jy} erfc(sqrt(jy)): 1 on the border of a zone, 1 / sqrt(j pi y) far from it."""
    return wofz(np.exp(0.75j * np.pi) * np.sqrt(phase))
