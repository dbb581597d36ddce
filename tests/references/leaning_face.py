"""Corner echo of a flat face that leans on a rigid ground plane, by images, in two ways that share nothing.

The ground z = 0 is left out for its images: what face and mirrored face send from the speaker and from its image to the
receiver, in the open. `by_edges` adds up mirror paths and the Biot-Tolstoy-Medwin line integral of the crease and of
the sides, by plain quadrature (Svensson, Fred and Vanderkooy, J. Acoust. Soc. Am. 106 (1999) 2331-2344, Eqs. 16-18);
without sides it is the exact field of the endless wedge. `by_kirchhoff` adds up twice the incident pressure over both
faces, which is the better the flatter the wedge and knows no edges.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

BELOW = np.array([1.0, 1.0, -1.0])
STEP_M = 6e-4  # of the quadrature along edges: 3 Gauss points in 1/25 of a wavelength
GRAIN_M = 2.5e-3  # of the sum over the faces


@dataclass(frozen=True)
class Face:
    """A rectangle x = distance + z tan(lean), |y| < width / 2, 0 < z < height, the front of a body behind it."""

    distance_m: float
    width_m: float
    height_m: float
    lean_rad: float

    def halves(self) -> list[tuple[Floats, Floats]]:
        """Unit vectors up from the crease and normals of face and mirrored face."""
        up = np.array([np.sin(self.lean_rad), 0.0, np.cos(self.lean_rad)])
        normal = np.array([-np.cos(self.lean_rad), 0.0, np.sin(self.lean_rad)])
        return [(up, normal), (up * BELOW, normal * BELOW)]

    @property
    def foot_m(self) -> Floats:
        """(3,) middle of the crease."""
        return np.array([self.distance_m, 0.0, 0.0])

    @property
    def rise_m(self) -> float:
        """Length of the face from the crease to its top."""
        return self.height_m / np.cos(self.lean_rad)


def by_edges(face: Face, source_m: Floats, receiver_m: Floats, wavenumber: Floats, sides: bool = True) -> Complexes:
    """(K,) echo of the corner; without sides, that of a crease of 6 m between faces without end."""
    (up, normal), (down, mirrored) = face.halves()
    half = 0.5 * face.width_m if sides else 3.0
    across = np.array([0.0, half, 0.0])
    total = np.zeros(len(wavenumber), dtype=complex)
    for source in (source_m, source_m * BELOW):
        ends = source, receiver_m, wavenumber
        angle = np.pi + 2.0 * face.lean_rad
        total += _edge(*ends, face.foot_m - across, face.foot_m + across, down, mirrored, angle)
        for rise, front in ((up, normal), (down, mirrored)):
            total += _mirror_path(*ends, face.foot_m, rise, front, half, face.rise_m if sides else np.inf)
            if sides:
                top, back = face.foot_m + face.rise_m * rise, np.array([1.0, 0.0, 0.0])
                lid = np.mod(np.arctan2(back @ front, -(back @ rise)), 2.0 * np.pi)
                total += _edge(*ends, top - across, top + across, -rise, front, lid)
                for side in (-across, across):
                    low, inwards = face.foot_m + side, -side / half
                    total += _edge(*ends, low, low + face.rise_m * rise, inwards, front, 1.5 * np.pi)
    return total


def by_kirchhoff(face: Face, source_m: Floats, receiver_m: Floats, wavenumber: Floats) -> Complexes:
    """(K,) the same from a sum over both faces; of a face that overhangs, echoes from one face to the other lack."""
    counts = [int(np.ceil(length / GRAIN_M)) for length in (face.width_m, face.rise_m)]
    y = face.width_m * ((np.arange(counts[0]) + 0.5) / counts[0] - 0.5)
    s = face.rise_m * (np.arange(counts[1]) + 0.5) / counts[1]
    area = face.width_m * face.rise_m / np.prod(counts)
    total = np.zeros(len(wavenumber), dtype=complex)
    for source, (rise, front) in product((source_m, source_m * BELOW), face.halves()):
        point = face.foot_m + s[:, None, None] * rise + y[None, :, None] * np.array([0.0, 1.0, 0.0])
        (l, cosine), (m, other) = (_seen(point, front, end) for end in (source, receiver_m))
        for n, k in enumerate(wavenumber):
            slope = (1j * k + 1.0 / l) * cosine + (1j * k + 1.0 / m) * other
            total[n] += area * np.sum(slope * np.exp(-1j * k * (l + m)) / (4.0 * np.pi * l * m))
    return total


def _seen(point_m: Floats, normal: Floats, end_m: Floats) -> tuple[Floats, Floats]:
    """Distances of an end from points of a face, and cosines to its normal."""
    way = end_m - point_m
    far = np.linalg.norm(way, axis=2)
    return far, way @ normal / far


def _mirror_path(
    source: Floats, receiver: Floats, wavenumber: Floats, foot: Floats, rise: Floats, normal: Floats, half: float,
    length: float,
) -> Complexes:  # fmt: skip
    """(K,) the image of a source in one face, if it is seen from the receiver through the face."""
    before, after = (source - foot) @ normal, (receiver - foot) @ normal
    if min(before, after) <= 0.0:
        return np.zeros(len(wavenumber), dtype=complex)
    image = source - 2.0 * before * normal
    met = receiver + (image - receiver) * after / (before + after) - foot
    far = float(np.linalg.norm(image - receiver))
    return (0.0 <= met @ rise <= length and abs(met[1]) <= half) * np.exp(-1j * wavenumber * far) / far


def _edge(
    source: Floats, receiver: Floats, wavenumber: Floats, start: Floats, end: Floats, inwards: Floats, normal: Floats,
    open_angle: float,
) -> Complexes:  # fmt: skip
    """(K,) line integral over one edge; 0 where an end is inside the body."""
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    (r, s, z), (q, t, y) = (_about(point - start, along, inwards, normal) for point in (source, receiver))
    if max(s, t) > open_angle:
        return np.zeros(len(wavenumber), dtype=complex)
    count = int(np.ceil(length / STEP_M))
    x, w = np.polynomial.legendre.leggauss(3)
    at = (length / count * (np.arange(count)[:, None] + 0.5 + 0.5 * x)).ravel()
    weight = np.tile(0.5 * length / count * w, count)
    m, l = np.hypot(r, at - z), np.hypot(q, at - y)
    eta = np.arccosh(np.maximum((m * l + (at - z) * (at - y)) / (r * q), 1.0))
    nu = np.pi / open_angle
    beta = sum(
        np.sin(nu * f) / (2.0 * np.sinh(0.5 * nu * eta) ** 2 + 2.0 * np.sin(0.5 * nu * f) ** 2)
        for f in (np.pi + s + t, np.pi + s - t, np.pi - s + t, np.pi - s - t)
    )
    return -nu / (4.0 * np.pi) * np.exp(-1j * wavenumber[:, None] * (m + l)) @ (weight * beta / (m * l))


def _about(offset: Floats, along: Floats, inwards: Floats, normal: Floats) -> tuple[float, float, float]:
    """Distance from an edge, angle from its first face over the normal, height along it."""
    x, y = float(offset @ inwards), float(offset @ normal)
    return float(np.hypot(x, y)), float(np.mod(np.arctan2(y, x), 2.0 * np.pi)), float(offset @ along)
