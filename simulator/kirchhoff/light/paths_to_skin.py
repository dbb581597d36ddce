"""The paths from an image of speaker or microphone to the pieces of a body's skin that face it, over its mirrors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from simulator.images.image_method import REACHED, backtrack, fill_images
from simulator.kirchhoff.light.views import Views
from simulator.surfaces.facets import Facets
from simulator.world.frames import rotated_back
from simulator.world.world import Tracing


class Skin(NamedTuple):
    """Where light on a body is asked for: close by one another in memory, since they are asked for again and again.

    Attributes:
        obstacle: the body.
        place_m: (I, 3) on the facets that speak.
        normal, standoff_m: (I, 3), (I,) of these.
        closed: whether they show on one side alone.
    """

    obstacle: int
    place_m: Floats
    normal: Floats
    standoff_m: Floats
    closed: bool

    @classmethod
    def of(cls, facets: Facets, rows: Ints) -> Skin:
        """Some of the facets."""
        middle, normal = facets.middle_m.take(rows, axis=0), facets.normal.take(rows, axis=0)
        return cls(facets.obstacle, middle, normal, facets.standoff_m.take(rows), facets.closed)


class Begins(NamedTuple):
    """Where the paths of V views begin: see `Views`, and (V, 4) where the body stands then."""

    pose: Ints
    order: Ints
    sequence: Ints
    start: Floats
    frame: Floats

    @classmethod
    def of(cls, tracing: Tracing, views: Views, obstacle: int) -> Begins:
        """Of the views of an obstacle."""
        frame = tracing.placed[views.pose, obstacle]
        return cls(views.pose, views.order, views.sequence, views.start_m, frame)


@compiled
def paths_to(mirrors, begins, skin, gap, view, piece):
    """Which of some views (R,) and pieces (R,) of a skin face each other through the mirrors of the view.

    Returns (P,) rows, and (K + 2, P, 3) where sound starts, its crossings of the mirrors `gap` off them, and
    the middle of the piece, off it by its clearance: the last ones of K + 2 where the view has fewer mirrors.
    """
    # numbers, not parts of arrays, as in `backtrack`
    sequence, start, frame, middle, normal = begins.sequence, begins.start, begins.frame, skin.place_m, skin.normal
    width = sequence.shape[1]
    row, stops = np.empty(len(view), np.int64), np.empty((width + 2, len(view), 3))
    turns, images, hits, foot = np.empty(width, np.int64), np.empty((width + 1, 3)), np.empty((width, 3)), np.empty(3)
    count, c, s, x, y, z = 0, 1.0, 0.0, 0.0, 0.0, 0.0
    for r in range(len(view)):
        v, f = view[r], piece[r]
        n, last = begins.pose[v], begins.order[v]
        if r == 0 or view[r - 1] != v:
            for k in range(width):
                turns[k] = sequence[v, k]
            fill_images(mirrors, n, start[v], turns, last, images)
            c, s = np.cos(frame[v, 3]), np.sin(frame[v, 3])
            east, north, z = images[last, 0] - frame[v, 0], images[last, 1] - frame[v, 1], images[last, 2] - frame[v, 2]
            x, y = rotated_back(east, north, c, s)
        i, j, k = normal[f, 0], normal[f, 1], normal[f, 2]
        rise = (x - middle[f, 0]) * i + (y - middle[f, 1]) * j + (z - middle[f, 2]) * k
        if skin.closed and rise <= 0.0:
            continue
        foot[0] = c * middle[f, 0] - s * middle[f, 1] + frame[v, 0]
        foot[1] = s * middle[f, 0] + c * middle[f, 1] + frame[v, 1]
        foot[2] = middle[f, 2] + frame[v, 2]
        if backtrack(mirrors, n, images, turns, last, foot, hits) != REACHED:
            continue
        offset = skin.standoff_m[f] if rise >= 0.0 else -skin.standoff_m[f]
        i, j = c * i - s * j, s * i + c * j
        _put(stops, width + 1, count, foot[0] + offset * i, foot[1] + offset * j, foot[2] + offset * k)
        here, there, up = start[v, 0], start[v, 1], start[v, 2]
        _put(stops, width - last, count, here, there, up)
        for m in range(last):
            i, j, k = mirrors.normal[n, turns[m], 0], mirrors.normal[n, turns[m], 1], mirrors.normal[n, turns[m], 2]
            above = (here - hits[m, 0]) * i + (there - hits[m, 1]) * j + (up - hits[m, 2]) * k
            offset = gap if above >= 0.0 else -gap
            here, there, up = hits[m, 0], hits[m, 1], hits[m, 2]
            _put(stops, width - last + 1 + m, count, here + offset * i, there + offset * j, up + offset * k)
        row[count] = r
        count += 1
    return row[:count], stops[:, :count]


@inlined
def _put(stops, place, row, x, y, z):
    """Fill in one of the stops of a path."""
    stops[place, row, 0], stops[place, row, 1], stops[place, row, 2] = x, y, z
