"""Sound that two or three edges of a thin panel bend, one after the other, along its faces.

Seen well off its normal a panel answers with its edges alone, and what one edge sends along the face is bent again at
the others. Edge-on all of it adds up to nothing: in front of the far edge the wave that the near edge bends cancels
the incident one, in and out. For chains of edges at their apexes, which together are the shortest path over all of
them, the line integrals over every edge (Svensson, Fred and Vanderkooy 1999) have one stationary point, and

    H = prod_i E_i(p_{i-1}, p_{i+1}) J e^{-jk L},   J = prod_i m_{i,i+1} sqrt(prod_i H_ii / det H):

E_i is the contribution of one edge (`edges.edge_terms`, its zone boundaries included) between its neighbours' points,
m the segments on the face, H the matrix of second derivatives of L along the edges; the halves by which a wave on a
face counts double and its two faces make up for each other. Where one edge is met at an end q, the apexes before and
after it turn the ray into the face, from or towards the image P of the speaker or microphone in the plane of the face:

    H = E_i(S, q) L_i E_q(P, R) e^{-jk L}.

Both are symmetric in speaker and microphone. Where apexes reach ends or corners and these parts would have to be told
apart by integrals over both edges at once, they fade out: within about a radian of phase between them.

Measured, first order included, against boundary elements of a plate of 0.2 x 0.3 m at 1.5 m, every 5 degrees of yaw to
edge-on, microphones up to 16 cm away: 0.47 dB and 1.0 samples where the echo is at -20 to -30 dB re wall (first order
alone 4.9 dB, 5.5 samples), 2.1 dB to -40 dB, 3.3 dB at -57 dB beside the speaker (25 dB). A plate of 0.45 m keeps an
error of 1.9 dB at 75 degrees (4.4 dB): what edges pass on at a corner they share is left out. Integrals over all edges
(`chain_integrals`) put 0.7 dB of that down to two edges, the rest to three. A phone above or below an edge-on panel
hears two edges at right angles, at -43 dB and less, which fade out here: up to 14 dB too faint; and of what nearly
cancels below -50 dB up to 19 dB are left over.
ChainPaths with a mirror beside are not looked for.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from simulator.diffraction.btm import edge_terms, strength_bound
from simulator.diffraction.chain_paths import (
    ChainPaths,
    candidates_over,
    face_factor,
    free_of_obstacles,
    joined_paths,
    rejected_paths,
)
from simulator.diffraction.edge_view import APEX, END, START, EdgeView
from simulator.diffraction.joint_apexes import joint_apexes, second_derivatives
from simulator.diffraction.single import at_poses, edge_points, outside, seen
from simulator.diffraction.thin_panels import LONGEST, Chains, chains_of, merge_chains
from simulator.surfaces.wedges import Wedges
from simulator.world.candidates import Candidates
from simulator.world.rejection_log import Reason
from simulator.world.search_context import Search
from simulator.world.world import Tracing


def apex_chains(search: Search, panels: list[Ints], longest: int, loudest: Floats) -> tuple[Candidates, Complexes]:
    """ChainPaths over two to `longest` edges of one panel, without mirrors, as cells with their gains.

    The edges are rigid; every segment along a face of reflection factor R has half of 1 + R beside.

    Args:
        panels: wedges of each.
        loudest: (N, 2) strongest echo of mirrors at each pose and microphone.
    """
    tracing, wedges, wavenumber = search.tracing, search.tracing.world.wedges, search.wavenumber_1_m
    chains = merge_chains([chains_of(wedges, panel, longest) for panel in panels])
    paths = _ways(tracing, chains, search.limit_m)
    weight = _weights(tracing, paths, wavenumber)
    bound = weight * _bound(tracing, paths, wavenumber)
    strongest = loudest.copy()
    np.maximum.at(strongest, (paths.pose, paths.mic), bound)
    loud = search.audible(bound, strongest[paths.pose, paths.mic])
    free = np.zeros(len(paths), dtype=bool)
    free[loud] = free_of_obstacles(tracing, paths[loud])
    for reason, away in ((Reason.FAINT_CHAIN, ~loud), (Reason.HIDDEN, loud & ~free)):
        rows = np.flatnonzero(away)
        search.reject(reason, len(rows), partial(rejected_paths, search, paths[rows], bound[rows]))
    rows = np.flatnonzero(free)
    found = candidates_over(search, paths[rows])
    gain = _gain(search, paths[rows]) * face_factor(tracing, paths[rows], search.band_hz)
    return found, weight[rows, None] * gain


def _ways(tracing: Tracing, chains: Chains, limit_m: float) -> ChainPaths:
    """Every chain at every pose and microphone that has its apexes on their edges and faces the phone."""
    poses = len(tracing.pose)
    pose, mic, chain = (x.ravel() for x in np.meshgrid(np.arange(poses), [0, 1], np.arange(len(chains)), indexing="ij"))
    source, receiver = tracing.source_m[pose], tracing.mics_m[pose, mic]
    first = at_poses(tracing, chains.edge[chain, 0], pose)
    nearest = np.linalg.norm(0.5 * (first.start_m + first.end_m) - source, axis=1) - 0.5 * first.length_m
    shortest = 2.0 * nearest - np.linalg.norm(receiver - source, axis=1)
    rows = np.flatnonzero((shortest <= limit_m) & outside(first, seen(first, source, receiver)))
    paths = _unplaced(tracing, pose[rows], mic[rows], chains[chain[rows]])
    found = [_over_apexes(tracing, paths, count) for count in range(2, LONGEST + 1)] + [_over_ends(tracing, paths)]
    every = joined_paths(found)
    return every[np.flatnonzero(every.segments_m.sum(axis=1) <= limit_m)]


def _unplaced(tracing: Tracing, pose: Ints, mic: Ints, chain: Chains) -> ChainPaths:
    points = np.repeat(tracing.mics_m[pose, mic][:, None], LONGEST + 2, axis=1)
    points[:, 0] = tracing.source_m[pose]
    return ChainPaths(pose, mic, chain, points)


def _over_apexes(tracing: Tracing, paths: ChainPaths, count: int) -> ChainPaths:
    """The paths over `count` apexes, where all of them lie on their edges."""
    paths = paths[np.flatnonzero((paths.chain.core < 0) & (paths.chain.count == count))]
    wedges = [at_poses(tracing, paths.chain.edge[:, slot], paths.pose) for slot in range(count)]
    start, along = np.stack([w.start_m for w in wedges], axis=1), np.stack([w.along for w in wedges], axis=1)
    length = np.stack([w.length_m for w in wedges], axis=1)
    height, settled = joint_apexes(start, along, length, paths.points_m[:, 0], paths.points_m[:, -1])
    rows = np.flatnonzero(settled & ((height >= 0.0) & (height < length)).all(axis=1))
    paths.points_m[rows, 1 : count + 1] = start[rows] + height[rows, :, None] * along[rows]
    return paths[rows]


def _over_ends(tracing: Tracing, paths: ChainPaths) -> ChainPaths:
    """The paths over one end, where the apexes before and after it lie on their edges."""
    paths = paths[np.flatnonzero(paths.chain.core >= 0)]
    each, core = np.arange(len(paths)), paths.chain.core
    wedges = at_poses(tracing, paths.chain.edge[each, core], paths.pose)
    corner = np.where((paths.chain.part == START)[:, None], wedges.start_m, wedges.end_m)
    paths.points_m[each, core + 1] = corner
    there = np.ones(len(paths), dtype=bool)
    for beside, end in ((-1, 0), (1, -1)):
        slot = core + beside
        rows = np.flatnonzero((slot >= 0) & (slot < paths.chain.count))
        edge = at_poses(tracing, paths.chain.edge[rows, slot[rows]], paths.pose[rows])
        view = seen(edge, paths.points_m[rows, end], corner[rows])
        there[rows] &= view.has(APEX)
        paths.points_m[rows, slot[rows] + 1] = edge_points(edge, view, APEX)
    return paths[np.flatnonzero(there)]


def _views(tracing: Tracing, paths: ChainPaths, slot: int) -> tuple[Ints, EdgeView, Ints]:
    """Rows whose chains reach a slot, how their edges there see their neighbours, and which part is met."""
    rows = np.flatnonzero(paths.chain.count > slot)
    paths = paths[rows]
    wedges = at_poses(tracing, paths.chain.edge[:, slot], paths.pose)
    is_core = paths.chain.core == slot
    ends = [paths.points_m[:, slot], paths.points_m[:, slot + 2]]
    later = paths.chain.count > slot + 1
    on_face = [np.full(len(rows), slot > 0), later]
    for n, (beyond, step) in enumerate(((0, -1), (-1, 1))):
        turned = np.flatnonzero(is_core & on_face[n])
        ends[n] = ends[n].copy()
        ends[n][turned] = _unfolded(paths[turned], slot + 1, step, beyond)
    view = seen(wedges, *ends)
    face = _angle_of_face(tracing, paths, wedges)
    view = EdgeView(
        view.source_radius_m, np.where(on_face[0], face, view.source_angle_rad), view.source_height_m,
        view.receiver_radius_m, np.where(on_face[1], face, view.receiver_angle_rad), view.receiver_height_m,
        view.length_m, view.open_angle_rad,
    )  # fmt: skip
    return rows, view, np.where(is_core, paths.chain.part, APEX)


def _angle_of_face(tracing: Tracing, paths: ChainPaths, wedges: Wedges) -> Floats:
    """(R,) angle about edges of the same one of the panel's two faces for all edges of a chain."""
    first = at_poses(tracing, paths.chain.edge[:, 0], paths.pose)
    same = np.sum(first.normal * wedges.normal, axis=1) > 0.0
    return np.where(same, 0.0, wedges.open_angle_rad)


def _unfolded(paths: ChainPaths, at: int, step: int, end: int) -> Floats:
    """(R, 3) speaker (end 0) or microphone (-1) turned into the plane of the face, seen from point `at`."""
    corner, apex, far = paths.points_m[:, at], paths.points_m[:, at + step], paths.points_m[:, end]
    segment = apex - corner
    short = np.linalg.norm(segment, axis=1)
    length = short + np.linalg.norm(far - apex, axis=1)
    return corner + (length / short)[:, None] * segment


def _spread(paths: ChainPaths, alongs: Floats) -> Floats:
    """(R,) the segments' share in the gain: J of the apexes, or the unfolded lengths to the end."""
    out, segments = np.ones(len(paths)), paths.segments_m
    for count in range(2, LONGEST + 1):
        rows = np.flatnonzero((paths.chain.core < 0) & (paths.chain.count == count))
        bend = second_derivatives(paths.points_m[rows, : count + 2], alongs[rows, :count])
        diagonal = np.prod(np.diagonal(bend, axis1=1, axis2=2), axis=1)
        out[rows] = np.prod(segments[rows, 1:count], axis=1) * np.sqrt(diagonal / np.linalg.det(bend))
    core = paths.chain.core
    before, after = np.flatnonzero(core > 0), np.flatnonzero((core >= 0) & (core + 1 < paths.chain.count))
    out[before] *= segments[before, core[before] - 1] + segments[before, core[before]]
    out[after] *= segments[after, core[after] + 1] + segments[after, core[after] + 2]
    return out


def _alongs(tracing: Tracing, paths: ChainPaths) -> Floats:
    """(R, LONGEST, 3) directions of the edges met; the last one repeated."""
    slots = np.minimum(np.arange(LONGEST), paths.chain.count[:, None] - 1)
    edge = np.take_along_axis(paths.chain.edge, slots, axis=1)
    return np.stack([at_poses(tracing, edge[:, n], paths.pose).along for n in range(LONGEST)], axis=1)


def _weights(tracing: Tracing, paths: ChainPaths, wavenumber: float) -> Floats:
    """(R,) how far each path counts, from 0 to 1: the product over its parts and over the segments between apexes."""
    weight = np.ones(len(paths))
    segments = paths.segments_m
    for slot in range(LONGEST):
        rows = np.flatnonzero((paths.chain.core < 0) & (paths.chain.count > slot + 1))
        weight[rows] *= _faded(wavenumber * segments[rows, slot + 1])
        rows, view, part = _views(tracing, paths, slot)
        telling = (paths.chain.core[rows] < 0) | (part != APEX)
        weight[rows[telling]] *= _faded(wavenumber * _apart(view[telling], part[telling]))
    return weight


def _faded(phase_rad: Floats) -> Floats:
    return 1.0 - np.exp(-(phase_rad**2))


def _apart(view: EdgeView, part: Ints) -> Floats:
    """(R,) by how much the path over an apex is shorter than over the nearer end, or differs over an end, m.

    The path over an end must differ from that over the apex, and somewhere else along the edge.
    """
    excess = [view.excess(np.full(len(view), end)) ** 2 for end in (START, END)]
    across = np.maximum(*excess) - np.where(view.has(APEX), 0.0, np.minimum(*excess))
    own = np.where(part == START, *excess)
    return np.where(part == APEX, np.minimum(*excess), np.minimum(own, across))


def _bound(tracing: Tracing, paths: ChainPaths, wavenumber: float) -> Floats:
    """(R,) estimate from above of the gains, without the weights."""
    bound = _spread(paths, _alongs(tracing, paths))
    for slot in range(LONGEST):
        rows, view, part = _views(tracing, paths, slot)
        bound[rows] *= strength_bound(view, part, wavenumber)
    return bound


def _gain(search: Search, paths: ChainPaths) -> Complexes:
    """(R, K) gains without the travel phase."""
    spread = _spread(paths, _alongs(search.tracing, paths))
    gain = np.repeat(spread[:, None].astype(np.complex128), len(search.band_hz), axis=1)
    for slot in range(LONGEST):
        rows, view, part = _views(search.tracing, paths, slot)
        gain[rows] *= edge_terms(view, part, search.band_wavenumber_1_m).sum(axis=1)
    return gain
