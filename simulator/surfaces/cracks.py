"""Cracks in flat faces, closed: what is narrower than an eighth of the wavelength leaves no gap in an echo.

Walls in parts, boxes side by side and slits seldom meet to the last digit. A mirror point that falls between two such
faces would find neither, and their borders count as touching (`contacts`), so that no edge wave fills the gap. Each
crack gets a strip: it is added to the outline of one of the faces, and it casts a shadow.

Nor do boxes stand on the ground to the last digit. What is reflected off both right in the corner would find neither,
where phone and corner are in one plane. So a face that ends just before another plane goes down to it.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import shapely
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled
from obstaclewatch.support.vectors import dot, norm, unit
from simulator.meshes.planar_regions import COPLANAR_RAD
from simulator.surfaces.near_balls import ASLANT, touching
from simulator.surfaces.reflectors import PlanarPatches

WIDEST_M = 2e-3  # an open crack of this width takes 0.3 dB off the echo of a wall at 1.5 m
LEAST_M = 1e-9  # what mirrors take for their border anyway
MOST_M = 6.0 * WIDEST_M  # from the ball about a patch: more than what is asked about a corner lies beside it
ALIKE = 0.9  # least cosine between the two borders of a crack


def cracks(patches: PlanarPatches, frame: Ints) -> tuple[Ints, Floats]:
    """Strips between borders that face one another in one plane.

    Args:
        patches: of all obstacles, where they stand at time 0.
        frame: (O,) number of the rest frame of each obstacle: what moves apart makes no crack.

    Returns:
        (K,) patch at whose border a strip begins, and (K, 4, 3) its corners in turn.
    """
    owner = np.repeat(np.arange(len(patches)), np.diff(patches.edge_start))
    one, other = _near(patches, owner, frame)
    here, there, rows = _facing(patches.edge_m[one], patches.edge_m[other])
    strip = np.concatenate([here, there[:, ::-1]], axis=1)
    patch, beside = owner[one[rows]], owner[other[rows]]
    middle = strip.mean(axis=1)
    gap = ~(_inside(patches, patch, middle) | _inside(patches, beside, middle))
    return patch[gap], strip[gap]


def closed(patches: PlanarPatches, patch: Ints, strip_m: Floats) -> PlanarPatches:
    """The patches with strips (K, 4, 3) added to the outlines of patches (K,).

    An outline's segments count crossings, even or odd: where a strip runs along a border the two cancel.
    """
    normal = patches.normal[patch][:, None]
    height = dot(strip_m, normal) - patches.offset_m[patch, None]
    flat = strip_m - height[..., None] * normal
    owner = np.concatenate([np.repeat(np.arange(len(patches)), np.diff(patches.edge_start)), np.repeat(patch, 4)])
    edge = np.concatenate([patches.edge_m, np.stack([flat, np.roll(flat, -1, axis=1)], axis=2).reshape(-1, 2, 3)])
    radius = patches.radius_m.copy()
    np.maximum.at(radius, patch, norm(flat - patches.center_m[patch][:, None]).max(axis=1))
    start = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=len(patches)))]).astype(np.int64)
    return replace(patches, edge_m=edge[np.argsort(owner, kind="stable")], edge_start=start, radius_m=radius)


def down_to_others(patches: PlanarPatches, frame: Ints) -> PlanarPatches:
    """The patches, with corners that end less than `WIDEST_M` before another patch at an angle moved onto its plane.

    Args:
        patches: of all obstacles, where they stand at time 0.
        frame: (O,) number of the rest frame of each obstacle: none reaches for what moves against it.
    """
    normal, point = patches.normal, patches.edge_m.reshape(-1, 3)
    face_of = np.repeat(np.arange(len(patches)), 2 * np.diff(patches.edge_start))
    ends_before = partial(_ends_before, patches, frame, point, face_of)
    at, other = touching((point, np.full(len(point), MOST_M)), (patches.center_m, patches.radius_m), ends_before)
    face, off = face_of[at], dot(point[at], normal[other]) - patches.offset_m[other]
    towards = normal[other] - np.vecdot(normal[other], normal[face])[:, None] * normal[face]
    reached = point.copy()
    np.subtract.at(reached, at, (off / np.vecdot(towards, towards))[:, None] * towards)
    return replace(patches, edge_m=reached.reshape(-1, 2, 3))


def _ends_before(patches: PlanarPatches, frame: Ints, point_m: Floats, face_of: Ints, at: Ints, other: Ints) -> Flags:
    """(K,) whether corners (K,), of all (N, 3) and of faces (N,), end just before other patches (K,) at an angle."""
    normal = patches.normal
    off = dot(point_m[at], normal[other]) - patches.offset_m[other]
    found = np.abs(off) < WIDEST_M
    some = np.flatnonzero(found)
    at, other, face, off = at[some], other[some], face_of[at[some]], off[some]
    before = dot(patches.center_m[face], normal[other]) - patches.offset_m[other]
    short = (
        (frame[patches.obstacle[face]] == frame[patches.obstacle[other]])
        & (off * before > off**2)
        & (np.abs(dot(normal[face], normal[other])) < ALIKE)
    )
    inwards = unit(patches.center_m[face] - point_m[at])
    foot = point_m[at] - off[:, None] * normal[other] + WIDEST_M * inwards
    sides = (foot + side * WIDEST_M * normal[face] for side in (-1.0, 1.0))
    found[some] = short & np.logical_or(*(_inside(patches, other, side) for side in sides))
    return np.asarray(found)


def _near(patches: PlanarPatches, owner: Ints, frame: Ints) -> tuple[Ints, Ints]:
    """Pairs of borders (K,) and (K,), each once, that come near one another and bound faces of one plane."""
    segment = np.flatnonzero(_may_crack(patches)[owner])
    seen = shapely.linestrings(patches.edge_m[segment] @ ASLANT.T)
    one, other = segment[shapely.STRtree(seen).query(seen, predicate="dwithin", distance=WIDEST_M)]
    one, other = one[one < other], other[one < other]
    first, second = owner[one], owner[other]
    cosine = dot(patches.normal[first], patches.normal[second])
    sheets = ~(patches.one_sided[first] | patches.one_sided[second])
    level = np.where(sheets, np.abs(cosine), cosine) > np.cos(COPLANAR_RAD)
    kept = level & (frame[patches.obstacle[first]] == frame[patches.obstacle[second]])
    return one[kept], other[kept]


def _may_crack(patches: PlanarPatches) -> Flags:
    """(P,) patches with another one beside them in their plane, or with room for a slit in their outline."""
    found: Flags = np.diff(patches.edge_start) > 4
    either_way = np.concatenate([patches.normal, -patches.normal])
    pair = cKDTree(either_way).query_pairs(COPLANAR_RAD, output_type="ndarray") % max(len(patches), 1)
    apart = patches.center_m[pair[:, 1]] - patches.center_m[pair[:, 0]]
    reach = patches.radius_m[pair].sum(axis=1) + WIDEST_M
    height = np.abs(dot(apart, patches.normal[pair[:, 0]]))
    beside = (height < WIDEST_M + COPLANAR_RAD * reach) & (norm(apart) < reach)
    found[pair[beside]] = True
    return found


def _facing(one: Floats, other: Floats) -> tuple[Floats, Floats, Ints]:
    """Stretches of two borders (K, 2, 3) each that run beside one another, (R, 2, 3) each, and their rows (R,)."""
    along, size = one[:, 1] - one[:, 0], norm(one[:, 1] - one[:, 0])
    along = along / size[:, None]
    place = np.einsum("kex,kx->ke", other - one[:, :1], along)
    rise = place[:, 1] - place[:, 0]
    low, high = np.maximum(place.min(axis=1), 0.0), np.minimum(place.max(axis=1), size)
    rows = np.flatnonzero((np.abs(rise) > ALIKE * norm(other[:, 1] - other[:, 0])) & (high - low > LEAST_M))
    ends = np.stack([low, high], axis=1)[rows]
    share = (ends - place[rows, :1]) / rise[rows, None]
    here = one[rows, :1] + ends[..., None] * along[rows, None]
    there = other[rows, :1] + share[..., None] * (other[rows, 1:] - other[rows, :1])
    return _narrow(here, there, rows)


def _narrow(here: Floats, there: Floats, rows: Ints) -> tuple[Floats, Floats, Ints]:
    """The part of stretches (R, 2, 3) that face one another where they are less than `WIDEST_M` apart."""
    apart = norm(there - here)
    least = apart.min(axis=1, keepdims=True)
    share = (WIDEST_M - least) / np.maximum(apart - least, 1e-300)  # of the way from the near end to the far one
    kept = (apart.max(axis=1) > LEAST_M) & (least[:, 0] < WIDEST_M)
    end = np.where(apart > WIDEST_M, share, 1.0)[..., None]
    cut = [side[:, ::-1] + end * (side - side[:, ::-1]) for side in (here, there)]
    return cut[0][kept], cut[1][kept], rows[kept]


def _inside(patches: PlanarPatches, patch: Ints, point_m: Floats) -> Flags:
    """(K,) whether points (K, 3) of the planes of patches (K,) lie in these, by the parity of crossings."""
    in_plane = np.argsort(np.abs(patches.normal[patch]), axis=1)[:, :2]
    return np.asarray(_crossed_oddly(patches.edge_m, patches.edge_start, patch, in_plane, point_m))  # type: ignore[call-arg]


@compiled
def _crossed_oddly(edge_m, edge_start, patch, in_plane, point_m):
    """(K,) whether rays from points along the first of two axes (K, 2) cross an odd number of a patch's segments."""
    odd = np.zeros(len(patch), np.bool_)
    for k in range(len(patch)):
        i, j = in_plane[k]
        for e in range(edge_start[patch[k]], edge_start[patch[k] + 1]):
            u0, v0 = edge_m[e, 0, i] - point_m[k, i], edge_m[e, 0, j] - point_m[k, j]
            u1, v1 = edge_m[e, 1, i] - point_m[k, i], edge_m[e, 1, j] - point_m[k, j]
            if (v0 > 0.0) != (v1 > 0.0) and u0 - v0 / (v1 - v0) * (u1 - u0) > 0.0:
                odd[k] = not odd[k]
    return odd
