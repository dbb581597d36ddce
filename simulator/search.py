"""Every way that geometry allows, by all mechanisms of the fidelity, before any mask."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from simulator.curved.double import twice_curved
from simulator.curved.single import mixed
from simulator.diffraction.apex_chains import Strength, twice_diffracted
from simulator.diffraction.chain_integrals import integrable, integrated_chains
from simulator.diffraction.single import diffracted
from simulator.diffraction.thin_panels import LONGEST, panels_of
from simulator.images.planar import planar
from simulator.kirchhoff.image_pairs import Pairs, run_over
from simulator.kirchhoff.scattering import scattered_paths
from simulator.kirchhoff.selection import heard_whole
from simulator.scene.fidelity import Fidelity
from simulator.surfaces.facets import facets_of
from simulator.waves import band
from simulator.waves.band import REFERENCE_HZ
from simulator.waves.spreading import spreading
from simulator.world.audible import Audible
from simulator.world.candidates import Candidates, concatenated, direct, joined, nothing
from simulator.world.rejection_log import Ledger, Turned
from simulator.world.world import Tracing

LEFT_TO_INTEGRAL = "left to Kirchhoff's integral"
FOCUS_GAIN = 4.0  # a mirror this much stronger than a plane focuses on the receiver, where ray theory ends


def searched(tracing: Tracing, fidelity: Fidelity, speed_m_s: float, ledger: Ledger) -> tuple[Candidates, Complexes]:
    """All candidates, and (M, K) what the cells of Kirchhoff's integrals among them sum up to; `cell` names the row."""
    order = fidelity.max_order
    rays = [direct(tracing, max(order, 1))]
    if order == 0:
        return joined(rays), np.zeros((0, fidelity.band_points), dtype=np.complex128)
    audible = Audible.of(fidelity)
    wavenumber = 2.0 * np.pi * REFERENCE_HZ / speed_m_s
    rays.append(planar(tracing, order, audible.limit_m, ledger))
    rays += [mixed(tracing, i, order, audible.limit_m, ledger) for i in range(len(tracing.world.surfaces))]
    whole = heard_whole(tracing, fidelity, concatenated(rays), audible, wavenumber, ledger)
    loudest = _loudest(tracing, rays[1:])
    if order > 1 and len(tracing.world.surfaces) > 1:
        rays.append(twice_curved(tracing, order, audible, rays[2:], loudest, ledger))
    if len(tracing.world.wedges):
        rays.append(diffracted(tracing, order, audible, loudest, wavenumber, ledger))
    rays = [_not_heard_whole(tracing, each, whole, ledger) for each in rays]
    nodes = 2.0 * np.pi * band.nodes_hz(fidelity.band_points) / speed_m_s
    cells, sums = _integrals(tracing, fidelity, whole, audible, nodes, ledger)
    chains, gains = _chains(tracing, fidelity, rays[1], whole, audible, loudest, speed_m_s, ledger)
    chains.cell[:] += len(sums)
    return joined([*rays, *cells, chains]), np.concatenate([sums, gains])


def _integrals(
    tracing: Tracing, fidelity: Fidelity, whole: list[Pairs], audible: Audible, wavenumber: Floats, ledger: Ledger
) -> tuple[list[Candidates], Complexes]:
    """Kirchhoff's integrals over all ways that are left to them."""
    parts: list[Candidates] = []
    sums = np.zeros((0, len(wavenumber)), dtype=np.complex128)
    for pairs in whole:
        skin = facets_of(*tracing.world.skins[pairs.obstacle], pairs.obstacle, fidelity.facet_m)
        found, gain = scattered_paths(tracing, skin, pairs, fidelity.max_order, audible, wavenumber, ledger)
        found.cell[:] += len(sums)
        parts, sums = [*parts, found], np.concatenate([sums, gain])
    return parts, sums


def _chains(
    tracing: Tracing, fidelity: Fidelity, mirrors: Candidates, whole: list[Pairs], audible: Audible, loudest: Floats,
    speed_m_s: float, ledger: Ledger,
) -> tuple[Candidates, Complexes]:  # fmt: skip
    """Ways over several edges of one panel, but of none that Kirchhoff's integral takes care of."""
    longest = longest_chain(fidelity)
    frequency = band.nodes_hz(fidelity.band_points)
    if longest < 2:
        return nothing(fidelity.max_order), np.zeros((0, len(frequency)), dtype=np.complex128)
    bounds = fidelity.max_order, audible, loudest
    panels, rest = panels_of(tracing.world.wedges), []
    parts = []
    for panel in panels:
        if fidelity.edge_chains == "integrals" and integrable(tracing.world.wedges[panel]):
            seen = _mirrored(tracing, mirrors, panel)
            parts.append(integrated_chains(tracing, panel, seen, longest, *bounds, frequency, speed_m_s, ledger))
        else:
            rest.append(panel)
    strength = Strength(frequency, speed_m_s)
    parts.append(twice_diffracted(tracing, rest, min(longest, LONGEST), *bounds, strength, ledger))
    found, gains = concatenated([each for each, _ in parts]), np.concatenate([gain for _, gain in parts])
    owner, kept = tracing.world.owner[found.sequence[:, 0]], np.ones(len(found), dtype=bool)
    for pairs in whole:
        direct_ways = (pairs.before.order == 0) & (pairs.after.order == 0)
        heard = 2 * pairs.pose[direct_ways] + pairs.mic[direct_ways]
        kept &= ~((owner == pairs.obstacle) & np.isin(2 * found.pose + found.mic, heard))
    rows = np.flatnonzero(~kept)
    ledger.turn_away(
        LEFT_TO_INTEGRAL, len(rows), lambda: Turned(np.abs(gains[rows]).max(axis=1), lambda some: found[rows[some]])
    )
    found.cell[kept] = np.arange(int(kept.sum()))
    return found[kept], gains[kept]


def longest_chain(fidelity: Fidelity) -> int:
    """Edges that a path may meet along one panel: as many as reflections, but from three on as many as asked for."""
    return fidelity.edge_order if fidelity.max_order >= LONGEST else min(fidelity.edge_order, fidelity.max_order)


def _mirrored(tracing: Tracing, mirrors: Candidates, panel: Ints) -> Flags:
    """(N, 2) poses and microphones with a mirror image in a panel, whatever stands before it."""
    rows = (mirrors.order == 1) & (mirrors.sequence[:, 0] == tracing.world.wedges.patch[panel[0], 0])
    out = np.zeros((len(tracing.pose), 2), dtype=bool)
    out[mirrors.pose[rows], mirrors.mic[rows]] = True
    return out


def _not_heard_whole(tracing: Tracing, found: Candidates, whole: list[Pairs], ledger: Ledger) -> Candidates:
    """What runs over no way that Kirchhoff's integral takes care of."""
    taken = run_over(tracing, found, whole)
    rows = np.flatnonzero(taken)
    ledger.turn_away(
        LEFT_TO_INTEGRAL, len(rows),
        lambda: Turned(_amplitude(found[rows]), lambda chosen: found[rows[chosen]]),
    )  # fmt: skip
    return found[~taken]


def _loudest(tracing: Tracing, parts: list[Candidates]) -> Floats:
    """(N, 2) greatest amplitude of any echo at each pose and microphone, shadows apart; 0 without one."""
    loudest = np.zeros((len(tracing.pose), 2))
    for found in parts:
        np.maximum.at(loudest, (found.pose, found.mic), _amplitude(found))
    return loudest


def _amplitude(found: Candidates) -> Floats:
    """(C,) spreading, no more than a focus is trusted with."""
    amplitude = np.abs(spreading(found.points_m, found.normal, found.curvature, found.order))
    return np.minimum(amplitude, FOCUS_GAIN / found.length_m)
