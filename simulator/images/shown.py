"""What the mirrors of an image show of an obstacle: half-spaces, for searches over its surface."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import dot
from simulator.images.given_planes import fill_image
from simulator.images.image_tree import Images, bound
from simulator.world.frames import rotated_back
from simulator.world.world import Tracing


def shown(tracing: Tracing, images: Images, obstacle: int, beside_m: float) -> Floats:
    """(I, 5 N, 4) half-spaces that mirrors show of an obstacle at rest to images: normals inwards and offsets; 0 pads.

    Args:
        beside_m: how far outside its rectangle a mirror is still taken to show something.
    """
    frame = np.ascontiguousarray(tracing.placed[:, obstacle])
    return _shown(
        tracing.mirrors, images.pose, images.order, images.sequence, images.point_m, frame, beside_m
    )  # type: ignore[call-arg]  # fmt: skip


@compiled
def _shown(mirrors, pose, order, sequence, image, frame, beside):
    """The same of images (I, 3) in sequences (I, N), seen in frames (poses, 4)."""
    rows, width = sequence.shape
    out, corner, beam = np.zeros((rows, 5 * width, 4)), np.empty((4, 3)), np.empty((4, 3))
    for r in range(rows):
        n = pose[r]
        for k in range(order[r]):
            for i in range(4):
                for x in range(3):
                    corner[i, x] = mirrors.corner_m[n, sequence[r, k], i, x]
            for later in range(k + 1, order[r]):
                normal, offset = mirrors.normal[n, sequence[r, later]], mirrors.offset_m[n, sequence[r, later]]
                for i in range(4):
                    fill_image(corner[i], normal, offset, corner[i])
            bound(image[r], corner, beside, beam)
            for side in range(4):
                _at_rest(beam[side], dot(beam[side], image[r]), frame[n], out[r, 5 * k + side])
        if order[r] > 0:  # and what lies beyond the last mirror
            p = sequence[r, order[r] - 1]
            sign = -1.0 if dot(image[r], mirrors.normal[n, p]) > mirrors.offset_m[n, p] else 1.0
            for x in range(3):
                beam[0, x] = sign * mirrors.normal[n, p, x]
            _at_rest(beam[0], sign * mirrors.offset_m[n, p] - beside, frame[n], out[r, 4])
    return out


@inlined
def _at_rest(normal, offset, frame, out):
    """Fill in a half-space as it is seen in a rest frame."""
    out[0], out[1] = rotated_back(normal[0], normal[1], np.cos(frame[3]), np.sin(frame[3]))
    out[2], out[3] = normal[2], offset - dot(normal, frame)
