"""Echo of a wall that is bent once, or of a shallow roof, by a sum over it: twice the incident pressure, no edges.

What it leaves out, the wedge's own wave, is as faint as the bend is slight.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

GRAIN_M = 6e-3


@dataclass(frozen=True)
class BentWall:
    """Two upright halves that meet at (distance, 0), each turned by half the bend; seen from the origin.

    Attributes:
        bend_rad: positive where the wall bends away from the origin on both sides.
    """

    distance_m: float
    width_m: float
    height_m: float
    bend_rad: float

    def mesh(self, thickness_m: float = 0.0) -> trimesh.Trimesh:
        """The front as an open sheet, or of a closed body."""
        x, y = 0.5 * self.width_m * np.sin(0.5 * self.bend_rad), 0.5 * self.width_m * np.cos(0.5 * self.bend_rad)
        line = np.array([[x, -y], [0.0, 0.0], [x, y]]) + [self.distance_m, 0.0]
        back = line[::-1] + [thickness_m, 0.0]
        outline = np.concatenate([line, back]) if thickness_m else line
        count, z = len(outline), 0.5 * self.height_m
        corners = np.concatenate([np.column_stack([outline, np.full(count, side)]) for side in (-z, z)])
        sides = [(i, (i + 1) % count) for i in range(count if thickness_m else count - 1)]
        faces = [face for i, j in sides for face in ([i, i + count, j + count], [i, j + count, j])]
        if thickness_m:
            for lid in ([0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]):
                faces += [lid, [count + i for i in lid[::-1]]]
        return trimesh.Trimesh(corners, faces, process=False)


def echo(mesh: trimesh.Trimesh, source_m: Floats, receiver_m: Floats, wavenumber: Floats) -> Complexes:
    """(K,) pressure re the source's free field at 1 m, off a sheet all of which is seen from both points."""
    corners, faces = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, 1.5 * GRAIN_M)
    facet = corners[faces]
    normal = np.cross(facet[:, 1] - facet[:, 0], facet[:, 2] - facet[:, 0])
    twice = np.linalg.norm(normal, axis=1)
    total = np.zeros(len(wavenumber), dtype=complex)
    offsets = [end - facet.mean(axis=1) for end in (source_m, receiver_m)]
    l, m = (np.linalg.norm(offset, axis=1) for offset in offsets)
    cosine, other = (
        np.abs(np.einsum("fx,fx->f", each, normal)) / twice / far for each, far in zip(offsets, (l, m), strict=True)
    )
    for n, k in enumerate(wavenumber):
        slope = (1j * k + 1.0 / l) * cosine + (1j * k + 1.0 / m) * other
        total[n] = np.sum(0.5 * twice * slope * np.exp(-1j * k * (l + m)) / (4.0 * np.pi * l * m))
    return total
