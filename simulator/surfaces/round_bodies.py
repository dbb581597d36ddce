"""Spheres, cylinders and cones recognised in a mesh, whose true normals and curvatures are then known at every vertex.

A strip between two rims says nothing of its own about the bend across it, and vertices rounded to float32 blur the
normals of a fine mesh; a sphere or cone fitted to all of them suffers neither.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.vectors import norm

MISFIT = 1e-5  # of the radius: far above rounding, and a thousandth of what the flat facets miss at 64 segments
ROUNDING = 2.0**-22  # of the largest coordinate: vertices that went through float32
SPARE = 3  # vertices beyond the number of unknowns that must agree before a fit counts
NO_CONE = 4.0  # times what a cone may miss by: what misses every quadric by more is none (its radius is a guess)
ON_CIRCLE = 0.2  # of its radius: vertices rounded to 1 mm turn the facets of a pole of 2 cm by as much
FEW = 96  # vertices that are asked first of a mesh of many: what they do not lie on, all of them do not


def recognised(point_m: Floats, facet_normal: Floats) -> tuple[Floats, Floats] | None:
    """(V, 3) unit normals and (V, 3, 3) curvature tensors, dn = K dx, of the body that all the vertices lie on.

    Args:
        point_m: (V, 3) vertices of one smooth piece.
        facet_normal: (T, 3) normals of its facets.

    Returns:
        Normals that point away from the centre or the axis; None if the piece is no sphere, cylinder or cone.
    """
    if len(point_m) < 4 + SPARE:
        return None
    shift, size = point_m.mean(axis=0), np.ptp(point_m, axis=0).max()
    slack = ROUNDING * np.abs(point_m).max() / size
    scaled = (point_m - shift) / size
    found = _cone(scaled, facet_normal, slack) if len(point_m) >= 6 + SPARE else None
    if found is None and not _round_an_axis(facet_normal):  # two rims of a cylinder lie on a sphere as well
        found = _sphere(scaled, slack)
    return None if found is None else (found[0], found[1] / size)


def _fits(misfit: Floats, radius: float, slack: float) -> bool:
    return bool(np.abs(misfit).max() <= MISFIT * radius + slack)


def _round_an_axis(facet_normal: Floats) -> bool:
    """Whether normals (T, 3) are those of one strip of a cylinder or cone: on a circle, unlike those of a sphere."""
    basis = np.linalg.eigh(np.cov(facet_normal.T))[1][:, 1:]
    across = facet_normal @ basis
    x, y, radius = _circle(across)
    return bool(np.abs(np.hypot(*(across - [x, y]).T) - radius).max() <= ON_CIRCLE * radius)


def _sphere(point: Floats, slack: float) -> tuple[Floats, Floats] | None:
    """|x|^2 = 2 c . x + d, linear in centre and d."""
    matrix = np.column_stack([2.0 * point, np.ones(len(point))])
    solution, _, rank, _ = np.linalg.lstsq(matrix, np.sum(point**2, axis=1), rcond=1e-9)
    square = solution[3] + solution[:3] @ solution[:3]
    if rank < 4 or not 0.0 < square < 1e4:
        return None
    radius = float(np.sqrt(square))
    away = point - solution[:3]
    distance = norm(away)
    if not _fits(distance - radius, radius, slack):
        return None
    normal = away / distance[:, None]
    return normal, (np.eye(3) - normal[:, :, None] * normal[:, None, :]) / radius


def _cone(point: Floats, facet_normal: Floats, slack: float) -> tuple[Floats, Floats] | None:
    """Cylinder or cone, distance from the axis = r + s z, from the axis that the facet normals suggest."""
    spread = facet_normal - facet_normal.mean(axis=0)
    axis = np.linalg.eigh(spread.T @ spread)[1]
    start, basis = axis[:, 0], axis[:, 1:]
    first = _circle(point @ basis)
    guess = np.concatenate([[0.0, 0.0], first, [0.0]])
    if not np.isfinite(guess).all() or np.abs(_misfit(guess, point, start, basis)).max() > 0.5 * first[2]:
        guess = _tapered(point, start, basis)
        if not np.abs(_misfit(guess, point, start, basis)).max() < 0.1:
            return None
    few = point[:: max(len(point) // FEW, 1)]
    if not _on_quadric(few, NO_CONE * (MISFIT * float(norm(_radial(guess, few, start, basis)[1]).max()) + slack)):
        return None
    if len(few) < len(point) and _fitted(guess, few, start, basis, slack) is None:
        return None
    shape = _fitted(guess, point, start, basis, slack)
    return None if shape is None else _cone_geometry(shape, point, start, basis)


def _on_quadric(point: Floats, most: float) -> bool:
    """Whether the values of some quadric with coefficients of norm 1 are within `most` at points (V, 3), rms.

    A cone is a quadric whose coefficients have a norm of sqrt(2) and of twice the radius at least: its values are no
    more than the points' distances from it.
    """
    x, y, z = point.T
    columns = np.column_stack([x * x, y * y, z * z, x * y, y * z, z * x, x, y, z, np.ones(len(point))])
    return bool(np.linalg.eigvalsh(columns.T @ columns)[0] <= len(point) * most**2)


def _fitted(guess: Floats, point: Floats, start: Floats, basis: Floats, slack: float) -> Floats | None:
    """(6,) shape of the cone that all the points (V, 3) lie on, None if they lie on none."""
    best = least_squares(_misfit, guess, args=(point, start, basis), xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=60)
    radius = float(norm(_radial(best.x, point, start, basis)[1]).max())
    return best.x if radius <= 50.0 and _fits(best.fun, radius, slack) else None


def _circle(point: Floats) -> Floats:
    """Centre and radius of the circle nearest to (V, 2) points."""
    matrix = np.column_stack([2.0 * point, np.ones(len(point))])
    x, y, d = np.linalg.lstsq(matrix, np.sum(point**2, axis=1), rcond=None)[0]
    return np.array([x, y, np.sqrt(max(d + x * x + y * y, 0.0))])


def _tapered(point: Floats, start: Floats, basis: Floats) -> Floats:
    """(6,) shape of the upright cone nearest to (V, 3) points: |x|^2 is linear in its foot and quadratic in height."""
    across, height = point @ basis, point @ start
    matrix = np.column_stack([2.0 * across, np.ones(len(point)), height, height**2])
    foot = np.linalg.lstsq(matrix, np.sum(across**2, axis=1), rcond=None)[0][:2]
    radius = norm(across - foot)
    straight = np.linalg.lstsq(matrix[:, 2:4], radius, rcond=None)[0]
    return np.concatenate([[0.0, 0.0], foot, straight])


def _radial(shape: Floats, point: Floats, start: Floats, basis: Floats) -> tuple[Floats, Floats, Floats]:
    """(3,) unit axis, (V, 3) vectors from it, (V,) heights along it; shape = tilt (2), foot (2), radius, slope."""
    axis = start + basis @ shape[:2]
    axis /= np.linalg.norm(axis)
    offset = point - basis @ shape[2:4]
    height = offset @ axis
    return axis, offset - height[:, None] * axis, height


def _misfit(shape: Floats, point: Floats, start: Floats, basis: Floats) -> Floats:
    _, away, height = _radial(shape, point, start, basis)
    return norm(away) - shape[4] - shape[5] * height


def _cone_geometry(shape: Floats, point: Floats, start: Floats, basis: Floats) -> tuple[Floats, Floats] | None:
    """Normals away from the axis, and curvature 1 / (r sqrt(1 + s^2)) round it; None with a vertex on the axis."""
    axis, away, _ = _radial(shape, point, start, basis)
    radius = norm(away)
    if radius.min() < 1e-6 * radius.max():
        return None
    lean = np.sqrt(1.0 + shape[5] ** 2)
    outwards = away / radius[:, None]
    around = np.cross(axis, outwards)
    normal = (outwards - shape[5] * axis) / lean
    return normal, around[:, :, None] * around[:, None, :] / (lean * radius)[:, None, None]
