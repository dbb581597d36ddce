"""Corners of two mirrors that are not square: the wedge that a face makes with its image in the mirror it stands on.

Where a flat face meets the ground at a right angle, face and mirrored face are one plane, and the corner's echo is that
of its image. Where the face leans by an angle a, they meet in a crease of open angle pi + 2 a. Its wave takes over
from the two double reflections, ground-face and face-ground, which end there (a > 0) or overlap (a < 0).

By images the field is W(S, R) + W(S', R), with W the field of face and mirrored face in the open and S' the speaker's
image. So each crease counts twice: by itself, and once with the mirror beside it.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import dot, norm
from simulator.surfaces.near_balls import touching
from simulator.surfaces.reflectors import PlanarPatches
from simulator.surfaces.wedges import Wedges
from simulator.world.mirrors import Planes, facing

SQUARE_SINE = 2e-7  # of the lean under which a corner is square: its two images, 4 times that apart at 1 m, are one
NARROWEST_RAD = np.pi / 3.0  # between face and mirror; in narrower corners sound is reflected more than three times
PARALLEL = 1e-3  # sine of the angle between planes that meet nowhere in particular
STANDS_ON_M = 2e-3  # a face whose border is this close to a mirror stands on it: an eighth of the wavelength
STEEP = 0.1  # cosine to a patch's normal from which an edge runs into it and not along it
SHORTEST_M = 0.01  # a crease of half a wavelength


def corner_wedges(patches: PlanarPatches, at_rest: Planes, velocity_m_s: Floats, carried: Flags) -> list[Wedges]:
    """Creases between faces and the mirrors that they stand on, of their own body or another, as all stand at time 0.

    A crease moves with its face, so the mirror goes along or rests, and the face stays on it. What goes with the
    walker stands on nothing.

    Args:
        patches: of all obstacles.
        at_rest: the same, to be asked which may follow which: others make no corner.
        velocity_m_s: (O, 3) of the obstacles.
        carried: (O,) obstacles that go with the walker.
    """
    face, mirror = _meeting(patches, at_rest, velocity_m_s, carried)
    return [each for i, j in zip(face, mirror, strict=True) for each in _creases(patches, int(i), int(j))]


def leaning_ends(wedges: Wedges, runs_on: Flags, patches: PlanarPatches, at_rest: Planes, carried: Flags) -> Ints:
    """(W, 2) patch into which an edge runs at its start and its end other than squarely, or -1.

    Args:
        wedges: where they stand at time 0.
        runs_on: (W, 2) whether any surface stands across the edge there.
        patches, at_rest, carried: as for `corner_wedges`.
    """
    found = np.full(runs_on.shape, -1)
    if len(patches) == 0:
        return found
    row, end = np.nonzero(runs_on)
    point = np.where((end == 0)[:, None], wedges.start_m[row], wedges.end_m[row])

    def leans(at: Ints, patch: Ints) -> Flags:
        normal, along = patches.normal[patch], wedges.along[row[at]]
        touches = np.abs(dot(point[at], normal) - patches.offset_m[patch]) < STANDS_ON_M
        touches &= (np.abs(dot(along, normal)) > STEEP) & (norm(np.cross(along, normal)) > SQUARE_SINE)
        touches &= ~(carried[patches.obstacle[patch]] | carried[wedges.obstacle[row[at]]])
        some = np.flatnonzero(touches)
        faces = wedges.patch[row[at[some]]]
        touches[some] = np.logical_or(*(facing(at_rest, face, patch[some]) for face in faces.T))  # type: ignore[call-arg]
        return touches

    at, patch = touching((point, np.zeros(len(point))), (patches.center_m, patches.radius_m), leans)
    found[row[at], end[at]] = patch
    return found


def _meeting(patches: PlanarPatches, at_rest: Planes, velocity_m_s: Floats, carried: Flags) -> tuple[Ints, Ints]:
    """Pairs of a face and the mirror on which it may stand aslant; of two that go together the wider is the mirror."""
    owner, radius, normal = patches.obstacle, patches.radius_m, patches.normal
    moves = carried | velocity_m_s.any(axis=1)

    def stands_on(face: Ints, mirror: Ints) -> Flags:
        wider = (radius[mirror] > radius[face]) | ((radius[mirror] == radius[face]) & (mirror < face))
        stays = dot(velocity_m_s[owner[face]], normal[mirror]) == 0.0
        together = at_rest.frame[owner[mirror]] == at_rest.frame[owner[face]]
        kept = np.where(together, wider, ~moves[owner[mirror]] & stays)
        return kept & ~carried[owner[face]]

    def meets(face: Ints, mirror: Ints) -> Flags:
        cosine = np.abs(dot(normal[face], normal[mirror]))
        kept = stands_on(face, mirror) & (cosine > SQUARE_SINE) & (cosine < np.sqrt(1.0 - PARALLEL**2))
        for one, other in ((face, mirror), (mirror, face)):
            height = dot(patches.center_m[one], normal[other]) - patches.offset_m[other]
            kept &= np.abs(height) <= radius[one] + STANDS_ON_M
        some = np.flatnonzero(kept)
        kept[some] = facing(at_rest, face[some], mirror[some])  # type: ignore[call-arg]
        return np.asarray(kept)

    return touching((patches.center_m, radius + STANDS_ON_M), (patches.center_m, radius), meets)


def _creases(patches: PlanarPatches, face: int, mirror: int) -> list[Wedges]:
    """Creases in the up to four sectors between two planes, where both patches bound the sector."""
    along = np.cross(patches.normal[face], patches.normal[mirror])
    along /= np.linalg.norm(along)
    origin = _common_point(patches, face, mirror)
    found = []
    for up in (1.0, -1.0):
        rise = up * _within(patches, face, mirror, along)
        for out in (1.0, -1.0):
            reach = out * _within(patches, mirror, face, along)
            free = _open(patches, face, reach) and _open(patches, mirror, rise)
            if not free or rise @ reach > np.cos(NARROWEST_RAD):
                continue
            both = _overlap(*(_runs(patches, i, origin, along, d) for i, d in ((face, rise), (mirror, reach))))
            found += [_crease(patches, face, mirror, origin + np.outer(run, along), rise, reach) for run in both]
    return found


def _common_point(patches: PlanarPatches, face: int, mirror: int) -> Floats:
    """(3,) the point on both planes nearest to the face's centre."""
    normals = np.stack([patches.normal[face], patches.normal[mirror]])
    miss = patches.offset_m[[face, mirror]] - normals @ patches.center_m[face]
    return patches.center_m[face] + np.linalg.lstsq(normals, miss, rcond=None)[0]


def _within(patches: PlanarPatches, plane: int, other: int, along: Floats) -> Floats:
    """(3,) unit vector within a plane, square to the crease, on the side of the other plane's normal."""
    direction = np.cross(along, patches.normal[plane])
    return direction * np.sign(direction @ patches.normal[other])


def _open(patches: PlanarPatches, patch: int, direction: Floats) -> bool:
    """Whether a patch reflects to the side to which a direction leads."""
    return bool(not patches.one_sided[patch] or direction @ patches.normal[patch] > 0.0)


def _runs(patches: PlanarPatches, patch: int, origin: Floats, along: Floats, across: Floats) -> Floats:
    """(K, 2) stretches of the crease, from an origin, beside which a patch reaches to the side `across`."""
    border = patches.edge_m[patches.edge_start[patch] : patches.edge_start[patch + 1]] - origin
    place, height = border @ along, border @ across - STANDS_ON_M
    crossed = (height[:, 0] > 0.0) != (height[:, 1] > 0.0)
    place, height = place[crossed], height[crossed]
    share = height[:, 0] / (height[:, 0] - height[:, 1])
    return np.sort(place[:, 0] + share * (place[:, 1] - place[:, 0])).reshape(-1, 2)


def _overlap(one: Floats, other: Floats) -> Floats:
    """(K, 2) what stretches (N, 2) and (M, 2) have in common, if it is long enough."""
    low = np.maximum(one[:, None, 0], other[None, :, 0]).ravel()
    high = np.minimum(one[:, None, 1], other[None, :, 1]).ravel()
    return np.column_stack([low, high])[high - low > SHORTEST_M]


def _crease(patches: PlanarPatches, face: int, mirror: int, ends_m: Floats, rise: Floats, reach: Floats) -> Wedges:
    """One crease; angles run from the face over the mirror's plane to the mirrored face."""
    cosine = float(rise @ reach)
    normal = reach - cosine * rise
    return Wedges(
        ends_m[:1], ends_m[1:], rise[None], (normal / np.linalg.norm(normal))[None],
        np.array([2.0 * np.arccos(cosine)]), np.array([[face, face]]), patches.obstacle[[face]], np.array([np.inf]),
        np.ones((1, 2), dtype=bool), np.array([mirror]), np.full((1, 2), -1),
    )  # fmt: skip
