"""Points of quadrature on the edges of a thin panel, and windows that share each edge between its ends and its middle.

Both ends of a face segment may run along the edges, so that the phase turns by up to 2k along each: pieces of half the
shortest wavelength, with three Gauss points each. Towards corners, where segments become short, they halve down to a
millimetre. Against plain sums over four points in each piece: 1e-3 of the double integral at most, 4e-3 of the triple
one, the transform of `edge_integrals` included (0.2 and 0.45 m at 75 and 85 degrees).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.surfaces.wedges import Wedges
from simulator.waves.band import HIGH_HZ

NODES_A_PIECE = 3  # in each piece
SHORTEST_PIECE_M = 1e-3
END_WINDOW_M = 0.12  # an apex nearer to an end differs from it by 1 cm of path at 1.5 m
WINDOWS = 3  # of each edge, by edge_view: the middle (APEX), START, END


@dataclass(frozen=True)
class EdgeNodes:
    """N nodes on the E edges of one convex panel, sorted by edge.

    Attributes:
        point_m: (N, 3).
        weight_m: (N,) of the quadrature.
        along, inwards: (N, 3) unit vectors of the node's edge.
        normal: (3,) of the face from which angles count.
        first: (E + 1,) where the nodes of each edge begin.
        share: (N, WINDOWS) of the node in the windows of its edge; they add up to 1.
    """

    point_m: Floats
    weight_m: Floats
    along: Floats
    inwards: Floats
    normal: Floats
    first: Ints
    share: Floats

    def __len__(self) -> int:
        return len(self.weight_m)


def nodes_of(wedges: Wedges, speed_m_s: float) -> EdgeNodes:
    """Nodes on all edges of one panel for frequencies up to the upper end of the band."""
    placed = [_on_line(length, 0.5 * speed_m_s / HIGH_HZ) for length in wedges.length_m]
    count = [len(height) for height, _ in placed]
    edge = np.repeat(np.arange(len(wedges)), count)
    height = np.concatenate([height for height, _ in placed])
    return EdgeNodes(
        wedges.start_m[edge] + height[:, None] * wedges.along[edge], np.concatenate([weight for _, weight in placed]),
        wedges.along[edge], wedges.inwards[edge], wedges.normal[0], np.concatenate([[0], np.cumsum(count)]),
        _shares(height, wedges.length_m[edge]),
    )  # fmt: skip


def _on_line(length_m: float, piece_m: float) -> tuple[Floats, Floats]:
    """Heights and weights of the nodes on one edge."""
    half, short = 0.5 * length_m, SHORTEST_PIECE_M
    graded = short * (2.0 ** np.arange(1, 16) - 1.0)
    graded = graded[(np.diff(graded, prepend=0.0) < piece_m) & (graded < half)]
    reached = graded[-1] if len(graded) else 0.0
    rest = np.linspace(reached, half, int(np.ceil((half - reached) / piece_m)) + 1)[1:]
    rising = np.concatenate([[0.0], graded, rest])
    border = np.concatenate([rising, length_m - rising[-2::-1]])
    x, w = np.polynomial.legendre.leggauss(NODES_A_PIECE)
    width = np.diff(border)[:, None]
    return (border[:-1, None] + width * (0.5 + 0.5 * x)).ravel(), (0.5 * width * w).ravel()


def _shares(height_m: Floats, length_m: Floats) -> Floats:
    """(N, WINDOWS) smooth windows of the middle, the start and the end."""
    reach = np.minimum(END_WINDOW_M, 0.5 * length_m)
    start, end = (
        np.where(x < reach, np.cos(0.5 * np.pi * x / reach) ** 2, 0.0) for x in (height_m, length_m - height_m)
    )  # 0 beyond, where rounding would leave 4e-33 and twice the work
    return np.stack([1.0 - start - end, start, end], axis=1)
