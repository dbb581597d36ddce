"""Quarters of facets, for where the border of a shadow runs: a facet is lit or it is not.

The rounded surface stands off a facet as a quadratic of its place. So it stands off each half of an edge, and off the
line between two edges' middles, a quarter as far as off the edge along it; and normals over a quarter of that shape
differ from its own by half as much as those over the whole.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.support.vectors import dot, norm
from simulator.surfaces.creases import Creases
from simulator.surfaces.facets import Facets

BLOCK_QUARTERS = 128  # quarters a block: borders of shadows are lines, and few blocks of these lie on them


def quartered(facets: Facets, some: Flags) -> Facets:
    """The same facets, and after them four quarters of some (F,).

    Where one of these stands for others, its middle quarter does now; where it lies beside a crease, its nearest.
    """
    rows = np.flatnonzero(some)
    columns = _quarters(facets.corner_m[rows], facets.normal[rows], facets.bulge_m[rows])
    columns |= {name: np.repeat(getattr(facets, name)[rows], 4) for name in ("standoff_m", "piece")}
    columns["part_of"] = np.repeat(rows, 4)
    aside = 0.5 * (facets.asked_m - facets.middle_m)[rows]  # the middle quarter stands upside down
    columns["asked_m"] = columns["middle_m"] + np.stack([aside, aside, aside, -aside], axis=1).reshape(-1, 3)
    columns["stands"] = (facets.stands[rows, None] & (np.arange(4) == 3)).ravel()
    joined: dict[str, Any] = {name: np.concatenate([getattr(facets, name), values]) for name, values in columns.items()}
    joined["stands"][rows] = False
    start = np.append(facets.start[:-1], np.arange(len(facets), len(joined["stands"]), BLOCK_QUARTERS))
    creases = _beside_quarters(facets, some, columns["middle_m"])
    return replace(facets, **joined, start=np.append(start, len(joined["stands"])), creases=creases)


def _quarters(corner_m: Floats, normal: Floats, bulge_m: Floats) -> dict[str, Any]:
    """What `Facets` says of the quarters (4 R) of facets: about each corner one, and that in the middle."""
    opposite = 0.5 * (corner_m[:, [1, 2, 0]] + corner_m[:, [2, 0, 1]]) + bulge_m[..., None] * normal[:, None]
    corner = np.repeat(opposite[:, None], 4, axis=1)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        corner[:, i, i], corner[:, i, j], corner[:, i, k] = corner_m[:, i], opposite[:, k], opposite[:, j]
    own, across = _flat(corner)
    whole, _ = _flat(corner_m)
    faces = np.sign(dot(whole, normal))[:, None]
    over = faces[:, None] * own + 0.5 * (normal - faces * whole)[:, None]
    over[:, 3] = normal
    rise = bulge_m.sum(axis=1) / 12.0  # a third of the bulges' sum is the mean over a quadratic triangle
    middle = corner.mean(axis=2) + (rise[:, None] * normal)[:, None]
    return {
        "corner_m": corner.reshape(-1, 3, 3), "middle_m": middle.reshape(-1, 3),
        "normal": (over / norm(over)[..., None]).reshape(-1, 3), "area_m2": 0.5 * across.ravel(),
        "bulge_m": np.repeat(0.25 * bulge_m, 4, axis=0),
    }  # fmt: skip


def _flat(corner_m: Floats) -> tuple[Floats, Floats]:
    """(..., 3) unit normals of flat triangles (..., 3, 3), and (...,) twice their areas."""
    across = np.cross(corner_m[..., 1, :] - corner_m[..., 0, :], corner_m[..., 2, :] - corner_m[..., 0, :])
    size = norm(across)
    return across / size[..., None], size


def _beside_quarters(facets: Facets, some: Flags, middle_m: Floats) -> Creases:
    """The creases beside the nearest of the quarters, at (4 R, 3), of some facets (F,)."""
    beside = facets.creases.beside
    element, face = np.nonzero(some[beside])
    first = 4 * (np.cumsum(some) - 1)[beside[element, face]]
    away = norm(middle_m[first[:, None] + np.arange(4)] - facets.creases.middle_m[element, None])
    nearest = beside.copy()
    nearest[element, face] = len(facets) + first + np.argmin(away, axis=1)
    return replace(facets.creases, beside=nearest)
