"""Paths over several edges of each thin panel, where neither a mirror image nor an integral makes up for them."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from simulator.diffraction.chain_integrals import integrated_chains
from simulator.diffraction.thin_panels import panels_of
from simulator.images.image_pairs import Taken
from simulator.scene.fidelity import Fidelity
from simulator.world.candidates import Candidates
from simulator.world.search_context import Search
from simulator.world.world import Tracing


def panel_chains(
    search: Search, mirrors: Candidates, taken: list[Taken], loudest: Floats
) -> list[tuple[Candidates, Complexes]]:
    """Panel by panel, paths along it as cells, and their gains.

    Args:
        mirrors: image paths, as far as they are not left to Kirchhoff's integral.
        taken: what is.
        loudest: (N, 2) strongest echo of mirrors at each pose and microphone.
    """
    longest, tracing = longest_chain(search.fidelity), search.tracing
    panels = panels_of(tracing.world.wedges) if longest > 1 else []
    masks = [(_mirrored(tracing, mirrors, panel), _left_out(tracing, taken, panel)) for panel in panels]
    return [
        integrated_chains(search, panel, *each, longest, loudest) for panel, each in zip(panels, masks, strict=True)
    ]


def longest_chain(fidelity: Fidelity) -> int:
    """Edges that a path may meet along one panel: as many as reflections, but from three on as many as asked for."""
    return fidelity.edge_order if fidelity.max_order >= 3 else min(fidelity.edge_order, fidelity.max_order)


def _left_out(tracing: Tracing, taken: list[Taken], panel: Ints) -> Flags:
    """(N, 2) where Kirchhoff's integral takes care of a panel's obstacle, without mirrors."""
    out = np.zeros((len(tracing.pose), 2), dtype=bool)
    for pairs in (body.pairs for body in taken):
        if pairs.obstacle == tracing.world.wedges.obstacle[panel[0]]:
            straight = (pairs.before.order == 0) & (pairs.after.order == 0)
            out[pairs.pose[straight], pairs.mic[straight]] = True
    return out


def _mirrored(tracing: Tracing, mirrors: Candidates, panel: Ints) -> Flags:
    """(N, 2) poses and microphones with a mirror image in a panel, whatever stands before it."""
    rows = (mirrors.order == 1) & (mirrors.sequence[:, 0] == tracing.world.wedges.patch[panel[0], 0])
    out = np.zeros((len(tracing.pose), 2), dtype=bool)
    out[mirrors.pose[rows], mirrors.mic[rows]] = True
    return out
