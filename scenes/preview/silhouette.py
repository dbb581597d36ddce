"""What a projected mesh covers: the union of its triangles, as a shape of shapely."""

from __future__ import annotations

import shapely

from obstaclewatch.support.arrays import Floats

SLACK_M = 0.005
"""How far an outline may lie off the triangles: a line in any picture."""
GRID_M = 1e-4
"""To which corners are rounded: without a grid the union of slivers may fail (GEOS, "Ring edge missing")."""


def silhouette(corners_m: Floats) -> shapely.Geometry:
    """The union of projected triangles (T, 3, 2); a sheet seen edge-on is as wide as a drawn line.

    >>> import numpy as np
    >>> silhouette(np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]])).area
    1.0
    """
    faces = shapely.polygons(corners_m)
    seen = shapely.area(faces) > SLACK_M**4
    if not seen.any():
        faces, seen = shapely.buffer(shapely.linestrings(corners_m), 2.0 * SLACK_M), slice(None)
    return shapely.union_all(faces[seen], grid_size=GRID_M).simplify(SLACK_M)


def outer_rings(shape: shapely.Geometry) -> list[Floats]:
    """(K, 2) corners of every part's outer border, closed; holes are left out."""
    return [shapely.get_coordinates(shapely.get_exterior_ring(part)) for part in shapely.get_parts(shape)]
