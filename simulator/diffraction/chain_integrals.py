"""Sound that two or more edges of a thin panel diffract, by integrals over the edges, as paths with a delay each.

Every edge is shared between windows about its two ends and its middle (`edge_nodes`). The part of the integrals
(`edge_integrals`) that belongs to one window of each edge met is one path: through the corners of windows at ends, and
in the middle through the point that makes the path shortest. What oscillates faster than that cancels within the
window, so that the gains are smooth over frequency. Corners, at which several edges diffract at once, are included.
Four and five edges are followed where they may be audible (`longer_chains`).

Nothing is integrated where chains cannot matter: at poses and microphones with a mirror image in the panel, where
Kirchhoff's integral takes care of the obstacle, and where no chain can be loud enough (`chain_bounds`), beside other
echoes or the noise. A third edge is followed where it may be.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from simulator.diffraction.chain_bounds import chain_bounds
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
from simulator.diffraction.edge_view import APEX, END, START, at_poses, seen
from simulator.diffraction.longer_chains import LONGEST, NEGLIGIBLE, Kept, Order, longer_chains
from simulator.diffraction.single import diffracted_once, outside
from simulator.diffraction.thin_panels import linked_edges
from simulator.waves import band
from simulator.world.audible import Audible
from simulator.world.candidates import Candidates
from simulator.world.frames import into_rest
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search

LONGEST_RIM_M = 5.5  # the segments of a face then take 0.3 GB
FREQUENCIES = 6  # that carry the gains: to 2e-3 of what is left of all orders edge-on, better elsewhere
TOGETHER = 2.0
"""Times the bound of chains, or the loudest window of two edges, is about what windows of the same two or three edges
add up to at most: 2.2 times the bound and 1.9 times the window on 150 random plates, most of them near edge-on."""


@dataclass(frozen=True)
class Panel:
    """One panel and what is asked of it.

    Attributes:
        search: what all searches share.
        edge: (E,) the panel's wedges.
        longest: most edges that a chain meets.
        loudest: (N, 2) strongest echo of mirrors at each pose and microphone.
    """

    search: Search
    edge: Ints
    longest: int
    loudest: Floats

    @cached_property
    def audible(self) -> Audible:
        """What chains together must reach, beside other echoes and over the noise."""
        return replace(self.search.audible, least=self.search.lost_in_noise / TOGETHER)

    @cached_property
    def chains(self) -> Windowed:
        """All that sound can meet."""
        return windowed_chains(self.search.tracing.world.wedges[self.edge], self.longest)

    @cached_property
    def wavenumber(self) -> Floats:
        """(F,) at which the integrals are evaluated, rad/m."""
        count = min(FREQUENCIES, self.search.fidelity.band_points)
        return self.search.wavenumbers_1_m(band.nodes_hz(count))

    @cached_property
    def face(self) -> Face:
        """Nodes and segments, worked out when first asked for."""
        wedges = self.search.tracing.world.wedges[self.edge]
        nodes = nodes_of(wedges, self.search.air.sound_speed_m_s)
        return face_of(nodes, linked_edges(wedges), self.wavenumber)

    def paths(self, rows: Ints, pose: Ints, mic: Ints) -> ChainPaths:
        """Of chains (R,) at poses and microphones (R,)."""
        return paths_of(self.search.tracing, self.edge, self.chains[rows], pose, mic)


@dataclass(frozen=True)
class Found:
    """All T chains at one pose and microphone.

    Attributes:
        pose, mic: which.
        pressure: (T, F) with the travel phase; 0 where not worked out.
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


def integrated_chains(
    search: Search, panel: Ints, mirrored: Flags, taken: Flags, longest: int, loudest: Floats
) -> tuple[Candidates, Complexes]:
    """Paths over two to `longest` edges of one panel, at most five, without mirrors, as cells with their gains.

    Args:
        panel: its wedges.
        mirrored: (N, 2) poses and microphones that see the speaker's mirror image in the panel: chains of edges then
            move the matched filter's peak by less than 0.005 dB (plates of 0.2 to 0.9 m), and are left out.
        taken: (N, 2) where Kirchhoff's integral takes care of the panel.
        loudest: (N, 2) strongest echo of mirrors at each pose and microphone.
    """
    over = Panel(search, panel, min(longest, LONGEST), loudest)
    wanted = _wanted(over, mirrored, taken)
    pose, mic, row = ([np.zeros(0, dtype=np.int64)] for _ in range(3))
    pressure = [np.zeros((0, len(over.wavenumber)), dtype=np.complex128)]
    for n in np.flatnonzero(wanted.any(axis=1)):
        for found in _at_pose(over, int(n), np.flatnonzero(wanted[n]), NEGLIGIBLE):
            loud = np.flatnonzero(found.loud)
            _reject_faint(over, found)
            pose.append(np.full(len(loud), found.pose))
            mic.append(np.full(len(loud), found.mic))
            row.append(loud)
            pressure.append(found.pressure[loud])
    paths = over.paths(np.concatenate(row), np.concatenate(pose), np.concatenate(mic))
    return _kept(over, paths, np.concatenate(pressure))


def _wanted(over: Panel, mirrored: Flags, taken: Flags) -> Flags:
    """(N, 2) where chains are integrated; where they are not, the log books them with the reason."""
    wanted = _reached(over.search, over.edge)
    bound = _bound(over, wanted & ~taken & ~mirrored)
    rim_m = float(over.search.tracing.world.wedges[over.edge].length_m.sum())
    for reason, where, described in (
        (Reason.LEFT_TO_INTEGRAL, taken, _bounds),
        (Reason.DROWNED_BY_MIRROR, mirrored, _levels if rim_m <= LONGEST_RIM_M else _bounds),
        (Reason.FAINT_CHAIN, ~over.audible(bound, np.maximum(over.loudest, bound)), _bounds),
        (Reason.LARGE_PANEL, np.full_like(wanted, rim_m > LONGEST_RIM_M), _bounds),
    ):
        _reject_all(over, reason, wanted & where, described)
        wanted = wanted & ~where
    return wanted


def _reached(search: Search, panel: Ints) -> Flags:
    """(N, 2) whether a panel faces speaker and microphone, near enough."""
    tracing = search.tracing
    pose, mic = np.divmod(np.arange(2 * len(tracing.pose)), 2)
    source, receiver = tracing.source_m[pose], tracing.mics_m[pose, mic]
    reached = np.zeros(len(pose), dtype=bool)
    for wedge in panel:
        edge = at_poses(tracing, np.full(len(pose), wedge), pose)
        view = seen(edge, source, receiver)
        for part in (APEX, START, END):
            near = view.path_m(np.full(len(view), part)) <= search.limit_m
            reached |= outside(view, edge.sheet_m) & view.has(part) & near
    return reached.reshape(-1, 2)


def _bound(over: Panel, wanted: Flags) -> Floats:
    """(N, 2) what no chain is louder than where it is wanted, 0 elsewhere."""
    tracing, wedges = over.search.tracing, over.search.tracing.world.wedges[over.edge]
    pose, mic = np.nonzero(wanted)
    frame = tracing.placed[pose, wedges.obstacle[0]]
    source, receiver = into_rest(tracing.source_m[pose], frame), into_rest(tracing.mics_m[pose, mic], frame)
    out = np.zeros(wanted.shape)
    out[wanted] = chain_bounds(wedges, linked_edges(wedges), source, receiver, over.search.wavenumber_1_m)
    return out


def _at_pose(over: Panel, pose: int, mics: Ints, negligible: float) -> list[Found]:
    """All chains at some microphones of one pose.

    A third edge is followed where chains of two are audible and not lost in the noise, further ones where an order is
    worth more than a `negligible` share of the lower ones; 0 follows all.
    """
    tracing = over.search.tracing
    points = np.stack([tracing.source_m[pose], *tracing.mics_m[pose, mics]])
    frame = tracing.placed[[pose] * len(points), tracing.world.wedges.obstacle[over.edge[0]]]
    source, *receivers = into_rest(points, frame)
    second = [over_two(over.face, source, each) for each in receivers]
    kept = [
        _loud_enough(over.search.audible, two, float(over.loudest[pose, mic]))
        for two, mic in zip(second, mics, strict=True)
    ]
    top = np.array([np.abs(two).max() for two in second])
    loud = over.audible(top, np.maximum(over.loudest[pose, mics], top))
    on = [n for n in range(len(mics)) if over.longest > 2 and (negligible == 0.0 or loud[n])]
    out = [_of_two(over, pose, int(mic), two, keep) for mic, two, keep in zip(mics, second, kept, strict=True)]
    if on:
        ends = np.stack([source, *(receivers[n] for n in on)])
        more = _of_more(over, pose, mics[on], ends, [second[n] for n in on], [kept[n] for n in on], negligible)
        for n, found in zip(on, more, strict=True):
            out[n] = found
    return out


def _of_two(over: Panel, pose: int, mic: int, second: Complexes, kept: Kept) -> Found:
    """Chains of two edges; what meets more of them is no louder."""
    chains = over.chains
    own = _of_windows(second, chains, 2)
    pressure = np.zeros((len(chains), second.shape[-1]), dtype=np.complex128)
    pressure[: len(own)] = own  # chains are sorted by their number of edges
    bound = np.full(len(chains), np.abs(second).max())
    bound[: len(own)] = np.abs(own).max(axis=1, initial=0.0)
    loud = kept(bound) & (chains.count == 2)
    return Found(pose, mic, pressure, bound, loud, np.ones(len(chains), dtype=bool))


def _of_more(
    over: Panel, pose: int, mics: Ints, ends_m: Floats, second: list[Complexes], kept: list[Kept], negligible: float
) -> list[Found]:
    """All chains at the microphones of one pose where a third edge may be audible; ends at rest, speaker first."""
    face, longest = over.face, over.longest
    before, *after = half_way(face, ends_m)
    windowed = [[two, over_three(face, before, half)] for two, half in zip(second, after, strict=True)]
    longer: list[list[Order]] = [[] for _ in mics]
    if longest > 3:
        lower = [_order_sums(over, pose, int(mic), sums) for mic, sums in zip(mics, windowed, strict=True)]
        longer = longer_chains(face, before, after, [sums[1] for sums in windowed], lower, kept, longest, negligible)
    return [_found(over.chains, pose, int(mic), windowed[n], longer[n], kept[n]) for n, mic in enumerate(mics)]


def _order_sums(over: Panel, pose: int, mic: int, windowed: list[Complexes]) -> Complexes:
    """(3, F) all that one, two and three edges diffract."""
    single = diffracted_once(over.search.tracing, over.edge, pose, mic, over.wavenumber)
    return np.stack([single, *(each.reshape(-1, len(single)).sum(axis=0) for each in windowed)])


def _loud_enough(audible: Audible, second: Complexes, loudest: float) -> Kept:
    """Which magnitudes are kept beside the strongest mirror and the strongest of two edges."""
    strongest = max(loudest, float(np.abs(second).max()))
    return lambda magnitude: audible(magnitude, np.full_like(magnitude, strongest))


def _found(chains: Windowed, pose: int, mic: int, windowed: list[Complexes], longer: list[Order], kept: Kept) -> Found:
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
    return Found(pose, mic, np.concatenate(pressure), every, kept(every) & counts, counts)


def _of_windows(sums: Complexes, chains: Windowed, count: int) -> Complexes:
    """(R, F) of (E, W, ..., E, W, F) for the chains of so many edges."""
    some = chains[np.flatnonzero(chains.count == count)]
    return sums[tuple(part[:, slot] for slot in range(count) for part in (some.edge, some.part))]


def _reject_faint(over: Panel, found: Found) -> None:
    """Book what is faint by itself, and the orders that fewer edges drown."""
    masks = {Reason.FAINT_CHAIN: found.counts & ~found.loud, Reason.DROWNED_BY_FEWER_EDGES: ~found.counts}
    for reason, chosen in masks.items():
        row = np.flatnonzero(chosen)
        pose, mic = (np.full(len(row), each) for each in (found.pose, found.mic))
        over.search.reject(reason, len(row), partial(_rejected, over, row, pose, mic, found.bound[row]))


def _reject_all(over: Panel, reason: Reason, where: Flags, described: Callable[[Panel, Flags], Rejected]) -> None:
    """Book every chain at poses and microphones (N, 2)."""
    if where.any():
        over.search.reject(reason, int(where.sum()) * len(over.chains), partial(described, over, where))


def _levels(over: Panel, where: Flags) -> Rejected:
    """Every chain at poses and microphones (N, 2), at its own level: integrated only for who asks."""
    rows = [(int(n), np.flatnonzero(where[n])) for n in np.flatnonzero(where.any(axis=1))]
    found = [each for n, mics in rows for each in _at_pose(over, n, mics, 0.0)]
    pose, mic = (np.repeat([getattr(each, name) for each in found], len(over.chains)) for name in ("pose", "mic"))
    row, bound = np.tile(np.arange(len(over.chains)), len(found)), np.concatenate([each.bound for each in found])
    return _rejected(over, row, pose, mic, bound)


def _bounds(over: Panel, where: Flags) -> Rejected:
    """The same, all at the level that none of them exceeds."""
    pose, mic = (np.repeat(each, len(over.chains)) for each in np.nonzero(where))
    row = np.tile(np.arange(len(over.chains)), int(where.sum()))
    return _rejected(over, row, pose, mic, _bound(over, where)[pose, mic])


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
    smooth = band.coefficients(pressure[rows] * np.exp(1j * length[rows, None] * over.wavenumber))
    gain = band.evaluate(smooth, search.band_hz)
    return candidates_over(search, paths[rows]), gain * face_factor(tracing, paths[rows], search.band_hz)
