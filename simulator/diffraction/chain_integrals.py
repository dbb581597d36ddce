"""Sound that two or more edges of a thin panel bend, by integrals over the edges, as paths with a delay each.

Every edge is shared between windows about its two ends and its middle (`edge_nodes`). The part of the integrals
(`edge_integrals`) that belongs to one window of each edge met is one path: through the corners of windows at ends, and
in the middle through the point that makes the path shortest. What turns faster than that cancels within the window, so
that the gains are smooth over frequency. Corners, on which several edges bend the sound at once, are included, and no
apex fades out anywhere. What four and five edges bend is looked for where it may be heard (`longer_chains`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from simulator.diffraction.chain_paths import (
    ChainPaths,
    candidates_over,
    face_factor,
    free_of_obstacles,
    rejected_paths,
)
from simulator.diffraction.chain_windows import Windowed, paths_of, windowed_chains
from simulator.diffraction.edge_integrals import Face, face_of, half_way, over_three, over_two
from simulator.diffraction.edge_nodes import nodes_of
from simulator.diffraction.edge_view import APEX, END, START
from simulator.diffraction.longer_chains import LONGEST, NEGLIGIBLE, Kept, Order, longer_chains
from simulator.diffraction.single import at_poses, bent_once, outside, seen
from simulator.diffraction.thin_panels import linked_edges
from simulator.surfaces.wedges import Wedges
from simulator.world.audible import Audible
from simulator.world.candidates import Candidates
from simulator.world.frames import into_rest
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing

LONGEST_RIM_M = 5.5  # the segments of a face then take 0.5 GB


@dataclass(frozen=True)
class Panel:
    """One panel and what is asked of it.

    Attributes:
        search: what all searches share.
        edge: (E,) the panel's wedges.
        chains: all that sound can meet.
        loudest: (N, 2) strongest echo of mirrors at each pose and microphone.
    """

    search: Search
    edge: Ints
    chains: Windowed
    loudest: Floats

    @cached_property
    def face(self) -> Face:
        """Nodes and segments, worked out when first asked for."""
        search, wedges = self.search, self.search.tracing.world.wedges[self.edge]
        nodes = nodes_of(wedges, search.air.sound_speed_m_s)
        return face_of(nodes, linked_edges(wedges), search.band_wavenumber_1_m)

    def paths(self, rows: Ints, pose: Ints, mic: Ints) -> ChainPaths:
        """Of chains (R,) at poses and microphones (R,)."""
        return paths_of(self.search.tracing, self.edge, self.chains[rows], pose, mic)


@dataclass(frozen=True)
class Heard:
    """All T chains at one pose and microphone.

    Attributes:
        pose, mic: which.
        pressure: (T, K) with the travel phase; 0 where not worked out.
        bound: (T,) greatest magnitude, or an estimate from above of what was not worked out.
        loud: (T,) what is kept.
        counts: (T,) False for chains of an order that cannot change what fewer edges add up to.
    """

    pose: int
    mic: int
    pressure: Complexes
    bound: Floats
    loud: Flags
    counts: Flags


def integrable(wedges: Wedges) -> bool:
    """Whether the edges of a panel are short enough for integrals over them."""
    return float(wedges.length_m.sum()) <= LONGEST_RIM_M


def integrated_chains(
    search: Search, panel: Ints, mirrored: Flags, longest: int, loudest: Floats
) -> tuple[Candidates, Complexes]:
    """ChainPaths over two to `longest` edges of one panel, at most five, without mirrors, as cells with their gains.

    Args:
        panel: its wedges.
        mirrored: (N, 2) poses and microphones that see the speaker's mirror image in the panel: chains of edges then
            move the matched filter's peak by less than 0.005 dB (plates of 0.2 to 0.9 m), and are left out.
        loudest: (N, 2) strongest echo of mirrors at each pose and microphone.
    """
    chains = windowed_chains(search.tracing.world.wedges[panel], min(longest, LONGEST))
    over = Panel(search, panel, chains, loudest)
    heard = _heard(search.tracing, panel, search.limit_m)
    _reject_mirrored(over, heard & mirrored)
    pose, mic, row = ([np.zeros(0, dtype=np.int64)] for _ in range(3))
    pressure = [np.zeros((0, len(search.band_hz)), dtype=np.complex128)]
    for n in np.flatnonzero((heard & ~mirrored).any(axis=1)):
        for found in _at_pose(over, int(n), np.flatnonzero(heard[n] & ~mirrored[n]), NEGLIGIBLE):
            loud = np.flatnonzero(found.loud)
            _reject_faint(over, found)
            pose.append(np.full(len(loud), found.pose))
            mic.append(np.full(len(loud), found.mic))
            row.append(loud)
            pressure.append(found.pressure[loud])
    paths = over.paths(np.concatenate(row), np.concatenate(pose), np.concatenate(mic))
    return _kept(over, paths, np.concatenate(pressure))


def _heard(tracing: Tracing, panel: Ints, limit_m: float) -> Flags:
    """(N, 2) whether a panel faces speaker and microphone, near enough."""
    poses = len(tracing.pose)
    pose, mic = (x.ravel() for x in np.meshgrid(np.arange(poses), [0, 1], indexing="ij"))
    source, receiver = tracing.source_m[pose], tracing.mics_m[pose, mic]
    facing, nearest = np.zeros(len(pose), dtype=bool), np.full(len(pose), np.inf)
    for wedge in panel:
        edge = at_poses(tracing, np.full(len(pose), wedge), pose)
        view = seen(edge, source, receiver)
        facing |= outside(edge, view)
        part = np.where(
            view.has(APEX),
            APEX,
            np.where(view.path_m(np.full(len(pose), START)) < view.path_m(np.full(len(pose), END)), START, END),
        )
        nearest = np.minimum(nearest, view.path_m(part))
    return (facing & (nearest <= limit_m)).reshape(poses, 2)


def _at_pose(over: Panel, pose: int, mics: Ints, negligible: float) -> list[Heard]:
    """All chains at some microphones of one pose, of orders that are worth more than a share of the lower ones."""
    tracing, face, longest = over.search.tracing, over.face, int(over.chains.count.max(initial=0))
    points = np.stack([tracing.source_m[pose], *tracing.mics_m[pose, mics]])
    frame = tracing.placed[[pose] * len(points), tracing.world.wedges.obstacle[over.edge[0]]]
    source, *receivers = into_rest(points, frame)
    windowed = [[over_two(face, source, each)] for each in receivers]
    if longest > 2:
        before, after = half_way(face, source), [half_way(face, each) for each in receivers]
        windowed = [[*sums, over_three(face, before, half)] for sums, half in zip(windowed, after, strict=True)]
    kept = [
        _loud_enough(over.search.audible, windowed[n], float(over.loudest[pose, mic])) for n, mic in enumerate(mics)
    ]
    longer: list[list[Order]] = [[] for _ in mics]
    if longest > 3:
        lower = [_wholes(over, pose, int(mic), sums) for mic, sums in zip(mics, windowed, strict=True)]
        longer = longer_chains(face, before, after, [sums[1] for sums in windowed], lower, kept, longest, negligible)
    return [_heard_chains(over.chains, pose, int(mic), windowed[n], longer[n], kept[n]) for n, mic in enumerate(mics)]


def _wholes(over: Panel, pose: int, mic: int, windowed: list[Complexes]) -> Complexes:
    """(3, K) all that one, two and three edges bend."""
    single = bent_once(over.search.tracing, over.edge, pose, mic, over.search.band_wavenumber_1_m)
    return np.stack([single, *(each.reshape(-1, len(single)).sum(axis=0) for each in windowed)])


def _loud_enough(audible: Audible, sums: list[Complexes], loudest: float) -> Kept:
    """Which magnitudes are kept beside the strongest mirror and the strongest of two or three edges."""
    strongest = max(loudest, *(float(np.abs(each).max()) for each in sums))
    return lambda magnitude: audible(magnitude, np.full_like(magnitude, strongest))


def _heard_chains(
    chains: Windowed, pose: int, mic: int, windowed: list[Complexes], longer: list[Order], kept: Kept
) -> Heard:
    pressure = [_of_windows(sums, chains, count) for count, sums in enumerate(windowed, start=2)]
    bound = [np.abs(each).max(axis=1, initial=0.0) for each in pressure]
    for count, order in enumerate(longer, start=4):
        some = chains[np.flatnonzero(chains.count == count)]
        first, last = some.ends()
        beside = some.edge[:, 3] if count > 4 else np.zeros(len(some), dtype=np.int64)
        pressure.append(order.pressure[first, some.edge[:, 1], some.edge[:, 2], last, beside])
        own = np.abs(pressure[-1]).max(axis=1, initial=0.0)
        bound.append(np.where(order.known[first, last], own, order.bound[first, last]))
    every = np.concatenate(bound)
    counts = np.ones(len(chains), dtype=bool)
    for count, order in enumerate(longer, start=4):
        counts[chains.count == count] = order.counts
    return Heard(pose, mic, np.concatenate(pressure), every, kept(every) & counts, counts)


def _of_windows(sums: Complexes, chains: Windowed, count: int) -> Complexes:
    """(R, K) of (E, W, ..., E, W, K) for the chains of so many edges."""
    some = chains[np.flatnonzero(chains.count == count)]
    return sums[tuple(part[:, slot] for slot in range(count) for part in (some.edge, some.part))]


def _reject_faint(over: Panel, found: Heard) -> None:
    """Book what is faint by itself, and the orders that fewer edges drown."""
    masks = {Reason.FAINT_CHAIN: found.counts & ~found.loud, Reason.DROWNED_BY_FEWER_EDGES: ~found.counts}
    for reason, chosen in masks.items():
        row = np.flatnonzero(chosen)
        pose, mic = (np.full(len(row), each) for each in (found.pose, found.mic))
        over.search.reject(reason, len(row), partial(_rejected, over, row, pose, mic, found.bound[row]))


def _reject_mirrored(over: Panel, where: Flags) -> None:
    """Book every chain at poses and microphones (N, 2); how loud they are is only worked out for who asks."""

    def described() -> Rejected:
        rows = [(int(n), np.flatnonzero(where[n])) for n in np.flatnonzero(where.any(axis=1))]
        found = [each for n, mics in rows for each in _at_pose(over, n, mics, 0.0)]
        pose, mic = (np.repeat([getattr(each, name) for each in found], len(over.chains)) for name in ("pose", "mic"))
        row, bound = np.tile(np.arange(len(over.chains)), len(found)), np.concatenate([each.bound for each in found])
        return _rejected(over, row, pose, mic, bound)

    over.search.reject(Reason.DROWNED_BY_MIRROR, int(where.sum()) * len(over.chains), described)


def _rejected(over: Panel, row: Ints, pose: Ints, mic: Ints, bound: Floats) -> Rejected:
    return Rejected(bound, lambda some: candidates_over(over.search, over.paths(row[some], pose[some], mic[some])))


def _kept(over: Panel, paths: ChainPaths, pressure: Complexes) -> tuple[Candidates, Complexes]:
    """Candidates of the paths that nothing hides, and their gains without the phase of their lengths."""
    search, tracing, length = over.search, over.search.tracing, paths.segments_m.sum(axis=1)
    near = length <= search.limit_m
    free = near.copy()
    free[near] = free_of_obstacles(tracing, paths[near])
    hidden, rows = np.flatnonzero(near & ~free), np.flatnonzero(free)
    bound = np.abs(pressure).max(axis=1, initial=0.0)
    search.reject(Reason.HIDDEN, len(hidden), partial(rejected_paths, search, paths[hidden], bound[hidden]))
    gain = pressure[rows] * np.exp(1j * length[rows, None] * search.band_wavenumber_1_m)
    return candidates_over(search, paths[rows]), gain * face_factor(tracing, paths[rows], search.band_hz)
