"""Normals and curvatures at the vertices of the smooth pieces of a mesh, by the best means that each piece allows.

A sphere, cylinder or cone is recognised as such; elsewhere a quadric is fitted round each vertex; a vertex that no
quadric fits takes the mean of what the facets round it show.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.repeated import repeated
from obstaclewatch.support.vectors import dot, norm
from simulator.meshes.pieces import components
from simulator.surfaces.round_bodies import recognised
from simulator.surfaces.vertex_fits import fit_quadrics, rings

AHEAD = 0.7  # cosine to an edge of those that lead on from it
DIAGONAL = 0.96  # of the longest edge: diagonals of facets LONG times longer than wide are 3 % longer than these
IN_LINE = 0.9998  # cosine: edges that lead on in opposite directions within a degree are one line
LONG = 4.0  # an edge so many times longer than its vertex's shortest runs along a straight line of the surface


def vertex_geometry(
    point_m: Floats, facet: Ints, facet_normal: Floats, mean_normal: Floats, held: Flags
) -> tuple[Floats, Floats]:
    """(V, 3) unit normals and (V, 3, 3) curvature tensors, dn = K dx, 1/m, at the vertices of smooth pieces.

    Args:
        point_m: (V, 3) vertices, split at creases.
        facet: (T, 3) vertices of the facets.
        facet_normal: (T, 3).
        mean_normal: (V, 3) first estimate, on the side to stay on.
        held: (V,) whether that estimate is exact (the vertex belongs to a flat panel as well).
    """
    pairs = facet[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    rim = _on_rim(pairs, len(point_m))
    held_slope = held | _on_strip(pairs, rim)
    normal, curvature, true = fit_quadrics(point_m, mean_normal, held_slope, rings(pairs, len(point_m)))
    edges = _Edges.of(point_m, pairs)
    true &= ~(rim & edges.short_beyond())
    long, along = edges.long()
    rows = np.flatnonzero(long & ~(true | held_slope))
    normal[rows], curvature[rows] = _straight(mean_normal[rows], curvature[rows], along[rows])
    refused = np.isnan(curvature[:, 0, 0])
    if refused.any():
        curvature[refused] = _mean_curvature(point_m, facet, normal)[refused]
    piece = components(pairs, len(point_m))
    for label in np.unique(piece):
        rows = np.flatnonzero(piece == label)
        body = None if held[rows].any() else recognised(point_m[rows], facet_normal[piece[facet[:, 0]] == label])
        if body is not None:
            side = np.sign(dot(body[0], mean_normal[rows]))
            normal[rows], curvature[rows] = side[:, None] * body[0], side[:, None, None] * body[1]
    return normal, curvature


def _straight(normal: Floats, curvature: Floats, along: Floats) -> tuple[Floats, Floats]:
    """Normals (V, 3) and curvatures (V, 3, 3) without a slope or bend along unit vectors (V, 3)."""
    upright = normal - dot(normal, along)[..., None] * along
    across = np.eye(3) - along[:, :, None] * along[:, None, :]
    return upright / norm(upright)[..., None], across @ curvature @ across


def _on_rim(pairs: Ints, count: int) -> Flags:
    """(count,) vertices at which a piece ends."""
    edge, used = np.unique(np.sort(pairs, axis=1), axis=0, return_counts=True)
    rim = np.zeros(count, dtype=bool)
    rim[edge[used == 1].ravel()] = True
    return rim


def _on_strip(pairs: Ints, rim: Flags) -> Flags:
    """(V,) vertices that, like all their neighbours, lie on a rim: nothing tells the slope across the strip."""
    strip = rim.copy()
    for a, b in (pairs.T, pairs.T[::-1]):
        strip[a[~rim[b]]] = False
    return strip


@dataclass(frozen=True)
class _Edges:
    """Edges in both directions, from each vertex the shortest first.

    Attributes:
        start: (V + 1,) where those of each vertex begin.
        to: (E,) vertices that they lead to.
        away_m, length_m: (E, 3) and (E,) from end to end.
    """

    start: Ints
    to: Ints
    away_m: Floats
    length_m: Floats

    @classmethod
    def of(cls, point_m: Floats, pairs: Ints) -> _Edges:
        """Of vertices (V, 3) and pairs of them, each once or more."""
        count = len(point_m)
        key = np.unique(np.concatenate([pairs @ [count, 1], pairs @ [1, count]]))
        one, other = key // count, key % count
        away = point_m[other] - point_m[one]
        length = norm(away)
        order = np.lexsort((length, one))
        return cls(np.searchsorted(one, np.arange(count + 1)), other[order], away[order], length[order])

    def short_beyond(self) -> Flags:
        """(V,) vertices beyond whose longest edge those that lead on are much shorter: a straight part ends there.

        The one row of long facets below a dome is straight. A quadric through its foot and the dome's first ring is
        not: it took the foot for tilted by 4 degrees, which made the corner with the ground 7 dB too loud.
        """
        longest = self.start[1:] - 1
        beyond = self.to[longest]
        count = self.start[beyond + 1] - self.start[beyond]
        owner, step = repeated(count)
        onward = step + self.start[beyond][owner]
        before, after = longest[owner], onward
        leads_on = dot(self.away_m[before], self.away_m[after]) > AHEAD * self.length_m[before] * self.length_m[after]
        most = np.zeros(len(beyond))
        np.maximum.at(most, owner[leads_on], self.length_m[onward[leads_on]])
        found: Flags = (most > 0.0) & (LONG * most < self.length_m[longest])
        return found

    def long(self) -> tuple[Flags, Floats]:
        """(V,) which vertices have an edge much longer than others, and (V, 3) its direction.

        Where a ball runs into a long fillet no quadric fits, and a small tilt would belly the fillet's long facets;
        meshes have long edges where the surface is straight along them. Of edges about as long as the longest it is the
        shortest: the others are diagonals, which a chord bends. Where one half as long leads back, as round a ring of
        few segments, the surface is straight only if they are in line.
        """
        owner = np.repeat(np.arange(len(self.start) - 1), np.diff(self.start))
        longest = self.length_m[self.start[1:] - 1]
        about = np.bincount(owner[self.length_m > DIAGONAL * longest[owner]], minlength=len(longest))
        chosen = self.start[1:] - about
        along = self.away_m[chosen] / self.length_m[chosen, None]
        ahead = dot(along[owner], self.away_m) / self.length_m
        opposite, rows = np.zeros(len(longest)), np.flatnonzero(self.length_m > 0.5 * longest[owner])
        np.minimum.at(opposite, owner[rows], ahead[rows])
        bent = (opposite < -AHEAD) & (opposite > -IN_LINE)
        return (longest > LONG * self.length_m[self.start[:-1]]) & ~bent, along


def _mean_curvature(point_m: Floats, facet: Ints, normal: Floats) -> Floats:
    """(V, 3, 3) mean over the facets round each vertex of the tensor that turns edges into changes of the normal."""
    edge = point_m[facet[:, [1, 2, 0]]] - point_m[facet]
    turn = normal[facet[:, [1, 2, 0]]] - normal[facet]
    tensor = np.einsum("tki,tkj->tij", turn, np.linalg.pinv(edge).transpose(0, 2, 1))
    total = np.zeros((len(point_m), 3, 3))
    np.add.at(total, facet.ravel(), np.repeat(0.5 * (tensor + tensor.transpose(0, 2, 1)), 3, axis=0))
    total /= np.maximum(np.bincount(facet.ravel(), minlength=len(point_m)), 1)[:, None, None]
    onto = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    return onto @ total @ onto
