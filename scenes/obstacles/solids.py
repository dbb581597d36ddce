"""Solids from which obstacles are built: boxes, plates, lofts of rings, ellipsoids.

Every solid is closed, its normals point outwards, and the vertices of a curved side lie on the true surface. Rows
of a loft share their vertices, so that neighbouring facets of a smooth side meet at a small angle and real creases
stay sharp.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from obstaclewatch.support.argument_types import as_finite, check_counts
from obstaclewatch.support.arrays import Floats, Ints
from scenes.obstacles.measures import measured, require_least, require_length


def box(size_m: ArrayLike, center_m: ArrayLike | None = None) -> trimesh.Trimesh:
    """Box with sides along the axes; without a centre it stands on z = 0 over the origin.

    Raises:
        ValueError: a side that is not positive, or anything but three numbers.
    """
    size = _three("size_m", size_m)
    for side in size:
        require_length("side of a box", side)
    center = np.array([0.0, 0.0, size[2] / 2]) if center_m is None else _three("center_m", center_m)
    mesh: trimesh.Trimesh = trimesh.creation.box(extents=size)
    mesh.apply_translation(center)
    return mesh


@measured
def cylinder(
    radius_m: float, height_m: float, segments: int = 48, rows: int = 4, top_radius_m: float | None = None
) -> trimesh.Trimesh:
    """Upright cylinder or truncated cone on z = 0, closed by flat ends.

    Args:
        radius_m: radius at the bottom.
        height_m: height.
        segments: facets around it; 48 meet at 7.5 degrees.
        rows: facets up its side, which keep triangles from degenerating to slivers.
        top_radius_m: radius at the top; None is that of the bottom.

    Raises:
        ValueError: a measure that is not positive, fewer than 3 segments, no row, more than 1000 of either.
    """
    check_counts(3, segments=segments)
    top = radius_m if top_radius_m is None else top_radius_m
    step = np.linspace(0.0, 1.0, rows + 1)
    return loft(ellipse_rings(step * height_m, radius_m + step * (top - radius_m), segments=segments))


def disc(radius_m: float, thickness_m: float, segments: int = 48) -> trimesh.Trimesh:
    """Round sheet facing +x, centred at the origin."""
    mesh = cylinder(radius_m, thickness_m, segments, rows=1)
    mesh.apply_translation([0.0, 0.0, -thickness_m / 2])
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0.0, 1.0, 0.0]))
    return mesh


def ellipsoid(center_m: ArrayLike, radii_m: ArrayLike, segments: int = 24, rows: int = 14) -> trimesh.Trimesh:
    """Ellipsoid with its poles on the z axis; from row to row its normal turns by equal angles."""
    center, radii = np.asarray(center_m, dtype=np.float64), np.asarray(radii_m, dtype=np.float64)
    normal = np.linspace(-np.pi / 2, np.pi / 2, rows + 1)[1:-1]
    latitude = np.arctan(radii[2] / radii[:2].mean() * np.tan(normal))
    rings = ellipse_rings(
        center[2] + radii[2] * np.sin(latitude),
        np.cos(latitude)[:, None] * radii[:2],
        np.broadcast_to(center[:2], (len(latitude), 2)),
        segments,
    )
    return loft(rings, bottom_m=center - [0.0, 0.0, radii[2]], top_m=center + [0.0, 0.0, radii[2]])


def ellipse_rings(z_m: ArrayLike, radii_m: ArrayLike, center_m: ArrayLike | None = None, segments: int = 32) -> Floats:
    """(M, segments, 3) horizontal ellipses at the heights z_m (M,), counter-clockwise from above.

    Args:
        z_m: (M,) heights.
        radii_m: (M,) radii of circles, or (M, 2) half axes along x and y.
        center_m: (M, 2) centres; None is the z axis.
        segments: points on each ring.
    """
    z, radii = np.asarray(z_m, dtype=np.float64), np.asarray(radii_m, dtype=np.float64)
    radii = np.stack([radii, radii], axis=-1) if radii.ndim == 1 else radii
    center = np.zeros((len(z), 2)) if center_m is None else np.asarray(center_m, dtype=np.float64)
    angle = 2.0 * np.pi * np.arange(segments) / segments
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    plan = center[:, None] + radii[:, None] * circle
    return np.concatenate([plan, np.broadcast_to(z[:, None, None], (len(z), segments, 1))], axis=-1)


def rounded_rectangle(size_m: ArrayLike, corner_m: float, corner_segments: int = 5) -> Floats:
    """(N, 2) closed outline, counter-clockwise, centred; its corners are arcs.

    Raises:
        ValueError: a corner radius that does not fit the sides.
    """
    half = np.asarray(size_m, dtype=np.float64) / 2
    if not 0.0 < corner_m < half.min():
        raise ValueError(f"corner_m must lie between 0 and half the shorter side {half.min()} m, got {corner_m}")
    quarter = np.linspace(0.0, np.pi / 2, corner_segments + 1)
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    angle = quarter + np.pi / 2 * np.arange(4)[:, None]
    arcs = (signs * (half - corner_m))[:, None] + corner_m * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return arcs.reshape(-1, 2)


def prism(profile_m: ArrayLike, length_m: float) -> trimesh.Trimesh:
    """Extrusion along y, centred, of a convex (K, 2) profile in x and z, counter-clockwise with x right and z up."""
    profile = np.asarray(profile_m, dtype=np.float64)
    return loft(np.stack([np.insert(profile, 1, y, axis=1) for y in (length_m / 2, -length_m / 2)]))


def wheel(radius_m: float, width_m: float) -> trimesh.Trimesh:
    """A wheel that rolls along x, centred at the origin."""
    mesh = shifted(cylinder(radius_m, width_m, 32, rows=1), [0.0, 0.0, -width_m / 2])
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1.0, 0.0, 0.0]))
    return mesh


def raised(outlines_m: Floats, z_m: Floats) -> Floats:
    """(M, N, 3) rings from (M, N, 2) outlines at the heights z_m (M,)."""
    z = np.broadcast_to(z_m[:, None, None], (*outlines_m.shape[:2], 1))
    return np.concatenate([outlines_m, z], axis=-1)


def loft(
    rings_m: Floats, bottom_m: ArrayLike | None = None, top_m: ArrayLike | None = None, strips: bool = False
) -> trimesh.Trimesh:
    """Closed surface through M rings of N points each.

    Args:
        rings_m: (M, N, 3) rings, counter-clockwise seen from the direction in which they progress.
        bottom_m, top_m: (3,) points to which the first and the last ring are fanned; None is the ring's centroid,
            which makes a flat end.
        strips: close both ends by strips between the points k and N - k instead, for rings of even N that are
            symmetric about the line through the points 0 and N/2: exact where an end curves along that line only.

    Returns:
        A watertight mesh, normals outwards.
    """
    rows, count = rings_m.shape[:2]
    here = np.arange(rows * count).reshape(rows, count)
    corner = here[:-1], np.roll(here, -1, axis=1)[:-1], np.roll(here, -1, axis=1)[1:], here[1:]
    sides = [np.stack(corner[:3], axis=-1).reshape(-1, 3), np.stack([corner[i] for i in (0, 2, 3)], -1).reshape(-1, 3)]
    if strips:
        ends = [here[0][_strips(count)[:, ::-1]], here[-1][_strips(count)]]
        return trimesh.Trimesh(rings_m.reshape(-1, 3), np.concatenate(sides + ends), process=False)
    bottom = rings_m[0].mean(axis=0) if bottom_m is None else np.asarray(bottom_m, dtype=np.float64)
    top = rings_m[-1].mean(axis=0) if top_m is None else np.asarray(top_m, dtype=np.float64)
    first, last = np.full(count, rows * count), np.full(count, rows * count + 1)
    ends = [
        np.stack([first, np.roll(here[0], -1), here[0]], axis=-1),
        np.stack([last, here[-1], np.roll(here[-1], -1)], axis=-1),
    ]
    vertices = np.concatenate([rings_m.reshape(-1, 3), bottom[None], top[None]])
    return trimesh.Trimesh(vertices, np.concatenate(sides + ends), process=False)


def _strips(count: int) -> Ints:
    """(count - 2, 3) triangles that fill a ring of even count between the points k and count - k."""
    k = np.arange(count // 2)
    near = np.stack([k, k + 1, (count - k - 1) % count], axis=-1)
    far = np.stack([k, (count - k - 1) % count, (count - k) % count], axis=-1)
    return np.concatenate([near[:-1], far[1:]])


def places_along(length_m: float, name: str, spacing_m: float, post_m: float) -> Floats:
    """(N,) middles of posts along a length, centred, one at either end, at most that spacing apart.

    Args:
        length_m: from end to end.
        name: of the argument that is the spacing, for the message.
        spacing_m: greatest distance between neighbours; the posts grow in number as it shrinks, without an end.
        post_m: width of a post, the least length and spacing.

    Raises:
        ValueError: a length or spacing below the width of a post.
    """
    for label, value in (("length_m", length_m), (name, spacing_m)):
        require_least(label, value, post_m, "the width of one post")
    places: Floats = np.linspace(-0.5, 0.5, int(np.ceil(length_m / spacing_m)) + 1) * (length_m - post_m)
    return places


def _three(name: str, value: ArrayLike) -> Floats:
    numbers = as_finite(name, value)
    if numbers.shape != (3,):
        raise ValueError(f"{name} must be three numbers, got {np.asarray(value).tolist()}")
    return numbers


def merged(parts: Sequence[trimesh.Trimesh]) -> trimesh.Trimesh:
    """One mesh of several closed parts, which may overlap; each part keeps its own vertices."""
    mesh: trimesh.Trimesh = trimesh.util.concatenate(parts)  # type: ignore[assignment]
    return mesh


def shifted(mesh: trimesh.Trimesh, offset_m: ArrayLike) -> trimesh.Trimesh:
    """A copy moved by (3,) m."""
    return trimesh.Trimesh(mesh.vertices + np.asarray(offset_m, dtype=np.float64), mesh.faces, process=False)


def tilted(mesh: trimesh.Trimesh, angle_rad: float) -> trimesh.Trimesh:
    """A copy rotated about the y axis through the origin; a positive angle leans its top towards +x."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    return trimesh.Trimesh(mesh.vertices @ turn.T, mesh.faces, process=False)
