"""Many mirrors: reflections of high order between two walls, and exact symmetry in a corner."""

from __future__ import annotations

from itertools import product

import numpy as np

from benchmarks.cells.probes.extremes.mirrors import AHEAD, MICS_M, SPEAKER_M, against, echoes, length_m, slab
from benchmarks.cells.probes.extremes.verdict import Errors
from simulator import Phone, Pose

MIRRORS = ("specular",)
LEFT_M, RIGHT_M = -1.3, 1.6


def order(max_order: int) -> Errors:
    """Between two parallel walls: two images of every order, by reflecting the speaker over and over."""
    walls = [slab([LEFT_M - 0.1, -99.0, -99.0], [LEFT_M, 99.0, 99.0], "left"),
             slab([RIGHT_M, -99.0, -99.0], [RIGHT_M + 0.1, 99.0, 99.0], "right")]  # fmt: skip
    found = echoes(walls, Pose(np.zeros(3), AHEAD), 50.0, mechanisms=MIRRORS, max_order=max_order)
    speaker, mics = (place[..., [1, 0, 2]].astype(np.longdouble) for place in (SPEAKER_M, MICS_M))
    images = []
    for first in (LEFT_M, RIGHT_M):
        image, mirror = speaker, np.longdouble(first)
        for _ in range(max_order):
            image = np.array([2 * mirror - image[0], image[1], image[2]])
            images.append(image)
            mirror = np.longdouble(LEFT_M) + np.longdouble(RIGHT_M) - mirror
    lengths = length_m(mics[:, None] - np.array(images).reshape(-1, 3)).reshape(-1)
    return against(found, np.repeat([0, 1], len(images)).tolist(), lengths)


def corner(distance_m: float, layout: str) -> Errors:
    """Where two walls and the ground meet, as far from each: seven images, whose paths meet edges in exact symmetry."""
    far = 20.0 * distance_m
    sides = [slab(np.where(axis == k, -0.1, 0.0) * np.ones(3), np.where(axis == k, 0.0, far) * np.ones(3), f"side {k}")
             for k, axis in ((k, np.arange(3)) for k in range(3))]  # fmt: skip
    mics = LAYOUTS[layout] * min(1.0, distance_m)
    place = np.full(3, distance_m)
    phone = Phone.ideal(np.zeros(3), AHEAD.inv().apply(mics))
    found = echoes(sides, Pose(place, AHEAD), far, phone, MIRRORS, max_order=3)
    signs = np.array([sign for sign in product((1.0, -1.0), repeat=3) if min(sign) < 0.0])
    received = place.astype(np.longdouble) + mics
    lengths = length_m(received[:, None] - signs * place.astype(np.longdouble)).reshape(-1)
    return against(found, np.repeat([0, 1], len(signs)).tolist(), lengths)


LAYOUTS = {
    "on the diagonal": np.array([[0.05, 0.05, 0.05], [-0.05, -0.05, -0.05]]),
    "a hair off": np.array([[0.05 + 1e-7, 0.05, 0.05 - 2e-7], [-0.05, -0.05 + 3e-6, -0.05]]),
    "at equal height": np.array([[0.07, 0.0, 0.0], [-0.07, 0.0, 0.0]]),
    "mirrored": np.array([[0.05, -0.05, 0.0], [-0.05, 0.05, 0.0]]),
    "askew": np.array([[0.061, -0.023, 0.017], [-0.013, 0.057, -0.031]]),
}
"""Where the microphones lie about the speaker, which is as far from all three mirrors."""
