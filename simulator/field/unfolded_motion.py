"""Retarded times of paths over planes and points that are given: mirrors, cells of bodies, chains of edges.

Planes are unfolded and points move with their obstacles, so a path's length is a sum of distances between images, and
its retarded time settles by fixed point without any search. Most paths are such; they are followed by compiled code.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.vectors import norm
from simulator.images.given_planes import fill_image
from simulator.scene.pose import Walk
from simulator.world.candidates import Candidates
from simulator.world.frames import into_rest
from simulator.world.interactions import Interaction
from simulator.world.world import Tracing

STEP_S = 1e-3  # of a walk's splines: they follow a gait to 1e-11 m
MARGIN_S = 2e-3
SPEAKER, MICS, WALKER = 0, 3, 9  # columns of a track


class Track(NamedTuple):
    """Speaker, microphones and walker as cubic splines of time; a tuple, as compiled functions take it.

    Attributes:
        start_s: of the first piece; each lasts `STEP_S`.
        pieces: (n, 13, 4) coefficients, lowest power of the time within a piece first.
    """

    start_s: float
    pieces: Floats

    def at(self, column: Ints, time_s: Floats, count: int) -> Floats:
        """(R, count) neighbouring columns from the given (R,) on, each row at an instant."""
        values = np.empty((len(time_s), count))
        _read(self, column, time_s, values)
        return values

    def carrier(self, _pose: Ints, time_s: Floats) -> tuple[Floats, Floats]:
        """(R, 3) and (R,) place and heading of the walker at instants."""
        walker = self.at(np.full(len(time_s), WALKER), time_s, 4)
        return walker[:, :3], walker[:, 3]


class _Unfolded(NamedTuple):
    """C paths over up to N planes and given points, as `_follow` takes them.

    Attributes:
        along: (C, N + 1) length of each up to its points after the speaker, m.
        order, mic: (C,) number of these between the ends, and microphone.
        mirror: (C, N) whether it is reflected off a plane.
        normal, offset: (C, N, 3) and (C, N) planes at rest.
        point: (C, N, 3) given points at rest.
        obstacle: (C, N) whose.
        first: (C,) which is the first given point.
        moves: (C,) whether any of these obstacles does.
    """

    along: Floats
    order: Ints
    mic: Ints
    mirror: Flags
    normal: Floats
    offset: Floats
    point: Floats
    obstacle: Ints
    first: Ints
    moves: Flags


def track_of(walk: Walk, phone_points: tuple[Floats, Floats], origin_m: Floats, first_s: float, last_s: float) -> Track:
    """The walk between two instants, about an origin; `phone_points` are (3,) speaker and (2, 3) microphones."""
    time = np.arange(first_s - MARGIN_S, last_s + MARGIN_S + STEP_S, STEP_S)
    pose = walk.pose(time)
    points = pose.to_world(np.concatenate([phone_points[0][None], phone_points[1]])) - origin_m
    heading = np.unwrap(pose.body_heading_rad())
    columns = np.column_stack([points.reshape(len(time), 9), pose.position_m - origin_m, heading])
    return Track(time[0], np.ascontiguousarray(CubicSpline(time, columns).c[::-1].transpose(1, 2, 0)))


def is_unfolded(found: Candidates) -> Flags:
    """(C,) whether a path meets planes and given points alone: no smooth surface, and no edge whose apex drifts."""
    return (found.edge < 0) & ~np.any(found.interaction == Interaction.CURVED, axis=1)


def retarded(
    tracing: Tracing, track: Track, found: Candidates, reception_s: Floats, speed_m_s: float, count: int
) -> tuple[Floats, Floats]:
    """(C, M) path length, and as far as the first given point, of paths that arrive at (C, M) instants.

    Args:
        count: of retardations.
    """
    world, frames = tracing.world, tracing.frames
    mirror = found.interaction == Interaction.SPECULAR
    patch = np.where(mirror, found.sequence, 0)
    normal, offset = np.zeros(found.normal.shape), np.zeros(mirror.shape)
    normal[mirror], offset[mirror] = world.patches.normal[patch[mirror]], world.patches.offset_m[patch[mirror]]
    obstacle = world.obstacle_of(found.sequence)
    point = found.points_m[:, 1:-1].copy()
    given = (found.interaction >= 0) & ~mirror
    placed = tracing.placed[np.broadcast_to(found.pose[:, None], given.shape)[given], obstacle[given]]
    point[given] = into_rest(point[given], placed)
    segments = norm(np.diff(found.points_m, axis=1))
    moves = np.append(frames.moves, False)
    paths = _Unfolded(
        np.cumsum(segments, axis=1), found.order, found.mic, mirror, normal, offset, point, obstacle,
        np.argmax(given, axis=1), np.any(moves[obstacle], axis=1),
    )  # fmt: skip
    return _follow(reception_s, paths, frames.velocity_m_s, frames.carried, track, speed_m_s, count)


@compiled
def _follow(reception, paths, velocity, carried, track, speed, count):
    """Every path at every instant; where something moves, each retardation unfolds it anew."""
    along, order, mic, mirror, normal, offset, point, obstacle, first, moves = paths
    length, before = np.empty(reception.shape), np.zeros(reception.shape)
    width = mirror.shape[1]
    images, planes, frame = np.zeros((width + 2, 3)), np.zeros((width, 4)), np.zeros(4)
    struck, fixed = np.empty(width), np.zeros(width + 1)
    for c in range(len(reception)):
        for k in range(4):
            frame[k] = 0.0
        reflections = mirror[c, : order[c]], normal[c], offset[c], point[c], obstacle[c]
        for m in range(reception.shape[1]):
            time, path = reception[c, m], along[c, -1]
            _on_track(track, MICS + 3 * mic[c], time, images[order[c] + 1])
            if not moves[c]:
                rest = _unfold_back(reflections, images)
                for _ in range(count):
                    _on_track(track, SPEAKER, time - path / speed, images[0])
                    path = rest + _distance(images, 0, 1)
                length[c, m], before[c, m] = path, path - rest
                continue
            for k in range(width):
                struck[k] = along[c, k] / speed
            for _ in range(count):
                emitted = time - path / speed
                _on_track(track, SPEAKER, emitted, images[0])
                for k in range(order[c]):
                    _place(obstacle[c, k], emitted + struck[k], velocity, carried, track, frame)
                    _unfold(reflections, k, frame, images, planes, fixed)
                path = fixed[order[c]] + _distance(images, order[c], order[c] + 1)
                _strike(reflections[0], images, planes, fixed, speed, struck)
            length[c, m], before[c, m] = path, fixed[first[c] + 1]
    return length, before


@inlined
def _unfold_back(reflections, images):
    """Fill in what the speaker sees of the receiver or the first given point, and return the path from there on."""
    mirror, normal, offset, point, _ = reflections
    rest = 0.0
    for k in range(len(mirror) - 1, -1, -1):
        here, there = images[k + 1], images[k + 2]
        if mirror[k]:
            fill_image(there, normal[k], offset[k], here)
        else:
            for i in range(3):
                here[i] = point[k, i]
            rest += _distance(images, k + 1, k + 2)
    return rest


@inlined
def _unfold(reflections, k, frame, images, planes, fixed):
    """Fill in the image after reflection k in its frame, its plane, and the path to the last given point."""
    mirror, normal, offset, point, _ = reflections
    rest = normal if mirror[k] else point
    x, y, z = rest[k, 0], rest[k, 1], rest[k, 2]
    if frame[3] != 0.0:
        cosine, sine = np.cos(frame[3]), np.sin(frame[3])
        x, y = cosine * x - sine * y, sine * x + cosine * y
    if mirror[k]:
        height = offset[k] + x * frame[0] + y * frame[1] + z * frame[2]
        planes[k, 0], planes[k, 1], planes[k, 2], planes[k, 3] = x, y, z, height
        fill_image(images[k], planes[k], height, images[k + 1])
        fixed[k + 1] = fixed[k]
    else:
        images[k + 1, 0], images[k + 1, 1], images[k + 1, 2] = x + frame[0], y + frame[1], z + frame[2]
        fixed[k + 1] = fixed[k] + _distance(images, k, k + 1)


@inlined
def _strike(mirror, images, planes, fixed, speed, struck):
    """Fill in how long after emission every reflector is struck, from the receiver back."""
    last = len(mirror) + 1
    x, y, z = images[last, 0], images[last, 1], images[last, 2]
    for k in range(len(mirror) - 1, -1, -1):
        a, b, c = images[k + 1, 0], images[k + 1, 1], images[k + 1, 2]
        share = 1.0
        if mirror[k]:
            here = planes[k, 0] * x + planes[k, 1] * y + planes[k, 2] * z - planes[k, 3]
            there = planes[k, 0] * a + planes[k, 1] * b + planes[k, 2] * c - planes[k, 3]
            share = here / (here - there) if here != there else 0.0
        x, y, z = x + share * (a - x), y + share * (b - y), z + share * (c - z)
        left = np.sqrt((a - x) ** 2 + (b - y) ** 2 + (c - z) ** 2)
        struck[k] = (fixed[k + 1] + left) / speed


@compiled
def _distance(images, a, b):
    x, y, z = images[a, 0] - images[b, 0], images[a, 1] - images[b, 1], images[a, 2] - images[b, 2]
    return np.sqrt(x * x + y * y + z * z)


@inlined
def _place(obstacle, time, velocity, carried, track, frame):
    """Fill in shift and yaw of an obstacle at an instant, as `Frames.of` has them."""
    if carried[obstacle]:
        _on_track(track, WALKER, time, frame)
    else:
        for i in range(3):
            frame[i] = time * velocity[obstacle, i]
        frame[3] = 0.0


@compiled
def _read(track, column, time, values):
    """Fill in (R, n) columns at R instants."""
    for r in range(len(time)):
        _on_track(track, column[r], time[r], values[r])


@compiled
def _on_track(track, column, time, value):
    """Fill in as many columns as there is room for."""
    start, pieces = track
    at = min(max(int((time - start) / STEP_S), 0), len(pieces) - 1)
    t = time - start - at * STEP_S
    for i in range(len(value)):
        value[i] = pieces[at, column + i, 0] + t * (
            pieces[at, column + i, 1] + t * (pieces[at, column + i, 2] + t * pieces[at, column + i, 3])
        )
