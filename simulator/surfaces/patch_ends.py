"""Where mirrors end: planar patches at their sharp edges, and at the creases where they meet a smooth surface.

Where two patches meet in a corner the image goes on across it, and along a smooth edge the surface itself goes on. Of a
sheet that is folded, that is what its inside shows; seen from outside, either part ends at the fold.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.surfaces.creases import convex_creases
from simulator.surfaces.reflectors import MeshReading
from simulator.surfaces.wedges import Wedges


class PatchEnds(NamedTuple):
    """Borders of patches, patch by patch; compiled functions take it whole.

    Attributes:
        start_m, end_m: (B, 3) in the rest frames of their obstacles.
        outwards: (B, 3) from which side the patch ends there, 0 from both.
        first: (P + 1,) where those of each patch begin.
    """

    start_m: Floats
    end_m: Floats
    outwards: Floats
    first: Ints


def patch_ends(wedges: Wedges, readings: Sequence[MeshReading], patch_of: Ints) -> PatchEnds:
    """Where all patches end.

    Args:
        wedges: of all obstacles.
        readings: of all obstacles.
        patch_of: (P,) obstacle of each patch, sorted.
    """
    own = wedges[wedges.mirror < 0]
    owners, ends = [own.patch.ravel()], [np.repeat(np.stack([own.start_m, own.end_m], axis=1), 2, axis=0)]
    outwards = [np.where((own.patch[:, 0] == own.patch[:, 1])[:, None, None], 0.0, own.open_sides).reshape(-1, 3)]
    for obstacle in np.unique(patch_of):
        mesh, patch = readings[obstacle].mesh, readings[obstacle].patch
        rows = convex_creases(readings[obstacle])
        flat = patch[np.asarray(mesh.face_adjacency)[rows]].max(axis=1, initial=-1)
        corner = np.asarray(mesh.vertices)[np.asarray(mesh.face_adjacency_edges)[rows]]
        owners.append(np.searchsorted(patch_of, obstacle) + flat[flat >= 0])
        ends.append(corner[flat >= 0])
        outwards.append(np.zeros((int((flat >= 0).sum()), 3)))
    owner, end_m = np.concatenate(owners), np.concatenate(ends)
    order = np.argsort(owner, kind="stable")
    first = np.searchsorted(owner[order], np.arange(len(patch_of) + 1))
    return PatchEnds(end_m[order, 0], end_m[order, 1], np.concatenate(outwards)[order], first)
