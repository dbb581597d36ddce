"""Creases that stand on a mirror, such as the foot of a bin: their wedge is that of a face and its image.

There the body's own lower face bounds no open space. A face that leans back by an angle a makes a wedge of pi + 2 a
with its image (as in `world.corners`), and none if it is upright. By images the field is W(S, R) + W(S', R), S' the
speaker's image. W(S, R) = W(S', R') and W(S', R) = W(S, R'), so each of the four pairs of ends brings half.

Beside full-wave values the body's own edge made echoes of upright bins 0.1-0.3 dB too faint, of those that narrow
upwards 0.5-0.7 dB; this wedge errs by 0.07 dB.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.kirchhoff.floors import gaps_to_floors
from simulator.surfaces.creases import Creases
from simulator.surfaces.facets import Facets
from simulator.world.corners import NARROWEST_RAD, STANDS_ON_M
from simulator.world.frames import rotated
from simulator.world.world import Tracing


def standing_on_mirrors(tracing: Tracing, facets: Facets) -> Facets:
    """The same facets, with the wedges of their creases where these stand on mirrors at the first pose.

    A corner of less than `NARROWEST_RAD` between face and mirror has no wave: sound is reflected in it more than three
    times.
    """
    creases, yaw = facets.creases, tracing.placed[0, facets.obstacle, 3]
    gap, plane = gaps_to_floors(tracing, 0, facets.obstacle, creases.middle_m, creases.normal)
    on = gap + 0.5 * np.abs(rotated(creases.along_m, yaw) @ plane.T) < STANDS_ON_M
    row = np.flatnonzero(on.any(axis=1))
    if not len(row):
        return facets
    plane = plane[on[row].argmax(axis=1)]
    up = np.sign(np.sum(rotated(creases.inwards[row], yaw) * plane, axis=1))
    lean = np.arcsin(np.clip(up * np.sum(rotated(creases.normal[row], yaw) * plane, axis=1), -1.0, 1.0))
    return replace(facets, creases=_with_images(creases, row, 0.5 * np.pi + lean))


def _with_images(creases: Creases, row: Ints, free_rad: Floats) -> Creases:
    """Creases of which some (R,) have an image of face 0 for face 1, with an angle (R,) free up to the mirror."""
    open_angle, beside, share = creases.open_angle_rad.copy(), creases.beside.copy(), creases.share.copy()
    open_angle[row], beside[row, 1] = 2.0 * free_rad, beside[row, 0]
    share[row] = np.where(free_rad >= NARROWEST_RAD, 0.5, 0.0)
    return replace(creases, open_angle_rad=open_angle, beside=beside, share=share)
