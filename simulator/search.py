"""Every path that geometry allows, by all mechanisms of the fidelity, before any mask."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obstaclewatch.support.arrays import Complexes
from simulator.curved.double import twice_curved
from simulator.curved.single import mixed
from simulator.diffraction.panel_chains import panel_chains
from simulator.diffraction.single import diffracted
from simulator.images.image_method import planar
from simulator.kirchhoff.doubtful_bodies import doubted
from simulator.kirchhoff.rays_over_pairs import beside_integral
from simulator.kirchhoff.scattering import scattered_paths
from simulator.kirchhoff.selection import left_to_integral
from simulator.world.candidates import Candidates, concatenated, direct, joined, loudest_of
from simulator.world.search_context import Search


def searched(search: Search) -> tuple[Candidates, Complexes]:
    """All candidates, and (M, K) what the cells of sums among them come to; `cell` names the row."""
    tracing = search.tracing
    straight = direct(tracing, max(search.max_order, 1))
    if search.max_order == 0:
        return straight, np.zeros((0, len(search.band_hz)), dtype=np.complex128)
    doubts = doubted(search)
    uneven = {doubt.surface for doubt in doubts if doubt.uneven}
    mirrors, beside = planar(search)
    singles = [None if index in uneven else mixed(search, index) for index in range(len(tracing.world.surfaces))]
    rays = [mirrors, *(each for each in singles if each is not None)]
    loudest, echoes = loudest_of(rays, len(tracing.pose)), concatenated(rays)
    taken = left_to_integral(search, doubts, echoes)
    if search.max_order > 1 and len(tracing.world.surfaces) > 1:
        rays += twice_curved(search, singles, loudest)
    if len(tracing.world.wedges):
        rays.append(diffracted(search, loudest))
    rays = [beside_integral(search, taken, each) for each in [*rays, beside]]
    integrals = [part for body in taken for part in scattered_paths(search, body)]
    chains = panel_chains(search, rays[0], taken, loudest)
    parts, sums = [straight, *rays], [np.zeros((0, len(search.band_hz)), dtype=np.complex128)]
    for found, gain in integrals + chains:
        parts.append(replace(found, cell=found.cell + sum(map(len, sums))))
        sums.append(gain)
    return joined(parts), np.concatenate(sums)
