"""Where mirrors end: planar patches at their sharp edges, and at the creases where they meet a smooth surface.

Where two patches meet in a corner the image goes on across it, and along a smooth edge the surface itself goes on.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.surfaces.creases import convex_creases
from simulator.surfaces.reflectors import MeshReading
from simulator.surfaces.wedges import Wedges


def patch_ends(wedges: Wedges, readings: Sequence[MeshReading], patch_of: Ints) -> tuple[Floats, Floats, Ints]:
    """(B, 3) starts and ends, patch by patch, in the rest frames; (P + 1,) where those of each patch begin.

    Args:
        wedges: of all obstacles.
        readings: of all obstacles.
        patch_of: (P,) obstacle of each patch, sorted.
    """
    own = wedges[wedges.mirror < 0]
    owners, ends = [own.patch.ravel()], [np.repeat(np.stack([own.start_m, own.end_m], axis=1), 2, axis=0)]
    for obstacle in np.unique(patch_of):
        mesh, patch = readings[obstacle].mesh, readings[obstacle].patch
        rows = convex_creases(readings[obstacle])
        flat = patch[np.asarray(mesh.face_adjacency)[rows]].max(axis=1, initial=-1)
        corner = np.asarray(mesh.vertices)[np.asarray(mesh.face_adjacency_edges)[rows]]
        owners.append(np.searchsorted(patch_of, obstacle) + flat[flat >= 0])
        ends.append(corner[flat >= 0])
    owner, end_m = np.concatenate(owners), np.concatenate(ends)
    order = np.argsort(owner, kind="stable")
    first = np.searchsorted(owner[order], np.arange(len(patch_of) + 1))
    return end_m[order, 0], end_m[order, 1], first
