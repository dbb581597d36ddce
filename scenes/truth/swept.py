"""Does the walker's body meet an obstacle? Distances in plan between a moving stadium and a slab of the mesh.

The body is an upright prism whose plan is a stadium: all points within `half_width_m` of a core segment that points
along the heading. The obstacle is the part of its mesh between the ground and the walker's height, seen from above.
They touch when the distance in plan between core and slab falls to the half width. Clipping is trimesh's, distances
are those of GEOS (shapely), over an index of all triangles.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
import trimesh
from scipy.optimize import brentq

from obstaclewatch.support.argument_types import hold_numbers
from obstaclewatch.support.arrays import Floats

STRIDE = 16
"""Of so many segments one is asked for its distance whatever it is."""
ROUNDING_M = 1e-9


@dataclass(frozen=True)
class Body:
    """Measures of the walker's body around the phone.

    Attributes:
        half_width_m: half the width across the walk; the paper's users are not measured, 0.25 m is our convention.
        front_m: how far the body (hands and phone) reaches ahead of the phone's origin.
        back_m: how far it reaches behind the phone's origin: arm's length and the depth of the torso.
        height_m: how high it reaches above the ground.
    """

    half_width_m: float = 0.25
    front_m: float = 0.10
    back_m: float = 0.60
    height_m: float = 1.8

    def __post_init__(self) -> None:
        hold_numbers(self, *vars(self))
        for name in ("half_width_m", "front_m", "back_m"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} must not be negative, got {getattr(self, name)}")
        if not 0.0 < self.height_m < np.inf:
            raise ValueError(f"height_m must be positive, got {self.height_m}")

    def core(self, phone_m: Floats, heading_rad: Floats) -> Floats:
        """(N, 2, 2) ends, front first, of the core segment in plan, for (N, 3) phone positions and (N,) headings."""
        ahead = np.stack([np.cos(heading_rad), np.sin(heading_rad)], axis=-1)
        front, back = self.front_m - self.half_width_m, self.half_width_m - self.back_m
        if front < back:  # a body broader than deep: its core is a point
            front = back = 0.5 * (front + back)
        along = np.array([front, back])[:, None]
        core: Floats = phone_m[:, None, :2] + along * ahead[:, None]
        return core


@dataclass(frozen=True)
class Slab:
    """What of a mesh lies between two heights, in plan.

    Attributes:
        triangle_m: (P, 3, 2) corners of the mesh's triangles, clipped to the heights, seen from above.
    """

    triangle_m: Floats

    @cached_property
    def tree(self) -> shapely.STRtree:
        """The triangles' index, in which the nearest is found."""
        return shapely.STRtree(shapely.polygons(self.triangle_m))

    @classmethod
    def of(cls, mesh: trimesh.Trimesh, low_m: float, high_m: float) -> Slab:
        """The slab between two heights; no triangles if nothing of the mesh is there."""
        vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
        for up, height in ((1.0, low_m), (-1.0, high_m)):
            if (up * vertices[:, 2] < up * height).any():
                clipped = trimesh.intersections.slice_faces_plane(vertices, faces, [0.0, 0.0, up], [0.0, 0.0, height])
                vertices, faces = clipped[:2]
        return cls(vertices[faces][:, :, :2])

    def distance(self, segment_m: Floats) -> Floats:
        """(N,) distances in plan to segments (N, 2, 2), m; 0 where they overlap, infinite if the slab is empty."""
        if len(self.triangle_m) == 0:
            return np.full(len(segment_m), np.inf)
        distance: Floats = self.tree.query_nearest(
            shapely.linestrings(segment_m), all_matches=False, return_distance=True
        )[1]
        return distance

    def far_from(self, segment_m: Floats, gap_m: float) -> bool:
        """Whether segments (N, 2, 2) keep more than a gap from the slab's bounding box, and so from the slab."""
        if len(self.triangle_m) == 0:
            return True
        low, high = self.triangle_m.min(axis=(0, 1)), self.triangle_m.max(axis=(0, 1))
        box = shapely.box(*low, *high)
        return bool((shapely.distance(shapely.linestrings(segment_m), box) > gap_m + ROUNDING_M).all())

    def distance_where_near(self, segment_m: Floats, near_m: float = 0.0, beyond_least_m: float = 0.0) -> Floats:
        """As `distance` for N consecutive segments wherever they are near, and elsewhere bounds from below.

        Near is what lies within `near_m`, or within the least distance and `beyond_least_m` more. Between two segments
        the distance changes by no more than their ends move, so most need not be asked.
        """
        asked = np.unique(np.append(np.arange(0, len(segment_m), STRIDE), len(segment_m) - 1))
        known = self.distance(segment_m[asked])
        moved = np.linalg.norm(np.diff(segment_m, axis=0), axis=2).max(axis=1)
        along = np.concatenate([[0.0], np.cumsum(moved)])
        place = np.arange(len(segment_m))
        after = np.searchsorted(asked, place)
        before = np.searchsorted(asked, place, side="right") - 1
        distance: Floats = np.maximum(
            known[before] - (along - along[asked[before]]), known[after] - (along[asked[after]] - along)
        )
        near = distance <= max(near_m, float(known.min()) + beyond_least_m) + ROUNDING_M
        distance[near] = self.distance(segment_m[near])
        return distance

    def first_contact(self, core_m: Floats, distance_m: Floats, half_width_m: float) -> float:
        """Where along N consecutive cores (N, 2, 2), at distances (N,), the distance first falls to the half width.

        Returns:
            A fractional index, linear between two cores; NaN if it never does. Contact that begins and ends between
            two cores, and so is shallower than the bulge of the obstacle between them, is not seen.
        """
        touching = np.flatnonzero(distance_m <= half_width_m)
        if len(touching) == 0:
            return np.nan
        last = int(touching[0])
        if last == 0:
            return 0.0

        def gap(index: float) -> float:
            share = index - (last - 1)
            core = (1.0 - share) * core_m[last - 1] + share * core_m[last]
            return float(self.distance(core[None])[0]) - half_width_m

        return float(brentq(gap, last - 1, last, xtol=1e-12))
