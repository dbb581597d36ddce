"""What is seen of an image: what lies within the pyramids from it through a rectangle round each of its mirrors."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.vectors import distance, dot

FLAT_M = 1e-9  # a rectangle seen at this height is a line and bounds nothing


@inlined
def bound(image, corner, beside, beam):
    """Fill in (4, 3) normals, inwards, of the planes through an image and the sides of a rectangle, moved outwards."""
    one, other, across, normal = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for side in range(4):
        width = distance(corner[(side + 1) % 4], corner[(side + 2) % 4])
        for x in range(3):
            across[x] = corner[(side + 2) % 4, x] - corner[(side + 1) % 4, x]
            out = -beside * across[x] / width
            one[x] = corner[side, x] - image[x] + out
            other[x] = corner[(side + 1) % 4, x] - image[x] + out
        for x in range(3):
            y, z = (x + 1) % 3, (x + 2) % 3
            normal[x] = one[y] * other[z] - one[z] * other[y]
        size, rise = np.sqrt(dot(normal, normal)), dot(normal, across)
        flat = abs(rise) <= FLAT_M * size
        for x in range(3):
            beam[side, x] = 0.0 if flat else normal[x] / (size if rise > 0.0 else -size)


@compiled
def aside(image, beam, point, radius):
    """Whether some plane of a beam leaves outside all points (Q, 3) and what is within a radius of them."""
    for k in range(len(beam)):
        for side in range(4):
            normal = beam[k, side]
            outside = normal[0] != 0.0 or normal[1] != 0.0 or normal[2] != 0.0
            for q in range(len(point)):
                rise = 0.0
                for x in range(3):
                    rise += (point[q, x] - image[x]) * normal[x]
                outside = outside and rise < -radius
            if outside:
                return True
    return False
