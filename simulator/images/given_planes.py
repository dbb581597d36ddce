"""Paths over planes that are given: the images of an end in one after the other, and the crossings on the way back.

`image_method` looks for sequences of patches and asks whether the crossings lie inside them. Here the sequence is known
and every reflection has its plane: where patches move within a beep, or before and after a curved surface or an edge.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import inlined
from obstaclewatch.support.compiled_vectors import dot as scalar_product
from obstaclewatch.support.vectors import dot
from simulator.world.candidates import Candidates
from simulator.world.mirrors import Mirrors

Steps = list[tuple[int, Flags]]  # reflections in the order met, and which of the R paths have them


def mirrors_about(found: Candidates, first: Ints, last: Ints) -> tuple[Steps, Steps]:
    """The mirrors before slot `first` (C,) of each path, and those behind slot `last`, from the receiver on."""
    width = found.sequence.shape[1]
    early = [(k, k < first) for k in range(width)]
    return early, [(k, (k > last) & (k < found.order)) for k in reversed(range(width))]


def planes_met(found: Candidates) -> tuple[Floats, Floats]:
    """(C, N, 3) normals and (C, N) offsets of the tangent planes at all reflections of paths."""
    return found.normal, dot(found.normal, found.points_m[:, 1:-1])


def mirrored(point_m: Floats, normal: Floats, offset_m: Floats) -> Floats:
    """(R, 3) images of points in planes, one plane a row."""
    return point_m - 2.0 * _heights(point_m, normal, offset_m)[..., None] * normal


@inlined
def fill_image(point, normal, offset, image):
    """Fill in the mirror image of a point (3,) in a plane, in its own place, too; of a vector with an offset of 0."""
    twice = 2.0 * (scalar_product(point, normal) - offset)
    for x in range(3):
        image[x] = point[x] - twice * normal[x]


def _heights(point_m: Floats, normal: Floats, offset_m: Floats) -> Floats:
    """(R,) of points over planes; by columns, as numpy's sums over three take seven times as long."""
    x, y, z = (point_m[..., k] * normal[..., k] for k in range(3))
    return x + y + z - offset_m


def images_in_turn(point_m: Floats, normal: Floats, offset_m: Floats, steps: Steps) -> Floats:
    """(N, R, 3) images of points (R, 3); element k is the image after reflection k in planes (R, N, 3) and (R, N)."""
    images, image = np.empty((normal.shape[1], *point_m.shape)), point_m
    for k, active in steps:
        image = np.where(active[:, None], mirrored(image, normal[:, k], offset_m[:, k]), image)
        images[k] = image
    return images


def last_image(point_m: Floats, normal: Floats, offset_m: Floats, steps: Steps) -> Floats:
    """(R, 3) images of points after all steps; the points themselves without any."""
    return images_in_turn(point_m, normal, offset_m, steps)[steps[-1][0]] if steps else point_m


def image_in(mirrors: Mirrors, point_m: Floats, pose: Ints, order: Ints, sequence: Ints) -> Floats:
    """(R, 3) images of points in sequences (R, N) of so many mirrors at (R,) poses, -1 padded."""
    met = sequence[:, : int(order.max(initial=0))]  # no column where there is no mirror in the scene to pad with
    planes, steps = (pose[:, None], met), [(k, order > k) for k in range(met.shape[1])]
    return last_image(point_m, mirrors.normal[planes], mirrors.offset_m[planes], steps)


def crossings_in_turn(start_m: Floats, images: Floats, normal: Floats, offset_m: Floats, steps: Steps) -> Floats:
    """(R, N, 3) where paths back from (R, 3) to the images (N, R, 3) cross each plane; 0 where a path has none.

    Where both lie on one side, as a path in a mirror's shadow may within a beep, the nearer end stands for a crossing
    that would run off to infinity.
    """
    crossings, target = np.zeros(normal.shape), start_m.copy()
    for k, active in steps:
        here, there = (_heights(point, normal[:, k], offset_m[:, k]) for point in (target, images[k]))
        gap = np.where(active & (here != there), here - there, 1.0)
        share = np.clip(here / gap, 0.0, 1.0)
        crossing = target + share[:, None] * (images[k] - target)
        target[active] = crossings[active, k] = crossing[active]
    return crossings
