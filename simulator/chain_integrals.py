"""Sound that two or three edges of a thin panel bend, by integrals over the edges, as ways with a delay each.

Every edge is shared between windows about its two ends and its middle (`edge_nodes`). The part of the integrals
(`edge_integrals`) that belongs to one window of each edge met is one way: through the corners of windows at ends, and
in the middle through the point that makes the way shortest. What turns faster than that cancels within the window, so
that the gains are smooth over frequency. Corners, on which several edges bend the sound at once, are included, and no
apex fades out anywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from simulator.candidates import Candidates
from simulator.chain_ways import Ways, candidates_over, face_factor, free_of_obstacles, turned_ways
from simulator.diffracted import at_poses, outside, seen
from simulator.edge_integrals import Face, face_of, half_way, over_three, over_two
from simulator.edge_nodes import nodes_of
from simulator.edge_view import APEX, END, START
from simulator.floor import Audible
from simulator.frames import into_rest
from simulator.ledger import Ledger, Turned
from simulator.panels import LONGEST, Chains, linked_edges
from simulator.wedges import Wedges
from simulator.world import Tracing

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Complexes = NDArray[np.complex128]

LONGEST_RIM_M = 5.5  # the legs of a face then take 0.5 GB
ROUNDS = 32  # over the middles of a way, each put where its neighbours make the way shortest
PARTS = (APEX, START, END)


@dataclass(frozen=True)
class Windowed:
    """T chains of edges of one panel, each met in one of its windows.

    Attributes:
        edge: (T, LONGEST) numbers among the panel's edges, -1 padded.
        part: (T, LONGEST) APEX for the middle, START or END.
    """

    edge: Ints
    part: Ints

    def __getitem__(self, index: Ints) -> Windowed:
        return Windowed(self.edge[index], self.part[index])

    @property
    def count(self) -> Ints:
        """(T,) edges met."""
        return (self.edge >= 0).sum(axis=1)


def integrable(wedges: Wedges) -> bool:
    """Whether the edges of a panel are short enough for integrals over them."""
    return float(wedges.length_m.sum()) <= LONGEST_RIM_M


def integrated_chains(
    tracing: Tracing, panel: Ints, mirrored: NDArray[np.bool_], longest: int, width: int, audible: Audible,
    loudest: Floats, frequency_hz: Floats, speed_m_s: float, ledger: Ledger,
) -> tuple[Candidates, Complexes]:  # fmt: skip
    """Ways over two to `longest` edges of one panel, at most three, without mirrors, as cells with their gains.

    Args:
        panel: its wedges.
        mirrored: (N, 2) poses and microphones that see the speaker's mirror image in the panel: chains of edges then
            move the matched filter's peak by less than 0.005 dB (plates of 0.2 to 0.9 m), and are left out.
        width: reflections kept for each path.
        audible: what is kept beside the strongest echo.
        loudest: (N, 2) strongest echo of mirrors at each pose and microphone.
        frequency_hz: (K,) nodes of the band.
        ledger: of what is turned away.
    """
    wedges, wavenumber = tracing.world.wedges[panel], 2.0 * np.pi * frequency_hz / speed_m_s
    table = _table(wedges, longest)
    heard = _heard(tracing, panel, audible.limit_m) & ~mirrored
    pose, mic, entry = ([np.zeros(0, dtype=np.int64)] for _ in range(3))
    pressure = [np.zeros((0, len(wavenumber)), dtype=np.complex128)]
    if heard.any():
        face = face_of(nodes_of(wedges, speed_m_s), linked_edges(wedges), wavenumber)
    for n in np.flatnonzero(heard.any(axis=1)):
        ends = into_rest(
            np.stack([tracing.source_m[n], *tracing.mics_m[n]]), tracing.placed[[n] * 3, wedges.obstacle[0]]
        )
        for m, spectra in _spectra(face, table, ends, heard[n]):
            bound = np.abs(spectra).max(axis=1)
            loud = np.flatnonzero(audible(bound, np.maximum(bound.max(), loudest[n, m])))
            faint = np.flatnonzero(~np.isin(np.arange(len(bound)), loud))
            _turn_faint_away(tracing, panel, table[faint], int(n), m, bound[faint], width, ledger)
            pose.append(np.full(len(loud), n))
            mic.append(np.full(len(loud), m))
            entry.append(loud)
            pressure.append(spectra[loud])
    ways = _placed(tracing, panel, table[np.concatenate(entry)], np.concatenate(pose), np.concatenate(mic))
    return _kept(tracing, ways, np.concatenate(pressure), wavenumber, frequency_hz, audible.limit_m, width, ledger)


def _table(wedges: Wedges, longest: int) -> Windowed:
    """All chains of linked edges in all windows, but at ends that are no corners."""
    linked, edges = linked_edges(wedges), np.arange(len(wedges))
    met, parts = [], []
    for count in range(2, min(longest, LONGEST) + 1):
        chain = np.stack(np.meshgrid(*[edges] * count, indexing="ij"), axis=-1).reshape(-1, count)
        chain = chain[linked[chain[:, :-1], chain[:, 1:]].all(axis=1)]
        part = np.stack(np.meshgrid(*[PARTS] * count, indexing="ij"), axis=-1).reshape(-1, count)
        chain, part = np.repeat(chain, len(part), axis=0), np.tile(part, (len(chain), 1))
        there = np.concatenate([np.ones((len(wedges), 1), dtype=bool), wedges.radiates], axis=1)  # in order of PARTS
        rows = there[chain, part].all(axis=1)
        pad = ((0, 0), (0, LONGEST - count))
        met.append(np.pad(chain[rows], pad, constant_values=-1))
        parts.append(np.pad(part[rows], pad))
    return Windowed(np.concatenate(met), np.concatenate(parts))


def _heard(tracing: Tracing, panel: Ints, limit_m: float) -> NDArray[np.bool_]:
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


def _spectra(face: Face, table: Windowed, ends_m: Floats, heard: NDArray[np.bool_]) -> list[tuple[int, Complexes]]:
    """(T, K) pressures of all chains, with their travel phase, for every microphone that hears the panel."""
    two, three = (np.flatnonzero(table.count == count) for count in (2, 3))
    out = []
    before = half_way(face, ends_m[0]) if len(three) else None
    for mic in np.flatnonzero(heard):
        parts = [_picked(over_two(face, ends_m[0], ends_m[1 + mic]), table[two], 2)]
        if before is not None:
            parts.append(_picked(over_three(face, before, half_way(face, ends_m[1 + mic])), table[three], 3))
        out.append((int(mic), np.concatenate(parts)))
    return out


def _picked(sums: Complexes, table: Windowed, count: int) -> Complexes:
    index = [part[:, slot] for slot in range(count) for part in (table.edge, table.part)]
    return sums[tuple(index)]


def _turn_faint_away(
    tracing: Tracing, panel: Ints, table: Windowed, pose: int, mic: int, bound: Floats, width: int, ledger: Ledger
) -> None:
    def described() -> Turned:
        poses, mics = (np.full(len(bound), x) for x in (pose, mic))
        return turned_ways(tracing, _placed(tracing, panel, table, poses, mics), bound, width)

    ledger.turn_away("faint second edge", len(bound), described)


def _placed(tracing: Tracing, panel: Ints, table: Windowed, pose: Ints, mic: Ints) -> Ways:
    """The ways through the corners, and the points of the middles that make them shortest."""
    chain = np.where(table.edge >= 0, panel[table.edge], -1)
    none = np.full(len(pose), -1)
    points = np.repeat(tracing.mics_m[pose, mic][:, None], LONGEST + 2, axis=1)
    points[:, 0] = tracing.source_m[pose]
    slots = [np.flatnonzero(table.count > slot) for slot in range(LONGEST)]
    wedges = [at_poses(tracing, chain[rows, slot], pose[rows]) for slot, rows in enumerate(slots)]
    for slot, (rows, edge) in enumerate(zip(slots, wedges, strict=True)):
        share = np.array([0.5, 0.0, 1.0])[table.part[rows, slot], None]
        points[rows, slot + 1] = edge.start_m + share * (edge.end_m - edge.start_m)
    for _ in range(ROUNDS):
        for slot, (rows, edge) in enumerate(zip(slots, wedges, strict=True)):
            free = np.flatnonzero(table.part[rows, slot] == APEX)
            some = rows[free]
            points[some, slot + 1] = _shortest(edge[free], points[some, slot], points[some, slot + 2])
    return Ways(pose, mic, Chains(chain, table.count, none, np.full(len(pose), APEX)), points)


def _shortest(wedges: Wedges, source_m: Floats, receiver_m: Floats) -> Floats:
    """(R, 3) point of each edge over which the way between its neighbours is shortest; ends on its line may meet it."""
    along, start = wedges.along, wedges.start_m
    height = [np.sum((point - start) * along, axis=1) for point in (source_m, receiver_m)]
    radius = [
        np.linalg.norm(point - start - h[:, None] * along, axis=1)
        for point, h in zip((source_m, receiver_m), height, strict=True)
    ]
    total = np.maximum(radius[0] + radius[1], 1e-300)
    apex = height[0] + (height[1] - height[0]) * radius[0] / total
    return start + np.clip(apex, 0.0, wedges.length_m)[:, None] * along


def _kept(
    tracing: Tracing, ways: Ways, pressure: Complexes, wavenumber: Floats, frequency_hz: Floats, limit_m: float,
    width: int, ledger: Ledger,
) -> tuple[Candidates, Complexes]:  # fmt: skip
    """Candidates of the ways that nothing hides, and their gains without the phase of their lengths."""
    length = ways.legs_m.sum(axis=1)
    near = length <= limit_m
    free = near.copy()
    free[near] = free_of_obstacles(tracing, ways[near])
    hidden, rows = np.flatnonzero(near & ~free), np.flatnonzero(free)
    bound = np.abs(pressure).max(axis=1, initial=0.0)
    ledger.turn_away("hidden", len(hidden), partial(turned_ways, tracing, ways[hidden], bound[hidden], width))
    gain = pressure[rows] * np.exp(1j * length[rows, None] * wavenumber)
    return candidates_over(tracing, ways[rows], width), gain * face_factor(tracing, ways[rows], frequency_hz)
