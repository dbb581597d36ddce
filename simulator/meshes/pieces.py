"""What of a mesh hangs together, and vertices of its own for each part."""

from __future__ import annotations

import numpy as np
import trimesh

from obstaclewatch.support.arrays import Ints
from obstaclewatch.support.distinct_rows import distinct


def components(pairs: Ints, count: int) -> Ints:
    """(count,) label of what hangs together by the pairs given."""
    return trimesh.graph.connected_component_labels(pairs, node_count=count).astype(np.int64)


def pieces_of(mesh: trimesh.Trimesh) -> Ints:
    """(T,) label of the connected piece that each facet is of."""
    return components(mesh.face_adjacency, len(mesh.faces))


def with_own_corners(mesh: trimesh.Trimesh, part: Ints) -> trimesh.Trimesh:
    """A mesh whose corners, (3 T,) of all facets in turn, share a vertex within their part alone."""
    corners = np.column_stack([part, mesh.faces.ravel()])
    first, which = distinct(corners)
    return trimesh.Trimesh(mesh.vertices[corners[first, 1]], which.reshape(-1, 3), process=False)
