"""Ways over two round bodies, by minimising the length over both surfaces, and their level by perturbed rays.

Shares nothing with the simulator: bodies are exact spheres and endless upright cylinders, reflection points come from a
general minimiser, and the spreading is the solid angle of three neighbouring rays over the area they cover at the end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Round:
    """A sphere, or an endless upright cylinder."""

    center_m: Floats
    radius_m: float
    upright: bool

    def point(self, q: Floats) -> Floats:
        """(3,) surface point of two parameters: azimuth, and height or elevation."""
        around = np.array([np.cos(q[0]), np.sin(q[0]), 0.0])
        if self.upright:
            return self.center_m * [1.0, 1.0, 0.0] + self.radius_m * around + [0.0, 0.0, q[1]]
        return self.center_m + self.radius_m * (np.cos(q[1]) * around + [0.0, 0.0, np.sin(q[1])])

    def parameters(self, point: Floats) -> Floats:
        """The parameters of the surface point nearest to a place."""
        offset = point - self.center_m
        azimuth = np.arctan2(offset[1], offset[0])
        return np.array([azimuth, point[2] if self.upright else np.arctan2(offset[2], np.hypot(offset[0], offset[1]))])

    def normal(self, point: Floats) -> Floats:
        """(3,) outward unit normal at a surface point."""
        offset = (point - self.center_m) * self._flat
        return offset / np.linalg.norm(offset)

    def struck(self, start: Floats, ray: Floats) -> tuple[Floats, Floats]:
        """Where a ray first meets the body, and the ray after it."""
        offset, flat = (start - self.center_m) * self._flat, ray * self._flat
        half, rest = offset @ flat, offset @ offset - self.radius_m**2
        way = (-half - np.sqrt(half**2 - (flat @ flat) * rest)) / (flat @ flat)
        point = start + way * ray
        n = self.normal(point)
        return point, ray - 2.0 * (ray @ n) * n

    @property
    def _flat(self) -> Floats:
        return np.array([1.0, 1.0, 0.0 if self.upright else 1.0])


def way_over(first: Round, second: Round, source: Floats, receiver: Floats) -> tuple[Floats, float]:
    """(4, 3) source, both reflection points, receiver of the specular way, and the amplitude of its ray tube."""

    def mismatch(q: Floats) -> Floats:
        points = [source, first.point(q[:2]), second.point(q[2:]), receiver]
        out = []
        for body, before, here, after in ((first, *points[:3]), (second, *points[1:])):
            h = (before - here) / np.linalg.norm(before - here) + (after - here) / np.linalg.norm(after - here)
            n = body.normal(here)
            out.append(h - (h @ n) * n)
        return np.concatenate(out)

    q = np.concatenate([first.parameters(0.5 * (source + second.center_m)), second.parameters(receiver)])
    for _ in range(3):  # the facing sides of both, then the root
        q[:2] = first.parameters(0.5 * (source + second.point(q[2:])))
        q[2:] = second.parameters(0.5 * (receiver + first.point(q[:2])))
    q = least_squares(mismatch, q, xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    assert np.abs(mismatch(q)).max() < 1e-10
    points = np.stack([source, first.point(q[:2]), second.point(q[2:]), receiver])
    return points, _tube(first, second, points)


def _tube(first: Round, second: Round, points: Floats, step: float = 1e-5) -> float:
    """sqrt(solid angle / area) by central differences of rays about the specular one, across its last leg."""
    ray = (points[1] - points[0]) / np.linalg.norm(points[1] - points[0])
    last = (points[3] - points[2]) / np.linalg.norm(points[3] - points[2])
    across = np.linalg.svd(ray[None])[2][1:]

    def end(direction: Floats) -> Floats:
        direction = direction / np.linalg.norm(direction)
        one, bent = first.struck(points[0], direction)
        two, out = second.struck(one, bent)
        return two + out * (((points[3] - two) @ last) / (out @ last))

    spread = [(end(ray + step * e) - end(ray - step * e)) / (2.0 * step) for e in across]
    return float(1.0 / np.sqrt(np.linalg.norm(np.cross(*spread))))
