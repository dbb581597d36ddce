"""Every path that geometry allows, by all mechanisms of the fidelity, before any mask."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from simulator.curved.double import twice_curved
from simulator.curved.single import mixed
from simulator.diffraction.chain_integrals import integrated_chains
from simulator.diffraction.single import diffracted
from simulator.diffraction.thin_panels import panels_of
from simulator.images.image_method import planar
from simulator.kirchhoff.image_pairs import Pairs, run_over
from simulator.kirchhoff.scattering import facet_size_m, has_plates, scattered_paths
from simulator.kirchhoff.selection import left_to_integral, uneven_surfaces
from simulator.scene.fidelity import Fidelity
from simulator.surfaces.facets import facets_of
from simulator.waves.spreading import spreading
from simulator.world.candidates import Candidates, concatenated, direct, joined, nothing
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing

FOCUS_GAIN = 4.0  # a mirror this much stronger than a plane focuses on the receiver, where ray theory ends


def searched(search: Search) -> tuple[Candidates, Complexes]:
    """All candidates, and (M, K) what the cells of Kirchhoff's integrals among them sum up to; `cell` names the row."""
    tracing = search.tracing
    rays = [direct(tracing, max(search.max_order, 1))]
    if search.max_order == 0:
        return joined(rays), _no_sums(search)
    rays.append(planar(search))
    uneven = uneven_surfaces(tracing, search.fidelity)
    singles = [None if index in uneven else mixed(search, index) for index in range(len(tracing.world.surfaces))]
    rays += [each for each in singles if each is not None]
    taken = left_to_integral(search, concatenated(rays), uneven)
    loudest = _loudest(tracing, rays[1:])
    if search.scatter_order > 1 and len(tracing.world.surfaces) > 1:
        rays.append(twice_curved(search, singles, loudest))
    if len(tracing.world.wedges):
        rays.append(diffracted(search, loudest))
    rays = [_not_left_to_integral(search, each, taken) for each in rays]
    cells, sums = _integrals(search, taken)
    chains, gains = _chains(search, rays[1], taken, loudest)
    chains = replace(chains, cell=chains.cell + len(sums))
    return joined([*rays, *cells, chains]), np.concatenate([sums, gains])


def _no_sums(search: Search) -> Complexes:
    return np.zeros((0, len(search.band_hz)), dtype=np.complex128)


def _integrals(search: Search, taken: list[Pairs]) -> tuple[list[Candidates], Complexes]:
    """Kirchhoff's integrals over all pairs of images that are left to them."""
    parts: list[Candidates] = []
    sums = _no_sums(search)
    for pairs in taken:
        reading, surface = search.tracing.world.skins[pairs.obstacle]
        size_m = facet_size_m(search.fidelity, has_plates(reading))
        skin = facets_of(reading, surface, pairs.obstacle, size_m)
        found, gain = scattered_paths(search, skin, pairs)
        parts, sums = [*parts, replace(found, cell=found.cell + len(sums))], np.concatenate([sums, gain])
    return parts, sums


def _chains(search: Search, mirrors: Candidates, taken: list[Pairs], loudest: Floats) -> tuple[Candidates, Complexes]:
    """Paths over several edges of one panel."""
    longest, tracing = longest_chain(search.fidelity), search.tracing
    found, gains = [nothing(search.max_order)], [_no_sums(search)]
    for panel in panels_of(tracing.world.wedges) if longest > 1 else []:
        mirrored, left_out = _mirrored(tracing, mirrors, panel), _left_out(tracing, taken, panel)
        each, gain = integrated_chains(search, panel, mirrored, left_out, longest, loudest)
        found, gains = [*found, each], [*gains, gain]
    chains = concatenated(found)
    return replace(chains, cell=np.arange(len(chains))), np.concatenate(gains)


def _left_out(tracing: Tracing, taken: list[Pairs], panel: Ints) -> Flags:
    """(N, 2) where Kirchhoff's integral takes care of a panel's obstacle, without mirrors."""
    out = np.zeros((len(tracing.pose), 2), dtype=bool)
    for pairs in taken:
        if pairs.obstacle == tracing.world.wedges.obstacle[panel[0]]:
            straight = (pairs.before.order == 0) & (pairs.after.order == 0)
            out[pairs.pose[straight], pairs.mic[straight]] = True
    return out


def longest_chain(fidelity: Fidelity) -> int:
    """Edges that a path may meet along one panel: as many as reflections, but from three on as many as asked for."""
    return fidelity.edge_order if fidelity.max_order >= 3 else min(fidelity.edge_order, fidelity.max_order)


def _mirrored(tracing: Tracing, mirrors: Candidates, panel: Ints) -> Flags:
    """(N, 2) poses and microphones with a mirror image in a panel, whatever stands before it."""
    rows = (mirrors.order == 1) & (mirrors.sequence[:, 0] == tracing.world.wedges.patch[panel[0], 0])
    out = np.zeros((len(tracing.pose), 2), dtype=bool)
    out[mirrors.pose[rows], mirrors.mic[rows]] = True
    return out


def _not_left_to_integral(search: Search, found: Candidates, taken: list[Pairs]) -> Candidates:
    """What runs over no pair of images that Kirchhoff's integral takes care of."""
    if not taken:
        return found
    over = run_over(search.tracing, found, taken)
    rows = np.flatnonzero(over)
    search.reject(
        Reason.LEFT_TO_INTEGRAL, len(rows),
        lambda: Rejected(_amplitude(found[rows]), lambda chosen: found[rows[chosen]]),
    )  # fmt: skip
    return found[~over]


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
