"""Paths over an obstacle summed over its surface: an image of the speaker, the obstacle, an image of a microphone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.images.image_tree import Images, image_pairs, images_lighting
from simulator.world.candidates import Candidates
from simulator.world.interactions import Interaction
from simulator.world.search_context import Search
from simulator.world.world import Tracing


@dataclass(frozen=True)
class Pairs:
    """R pairs of images over one obstacle.

    Attributes:
        obstacle: its index.
        mic: (R,) microphone at which they end.
        before, after: images of speaker and microphone, aligned.
    """

    obstacle: int
    mic: Ints
    before: Images
    after: Images

    def __len__(self) -> int:
        return len(self.mic)

    def __getitem__(self, index: NDArray) -> Pairs:
        rows = np.flatnonzero(index) if index.dtype == bool else index
        return Pairs(self.obstacle, self.mic[rows], self.before[rows], self.after[rows])

    @property
    def pose(self) -> Ints:
        """(R,)."""
        return self.before.pose


@dataclass(frozen=True)
class _Ball:
    obstacle: int
    center_m: Floats
    radius_m: float


def pairs_over(search: Search, obstacle: int) -> Pairs:
    """All pairs over an obstacle with mirrors of others before and after it."""
    tracing = search.tracing
    ball = _bounds(tracing, obstacle)
    lit = _images(search, ball, tracing.source_m)
    mics, before, after = [], [], []
    for mic in range(2):
        received = _images(search, ball, tracing.mics_m[:, mic])
        left, right = image_pairs(search, ball, search.scatter_order, lit, received)
        mics.append(np.full(len(left), mic))
        before.append(lit[left])
        after.append(received[right])
    return Pairs(obstacle, np.concatenate(mics), _joined(before), _joined(after))


def swapped_too(pairs: Pairs, chosen: Flags) -> Flags:
    """(R,) the chosen pairs and those with the same mirrors in reverse."""
    sequences = np.concatenate([pairs.before.sequence, pairs.after.sequence])
    number = np.unique(sequences, axis=0, return_inverse=True)[1].reshape(2, -1)
    key = np.column_stack([pairs.pose, pairs.mic, number.min(axis=0), number.max(axis=0)])
    group = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    any_chosen = np.zeros(group.max(initial=-1) + 1, dtype=bool)
    np.logical_or.at(any_chosen, group, chosen)
    return any_chosen[group]


def sequences_of(tracing: Tracing, pairs: Pairs, width: int) -> Ints:
    """(R, 2 + width) pose, microphone and the reflectors met in order, -1 padded."""
    sequence = np.full((len(pairs), width), -1)
    each, place, late_order = np.arange(len(pairs)), pairs.before.order, pairs.after.order
    for k in range(pairs.before.sequence.shape[1]):
        early, late = np.flatnonzero(place > k), np.flatnonzero(late_order > k)
        sequence[early, k] = pairs.before.sequence[early, k]
        sequence[late, place[late] + late_order[late] - k] = pairs.after.sequence[late, k]
    sequence[each, place] = tracing.world.numbering.number(Interaction.KIRCHHOFF, pairs.obstacle)
    return np.column_stack([pairs.pose, pairs.mic, sequence])


def run_over(tracing: Tracing, found: Candidates, chosen: list[Pairs]) -> Flags:
    """(C,) candidates that are rays, by any mechanism, over one of the chosen pairs."""
    if not chosen or not len(found):
        return np.zeros(len(found), dtype=bool)
    rays, numbers = _numbered(tracing, found, chosen)
    return np.isin(rays, numbers)


def loudest_over(tracing: Tracing, found: Candidates, amplitude: Floats, pairs: Pairs) -> Floats:
    """(R,) greatest amplitude (C,) of the candidates that run over each pair; 0 without one."""
    rays, numbers = _numbered(tracing, found, [pairs])
    loudest = np.zeros(max(rays.max(initial=0), numbers.max(initial=0)) + 1)
    np.maximum.at(loudest, rays, amplitude)
    return loudest[numbers]


def _numbered(tracing: Tracing, found: Candidates, chosen: list[Pairs]) -> tuple[Ints, Ints]:
    """(C,) and (R,) numbers of the images that candidates and pairs run over; equal ones have equal numbers."""
    world, width = tracing.world, found.sequence.shape[1]
    body = np.full(len(world.obstacles) + 1, -1)
    bodies = [pairs.obstacle for pairs in chosen]
    body[bodies] = world.numbering.number(Interaction.KIRCHHOFF, bodies)
    as_body = body[world.obstacle_of(found.sequence)]
    path = np.column_stack([found.pose, found.mic, np.where(as_body >= 0, as_body, found.sequence)])
    every = np.concatenate([path] + [sequences_of(tracing, pairs, width) for pairs in chosen])
    number = np.unique(every, axis=0, return_inverse=True)[1].ravel()
    return number[: len(found)], number[len(found) :]


def _bounds(tracing: Tracing, obstacle: int) -> _Ball:
    vertices = np.asarray(tracing.world.skins[obstacle][0].mesh.vertices)
    center = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return _Ball(obstacle, center, float(np.linalg.norm(vertices - center, axis=1).max()))


def _images(search: Search, ball: _Ball, point_m: Floats) -> Images:
    """Images of a point that may light the obstacle, none of them in its own planes."""
    tracing = search.tracing
    images = images_lighting(search, ball, point_m, search.scatter_order - 1)
    own = np.append(tracing.world.patches.obstacle == ball.obstacle, False)[images.sequence].any(axis=1)
    return images[np.flatnonzero(~own)]


def _joined(parts: list[Images]) -> Images:
    return Images(*(np.concatenate([getattr(p, name) for p in parts]) for name in Images.__dataclass_fields__))
