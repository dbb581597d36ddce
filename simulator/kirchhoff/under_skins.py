"""Facets that lie just under another body, as skin under a coat: no sound comes to them.

The rounded surface stands off its mesh, and light is asked for from beyond that. What lies over a facet by less hides
nothing of it there: a post of 48 sides 1 mm within a sleeve was 4.5 dB too loud, a person in a coat up to 6 dB. Cars
have cabins that stand on their decks: behind people their echoes are within 1.1 dB of those whose light is asked for
from the surface itself in 90 % of 28, and were within 2.5.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obstaclewatch.support.arrays import Ints
from obstaclewatch.support.vectors import dot
from simulator.surfaces.facets import Facets
from simulator.world.visibility import Blocker
from simulator.world.world import World

ALONG_COS = np.cos(np.deg2rad(45.0))  # between normals: a steep windscreen does not lie along the deck at its foot


def outermost(world: World, facets: Facets) -> Facets:
    """Facets without those along which the mesh of another piece lies, within what their own may stand off.

    A piece of the same obstacle or of one that never moves against it. What such a facet shows past the other's border
    is seen aslant, and hardly echoes. Where one facet beside a crease stays, the other does too, but light on it is
    asked for from under its own mesh, where there is none.
    """
    shadow = next(each for each in world.blockers if facets.obstacle in each.owner)
    off = facets.standoff_m[:, None] * facets.normal
    met = shadow.first_met(facets.middle_m + off, facets.middle_m - off)
    covered = (met >= 0) & (_pieces(world, shadow, facets.obstacle)[met] != facets.piece)
    covered &= world.skins[facets.obstacle][0].solid_pieces[facets.piece]  # a sheet is seen from behind as well
    covered &= np.abs(dot(shadow.normal[met], facets.normal)) > ALONG_COS
    if not covered.any():
        return facets
    creases = facets.creases[~covered[facets.creases.beside].all(axis=1)]
    beside = np.isin(np.arange(len(facets)), creases.beside)
    standoff_m = np.where(covered, -facets.standoff_m, facets.standoff_m)
    return replace(facets, creases=creases, standoff_m=standoff_m)[~covered | beside]


def _pieces(world: World, shadow: Blocker, obstacle: int) -> Ints:
    """(T,) which piece of an obstacle each triangle of a blocker is of, -1 for those of others."""
    piece, found = world.skins[obstacle][0].piece, np.full(len(shadow.owner), -1)
    found[np.flatnonzero(shadow.owner == obstacle)[: len(piece)]] = piece
    return found
