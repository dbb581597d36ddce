"""Paths that geometry allows, before anything stands in their way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulator import curved, specular
from simulator.frames import Frames, into_rest, out_of_rest, turned, turned_tensor
from simulator.reflectors import SmoothSurface
from simulator.world import World

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Candidates:
    """Geometrically possible paths, world frame.

    Attributes:
        pose, mic, order: (C,).
        sequence: (C, N) reflectors met, -1 padded; patch indices, then `patches + surface`.
        points_m: (C, N + 2, 3) source, reflection points, receiver (repeated to the end of the row).
        normal: (C, N, 3) unit normals on the incident side.
        curvature: (C, N, 3, 3) curvature tensors, 0 for planes.
        lift_m: (C, N) how far the true surface may stand off its mesh there.
        face, uv: (C,), (C, 2) place on the smooth surface; -1 without one.
    """

    pose: Ints
    mic: Ints
    order: Ints
    sequence: Ints
    points_m: Floats
    normal: Floats
    curvature: Floats
    lift_m: Floats
    face: Ints
    uv: Floats

    def __len__(self) -> int:
        return len(self.pose)

    def __getitem__(self, index: NDArray) -> Candidates:
        return Candidates(*(getattr(self, name)[index] for name in self.__dataclass_fields__))

    @property
    def length_m(self) -> Floats:
        """(C,) whole path."""
        return np.linalg.norm(np.diff(self.points_m, axis=1), axis=2).sum(axis=1)


def joined(parts: list[Candidates]) -> Candidates:
    """All parts, sorted by pose, microphone, order and sequence: the order in which they are summed."""
    whole = Candidates(*(np.concatenate([getattr(p, name) for p in parts]) for name in Candidates.__dataclass_fields__))
    keys = tuple(whole.sequence.T[::-1]) + (whole.order, whole.mic, whole.pose)
    return whole[np.lexsort((whole.face, *keys))]


def direct(source_m: Floats, mics_m: Floats, width: int) -> Candidates:
    """The straight way from speaker to microphones."""
    pose, mic = np.divmod(np.arange(2 * len(source_m)), 2)
    return _candidates(pose, mic, source_m, mics_m, np.full((len(pose), width), -1), np.zeros((len(pose), width, 3)))


def planar(
    world: World,
    frames: Floats,
    source_m: Floats,
    mics_m: Floats,
    max_order: int,
    limit_m: float,
    rejected: dict[str, int],
) -> Candidates:
    """Image sources in planar patches, up to `max_order`."""
    where, sequence, hits, counts = specular.planar_paths(
        source_m, mics_m, frames, *specular.arrays(world.patches), world.follows, max_order, limit_m
    )
    rejected["behind a patch"] = int(counts[specular.BEHIND])
    rejected["outside its patch"] = int(counts[specular.OUTSIDE])
    found = _candidates(where[:, 0], where[:, 1], source_m, mics_m, sequence, hits)
    return _with_plane_normals(world, frames, found)


def smooth(
    world: World, index: int, frames: Floats, moving: Frames, time_s: Floats,
    source_m: Floats, mics_m: Floats, max_order: int, limit_m: float, rejected: dict[str, int],
) -> Candidates:  # fmt: skip
    """One reflection off smooth surface `index`, with mirrors before and after it, up to `max_order` in all."""
    surface = world.surfaces[index]
    every = np.arange(len(source_m))
    obstacle = np.full(len(source_m), surface.obstacle)
    goal = out_of_rest(np.broadcast_to(surface.center_m, source_m.shape), moving.of(obstacle, every, time_s))
    images = [
        _images(world, frames, point, goal, surface, max_order - 1, limit_m)
        for point in (source_m, mics_m[:, 0], mics_m[:, 1])
    ]
    parts = [_mirrored_pair(images[0], images[1 + mic], mic, max_order) for mic in range(2)]
    pair = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    frame = frames[pair["pose"], surface.obstacle]
    hit = curved.find(surface, into_rest(pair["source"], frame), into_rest(pair["receiver"], frame))
    if len(hit) == 0:
        return _candidates(*(np.zeros(0, np.int64),) * 2, source_m, mics_m, np.zeros((0, max_order), np.int64))
    return _unfolded(world, index, frames, source_m, mics_m, pair, hit, max_order, rejected)


def _images(
    world: World, frames: Floats, point: Floats, goal: Floats, surface: SmoothSurface, max_order: int, limit_m: float
) -> tuple[Ints, Ints, Ints, Floats]:
    return specular.images_towards(
        np.ascontiguousarray(point), frames, *specular.arrays(world.patches), world.follows, max_order, limit_m,
        np.ascontiguousarray(goal), surface.radius_m, surface.obstacle,
    )  # fmt: skip


def _mirrored_pair(before: tuple, after: tuple, mic: int, max_order: int) -> dict[str, NDArray]:
    """Every image of the source with every image of the microphone at the same pose, within the order."""
    first, count = np.searchsorted(after[0], before[0], "left"), np.bincount(after[0], minlength=before[0].max() + 1)
    repeat = count[before[0]]
    left = np.repeat(np.arange(len(before[0])), repeat)
    right = first[left] + np.arange(len(left)) - np.repeat(np.cumsum(repeat) - repeat, repeat)
    keep = before[1][left] + after[1][right] + 1 <= max_order
    left, right = left[keep], right[keep]
    return {
        "pose": before[0][left], "mic": np.full(len(left), mic),
        "order_before": before[1][left], "order_after": after[1][right],
        "before": before[2][left], "after": after[2][right],
        "source": before[3][left], "receiver": after[3][right],
    }  # fmt: skip


def _unfolded(
    world: World, index: int, frames: Floats, source_m: Floats, mics_m: Floats,
    pair: dict[str, NDArray], hit: curved.StationaryPoints, width: int, rejected: dict[str, int],
) -> Candidates:  # fmt: skip
    """Candidates from stationary points: the mirrors before and after are crossed inside their patches."""
    row = {name: values[hit.query] for name, values in pair.items()}
    surface = world.surfaces[index]
    frame = frames[row["pose"], surface.obstacle]
    point = out_of_rest(hit.point_m, frame)
    normal, curvature = turned(hit.normal, frame[:, 3]), turned_tensor(hit.curvature, frame[:, 3])
    patches = specular.arrays(world.patches)
    code_before, hits_before = specular.crossings(
        source_m[row["pose"]], point, frames, row["pose"], row["order_before"], row["before"], *patches
    )
    code_after, hits_after = specular.crossings(
        mics_m[row["pose"], row["mic"]], point, frames, row["pose"], row["order_after"], row["after"], *patches
    )
    for name, code in (("behind a patch", specular.BEHIND), ("outside its patch", specular.OUTSIDE)):
        rejected[name] = rejected.get(name, 0) + int(((code_before == code) | (code_after == code)).sum())
    ok = np.flatnonzero((code_before == specular.REACHED) & (code_after == specular.REACHED))
    sequence, hits = np.full((len(ok), width), -1), np.zeros((len(ok), width, 3))
    place = row["order_before"][ok]
    for k in range(width):
        mirror = place > k
        if row["before"].shape[1] > k:
            sequence[mirror, k] = row["before"][ok[mirror], k]
            hits[mirror, k] = hits_before[ok[mirror], k]
        back = row["order_after"][ok] - 1 - (k - place - 1)  # mirrors after are met in reverse
        mirror = (k > place) & (back >= 0)
        sequence[mirror, k] = row["after"][ok[mirror], back[mirror]]
        hits[mirror, k] = hits_after[ok[mirror], back[mirror]]
    each = np.arange(len(ok))
    sequence[each, place], hits[each, place] = len(world.patches) + index, point[ok]
    found = _candidates(row["pose"][ok], row["mic"][ok], source_m, mics_m, sequence, hits)
    found = _with_plane_normals(world, frames, found)
    found.normal[each, place], found.curvature[each, place] = normal[ok], curvature[ok]
    found.lift_m[each, place] = 2.0 * surface.sag_m[hit.face[ok]]
    found.face[:], found.uv[:] = hit.face[ok], hit.uv[ok]
    return found


def _candidates(
    pose: Ints, mic: Ints, source_m: Floats, mics_m: Floats, sequence: Ints, hits: Floats | None = None
) -> Candidates:
    """Candidates without normals from sequences and reflection points."""
    count, width = sequence.shape
    order = (sequence >= 0).sum(axis=1)
    receiver = mics_m[pose, mic]
    points = np.repeat(receiver[:, None], width + 2, axis=1)
    points[:, 0] = source_m[pose]
    for k in range(width):
        reflects = order > k
        if hits is not None:
            points[reflects, 1 + k] = hits[reflects, k]
    return Candidates(
        pose, mic, order, sequence, points, np.zeros((count, width, 3)), np.zeros((count, width, 3, 3)),
        np.zeros((count, width)), np.full(count, -1), np.zeros((count, 2)),
    )  # fmt: skip


def _with_plane_normals(world: World, frames: Floats, found: Candidates) -> Candidates:
    """Fill in the normals of the planar reflections, turned to the incident side."""
    patches = world.patches
    for k in range(found.sequence.shape[1]):
        flat = np.flatnonzero((found.sequence[:, k] >= 0) & (found.sequence[:, k] < len(patches)))
        patch = found.sequence[flat, k]
        normal = turned(patches.normal[patch], frames[found.pose[flat], patches.obstacle[patch], 3])
        arriving = np.sum(normal * (found.points_m[flat, k + 1] - found.points_m[flat, k]), axis=1)
        found.normal[flat, k] = np.where(arriving > 0.0, -1.0, 1.0)[:, None] * normal
    return found
