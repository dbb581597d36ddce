"""Motion within a beep: what leaves at t_e arrives at t_r = t_e + L / c, with every end where it then is.

Speaker at emission, every reflector when it is struck, microphone at reception. The retarded times are solved at a
few Chebyshev nodes of each beep and carried between them by polynomials; Doppler follows from them by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import dot, norm
from simulator.curved import stationary as curved
from simulator.diffraction.edge_view import APEX, seen
from simulator.diffraction.single import edge_points, point_slot
from simulator.field.unfolded_motion import MICS, SPEAKER, Track, is_unfolded, retarded, track_of
from simulator.images.given_planes import crossings_in_turn, images_in_turn, mirrors_about
from simulator.scene.pose import Walk, poses_of
from simulator.scene.scene import Obstacle
from simulator.waves.spreading import spreading
from simulator.world.candidates import Candidates
from simulator.world.frames import rotated, wedges_out_of_rest
from simulator.world.interactions import Interaction
from simulator.world.world import Tracing

SETTLED_S = 7e-13  # of delay may be left: 1e-7 rad of 20 kHz
BENT_S = 3e-10  # 1e-7 m of path
LEAST_M_S = 0.1  # phone and obstacle together, however still they stand
SPEEDS_A_BEEP = 10  # of the phone, over equal parts of a beep
FOLLOWED_M = 3e-4  # 0.2 rad of phase there and back; gait departs by 1e-6 m in 50 ms, by 2e-4 m in 200 ms
LEAST_DEGREE = 3  # asked of every walk, whatever degree a level of fidelity goes without


@dataclass(frozen=True)
class Motion:
    """Delay and strength of each path as polynomials of reception time.

    Attributes:
        middle_s: (C,) reception time at which the polynomials' variable is 0.
        half_width_s: reception time from the middle to where the variable is 1.
        delay_s: (C, D + 1) Chebyshev coefficients of the travel time.
        strength: (C, D + 1) Chebyshev coefficients of amplitude times length, relative to the middle of the beep.
    """

    middle_s: Floats
    half_width_s: float
    delay_s: Floats
    strength: Floats

    def __getitem__(self, mask: NDArray) -> Motion:
        """The motion of the paths that a mask selects."""
        return Motion(self.middle_s[mask], self.half_width_s, self.delay_s[mask], self.strength[mask])


@dataclass(frozen=True)
class Moment:
    """Geometry of R paths at one instant each: points (R, N + 2, 3), normals, curvatures, place on smooth surfaces."""

    points_m: Floats
    normal: Floats
    curvature: Floats
    face: Ints
    uv: Floats

    def struck_s(self, emission_s: Floats, speed_m_s: float) -> Floats:
        """(R, N) when each reflection point is struck."""
        segments = norm(np.diff(self.points_m, axis=1))
        return emission_s[:, None] + np.cumsum(segments[:, :-1], axis=1) / speed_m_s

    def length_m(self) -> Floats:
        """(R,) length of each path."""
        return norm(np.diff(self.points_m, axis=1)).sum(axis=1)


@dataclass(frozen=True)
class _Flight:
    """What all sound of a walk has in common.

    Attributes:
        tracing: the world, whose frames follow the walk.
        track: speaker and microphones.
        speed_m_s: of sound.
        count: retardations that settle a delay.
    """

    tracing: Tracing
    track: Track
    speed_m_s: float
    count: int


def motion_within(
    tracing: Tracing, walk: Walk, phone_points: tuple[Floats, Floats], found: Candidates,
    beep_start_s: Floats, beep_s: float, speed_m_s: float, degree: int,
) -> Motion:  # fmt: skip
    """Follow paths found at the middle of their beeps from their first instant to their last.

    Args:
        phone_points: (3,) speaker and (2, 3) microphones in the phone frame.
        beep_start_s: (N,) emission of each beep; `found.pose` counts beeps.
        beep_s: length of a beep.
        degree: of the polynomials; `degree + 1` instants are solved for each path.
    """
    start = beep_start_s[found.pose]
    middle = start + found.length_m / speed_m_s + 0.5 * beep_s
    half = 0.505 * beep_s  # the Doppler shift lengthens or shortens the beep by up to a percent
    node = _nodes(degree)
    reception = middle[:, None] + half * node
    delay, amplitude = np.empty(reception.shape), np.empty(reception.shape)
    unfolded, curve = is_unfolded(found), _meets_one_curve(tracing, found)
    if len(found):
        count = _retardations(tracing, walk, beep_start_s, beep_s, speed_m_s)
        first = (reception - (found.length_m / speed_m_s)[:, None]).min()
        track = track_of(walk, phone_points, tracing.world.origin_m, first, reception.max())
        along_walk = replace(tracing, frames=replace(tracing.frames, carrier=track.carrier))
        flight, others = _Flight(along_walk, track, speed_m_s, count), ~unfolded & ~curve
        for rows, follow in ((unfolded, _over_planes), (curve, _over_a_curve), (others, _over_curves)):
            if rows.any():
                delay[rows], amplitude[rows] = follow(flight, found[rows], reception[rows])
    fit = np.linalg.inv(chebyshev.chebvander(node, degree)).T
    at_centre = _amplitude(found, found.points_m, found.normal, found.curvature) * found.length_m
    strength = amplitude * delay * speed_m_s / at_centre[:, None]
    return Motion(middle, half, delay @ fit, strength @ fit)


def fastest_closing_m_s(obstacles: Sequence[Obstacle], walk: Walk, start_s: Floats, beep_s: float) -> float:
    """Most at which phone and an obstacle may close in: the phone in any part of a beep, and the fastest obstacle."""
    instants = start_s[:, None] + np.linspace(0.0, beep_s, SPEEDS_A_BEEP + 1)
    place = walk.pose(instants.ravel()).position_m.reshape(*instants.shape, 3)
    fastest = max((float(np.linalg.norm(obstacle.velocity_m_s)) for obstacle in obstacles), default=0.0)
    return float(norm(np.diff(place, axis=1)).max()) * SPEEDS_A_BEEP / beep_s + fastest


def velocities_of(walk: Walk, phone_points: tuple[Floats, Floats], middle_s: Floats, beep_s: float) -> Floats:
    """(N, 3, 3) of speaker and microphones about the middles of beeps: by how far half a beep takes them."""
    points, half = np.vstack([phone_points[0], phone_points[1]]), 0.25 * beep_s
    before, after = (poses_of(walk, middle_s + shift_s) for shift_s in (-half, half))
    return np.stack([(after.to_world(point) - before.to_world(point)) / (2.0 * half) for point in points], axis=1)


def check_smooth(walk: Walk, phone_points: tuple[Floats, Floats], start_s: Floats, beep_s: float, degree: int) -> None:
    """Refuse motion within a beep that polynomials do not follow.

    Args:
        phone_points: (3,) speaker and (2, 3) microphones in the phone frame.
        start_s: (N,) emission of each beep.
        degree: of the polynomials.

    Raises:
        ValueError: a transducer departs from them by more than `FOLLOWED_M`.
    """
    degree = max(degree, LEAST_DEGREE)
    node, between = _nodes(degree), np.linspace(-1.0, 1.0, 4 * degree + 5)
    points = np.vstack([phone_points[0], phone_points[1]])

    def places(x: Floats) -> Floats:
        """(N, M, 3, 3)."""
        pose = walk.pose((start_s[:, None] + 0.5 * beep_s * (1.0 + x)).ravel())
        return np.stack([pose.to_world(point) for point in points], axis=1).reshape(len(start_s), len(x), 3, 3)

    onto = chebyshev.chebvander(between, degree) @ np.linalg.inv(chebyshev.chebvander(node, degree))
    missed = norm(np.einsum("mn,bnpx->bmpx", onto, places(node)) - places(between)).max(axis=(1, 2))
    worst = int(missed.argmax())
    if missed[worst] > FOLLOWED_M:
        raise ValueError(
            f"a polynomial of degree {degree} must follow the phone within each beep to {1e3 * FOLLOWED_M:g} mm, got "
            f"{1e3 * missed[worst]:.2g} mm in the beep at {start_s[worst]:.3f} s"
        )


def _nodes(degree: int) -> Floats:
    """(D + 1,) Chebyshev nodes of a beep, -1 to 1."""
    return -np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))


def _retardations(tracing: Tracing, walk: Walk, start_s: Floats, beep_s: float, speed_m_s: float) -> int:
    """How many settle the delays: each gains a factor of closing speed over c, from half a beep's motion on."""
    if not len(start_s):
        return 1
    closing = max(fastest_closing_m_s(tracing.world.obstacles, walk, start_s, beep_s), LEAST_M_S) / speed_m_s
    return int(np.ceil(np.log(SETTLED_S / (0.5 * beep_s * closing)) / np.log(closing)))


def _over_planes(flight: _Flight, found: Candidates, reception_s: Floats) -> tuple[Floats, Floats]:
    """(C, M) travel time and amplitude of paths over planes and given points that arrive at (C, M) instants."""
    length, before = retarded(flight.tracing, flight.track, found, reception_s, flight.speed_m_s, flight.count)
    point = np.broadcast_to((found.cell >= 0)[:, None], length.shape)
    amplitude = 1.0 / length
    part = np.broadcast_to(found.part[:, None], length.shape)[point]
    amplitude[point] = _point_spreading(part, before[point], (length - before)[point])
    return length / flight.speed_m_s, amplitude


def _meets_one_curve(tracing: Tracing, found: Candidates) -> Flags:
    """(C,) whether a path meets one smooth surface and, besides, only mirrors that stand still."""
    mirror = found.interaction == Interaction.SPECULAR
    moves = np.append(tracing.frames.moves, False)[tracing.world.obstacle_of(found.sequence)]
    curves = np.sum(found.interaction == Interaction.CURVED, axis=1)
    met = np.any(mirror & moves, axis=1) | (found.edge >= 0) | (found.cell >= 0)
    flags: Flags = (curves == 1) & ~met
    return flags


def _over_a_curve(flight: _Flight, found: Candidates, reception_s: Floats) -> tuple[Floats, Floats]:
    """`_over_curves` where one surface is met: delays settle by its point alone, and all else is worked out once."""
    rows, reception = found[np.repeat(np.arange(len(found)), reception_s.shape[1])], reception_s.ravel()
    receiver = flight.track.at(MICS + 3 * rows.mic, reception, 3)
    guess = Moment(rows.points_m, rows.normal, rows.curvature, rows.face.copy(), rows.uv.copy())
    settled, ahead = _settled(flight, rows, reception, receiver, guess)
    source = flight.track.at(np.full(len(rows), SPEAKER), reception - settled, 3)
    moment = _solved(flight.tracing, rows, source, receiver, (reception - settled)[:, None] + ahead, guess)
    delay = (moment.length_m() / flight.speed_m_s).reshape(reception_s.shape)
    amplitude = _amplitude(rows, moment.points_m, moment.normal, moment.curvature).reshape(reception_s.shape)
    # At a crossing that would run off, paths are not straight from image to image.
    bent = np.any(np.abs(delay - settled.reshape(reception_s.shape)) > BENT_S, axis=1)
    if bent.any():
        delay[bent], amplitude[bent] = _over_curves(flight, found[bent], reception_s[bent])
    return delay, amplitude


def _settled(
    flight: _Flight, found: Candidates, reception_s: Floats, receiver: Floats, guess: Moment
) -> tuple[Floats, Floats]:
    """(R,) travel times over straight lines from the images of both ends to a surface, and (R, N) until it is struck.

    All retardations but the last. The guess is left with the facets and the places in them that are struck.
    """
    tracing, track, speed_m_s = flight.tracing, flight.track, flight.speed_m_s
    every, place = np.arange(len(found)), np.argmax(found.interaction == Interaction.CURVED, axis=1)
    normal, offset = _planes(tracing, found, np.zeros(found.sequence.shape))
    early, late = mirrors_about(found, place, place)
    received = images_in_turn(receiver, normal, offset, late)[0]
    delay, ahead = found.length_m / speed_m_s, guess.struck_s(np.zeros(len(found)), speed_m_s)
    point, met = np.empty(receiver.shape), found.sequence[every, place]
    for _ in range(flight.count - 1):
        emission = reception_s - delay
        lit = images_in_turn(track.at(np.full(len(found), SPEAKER), emission, 3), normal, offset, early)[-1]
        for index, surface in enumerate(tracing.world.surfaces):
            rows = np.flatnonzero(met == tracing.world.numbering.number(Interaction.CURVED, index))
            at, struck = place[rows], emission[rows] + ahead[rows, place[rows]]
            frame = tracing.frames.of(np.full(len(rows), surface.obstacle), found.pose[rows], struck)
            known = guess.face[rows, at], guess.uv[rows, at]
            hit = curved.follow_point(surface, frame, lit[rows], received[rows], *known)
            point[rows], guess.face[rows, at], guess.uv[rows, at] = hit
        before = norm(point - lit)
        ahead[every, place], delay = before / speed_m_s, (before + norm(received - point)) / speed_m_s
    return delay, ahead


def _over_curves(flight: _Flight, found: Candidates, reception_s: Floats) -> tuple[Floats, Floats]:
    """(C, M) travel time and amplitude of paths over smooth surfaces and edges, whose points are searched anew."""
    found, reception = found[np.repeat(np.arange(len(found)), reception_s.shape[1])], reception_s.ravel()
    receiver = flight.track.at(MICS + 3 * found.mic, reception, 3)
    moment = Moment(found.points_m, found.normal, found.curvature, found.face, found.uv)
    delay = moment.length_m() / flight.speed_m_s
    for _ in range(flight.count):
        emission = reception - delay
        source = flight.track.at(np.full(len(found), SPEAKER), emission, 3)
        moment = _solved(flight.tracing, found, source, receiver, moment.struck_s(emission, flight.speed_m_s), moment)
        delay = moment.length_m() / flight.speed_m_s
    amplitude = _amplitude(found, moment.points_m, moment.normal, moment.curvature)
    return delay.reshape(reception_s.shape), amplitude.reshape(reception_s.shape)


def _amplitude(found: Candidates, points_m: Floats, normal: Floats, curvature: Floats) -> Floats:
    """(R,) spreading of each path; the strengths of edges and cells are held, their spreading alone follows."""
    amplitude = np.empty(len(found))
    point = (found.edge >= 0) | (found.cell >= 0)
    other, over = np.flatnonzero(~point), np.flatnonzero(point)
    amplitude[other] = np.abs(spreading(points_m[other], normal[other], curvature[other], found.order[other]))
    at = point_slot(found[over])
    segments = norm(np.diff(points_m[over], axis=1))
    before = np.cumsum(segments, axis=1)[np.arange(len(over)), at]
    after = segments.sum(axis=1) - before
    amplitude[over] = _point_spreading(found.part[over], before, after)
    return amplitude


def _point_spreading(part: Ints, before_m: Floats, after_m: Floats) -> Floats:
    """(R,) spreading over an edge's apex, or over one of its ends or a cell."""
    apex = 1.0 / np.sqrt(before_m * after_m * (before_m + after_m))
    return np.where(part == APEX, apex, 1.0 / (before_m * after_m))


def _solved(
    tracing: Tracing, found: Candidates, source: Floats, receiver: Floats, struck_s: Floats, guess: Moment
) -> Moment:
    """Exact reflection points with every reflector where it is when struck."""
    width = found.sequence.shape[1]
    turn = found.interaction > Interaction.SPECULAR
    turns: Flags = np.any(turn, axis=1)
    place = np.where(turns, np.argmax(turn, axis=1), found.order)
    last = np.where(turns, width - 1 - np.argmax(turn[:, ::-1], axis=1), found.order)
    here, there = np.minimum(place, width - 1) + 1, np.minimum(last, width - 1) + 1
    normal, offset = _planes(tracing, found, struck_s)
    early, late = mirrors_about(found, place, last)
    lit, received = (images_in_turn(p, normal, offset, s) for p, s in ((source, early), (receiver, late)))
    points = np.repeat(receiver[:, None], width + 2, axis=1)
    points[:, 0] = source
    moment = Moment(points, normal, np.zeros((*normal.shape, 3)), guess.face.copy(), guess.uv.copy())
    every, twice = np.arange(len(points)), np.flatnonzero(last > place)  # retardations and turns settle together
    onwards = np.where((last > place)[:, None], guess.points_m[every, there], received[0])
    _reflect_smoothly(tracing, found, every, place, lit[-1], onwards, struck_s, moment)
    _reflect_smoothly(tracing, found, twice, last, points[every, here], received[0], struck_s, moment)
    _follow_edges(tracing, found, place, lit[-1], received[0], struck_s, moment)
    for images, at, steps in ((lit, here, early), (received, there, late)):
        start = np.where(turns[:, None], points[every, at], receiver)
        crossings = crossings_in_turn(start, images, normal, offset, steps[::-1])
        for k, active in steps:
            points[active, k + 1] = crossings[active, k]
    return moment


def _reflect_smoothly(
    tracing: Tracing, found: Candidates, chosen: Ints, place: Ints, lit: Floats, received: Floats, struck_s: Floats,
    moment: Moment,
) -> None:  # fmt: skip
    """Follow the stationary points in one slot of chosen paths, and fill in point, normal and curvature there."""
    met = found.sequence[chosen, np.minimum(place[chosen], found.sequence.shape[1] - 1)]
    for index, surface in enumerate(tracing.world.surfaces):
        rows = chosen[met == tracing.world.numbering.number(Interaction.CURVED, index)]
        if len(rows) == 0:
            continue
        at = place[rows]
        frame = tracing.frames.of(np.full(len(rows), surface.obstacle), found.pose[rows], struck_s[rows, at])
        hit = curved.follow(surface, frame, lit[rows], received[rows], moment.face[rows, at], moment.uv[rows, at])
        moment.points_m[rows, at + 1] = hit.point_m
        moment.normal[rows, at], moment.curvature[rows, at] = hit.normal, hit.curvature
        moment.face[rows, at], moment.uv[rows, at] = hit.face, hit.uv


def _follow_edges(
    tracing: Tracing, found: Candidates, place: Ints, lit: Floats, received: Floats, struck_s: Floats, moment: Moment
) -> None:
    """Apex and ends of all edges where the edges are when struck; an apex may drift off its edge within a beep."""
    rows = np.flatnonzero(found.edge >= 0)
    at, edge = place[rows], found.edge[rows]
    frame = tracing.frames.of(tracing.world.wedges.obstacle[edge], found.pose[rows], struck_s[rows, at])
    wedges = wedges_out_of_rest(tracing.world.wedges[edge], frame)
    view = seen(wedges, lit[rows], received[rows])
    moment.points_m[rows, at + 1] = edge_points(wedges.start_m, wedges.end_m, view, found.part[rows])


def _planes(tracing: Tracing, found: Candidates, struck_s: Floats) -> tuple[Floats, Floats]:
    """(R, N, 3) normals and (R, N) offsets of the planar reflectors when they are struck."""
    patches = tracing.world.patches
    normal, offset = found.normal.copy(), np.zeros(found.sequence.shape)
    for k in range(found.sequence.shape[1]):
        rows = np.flatnonzero(found.interaction[:, k] == Interaction.SPECULAR)
        patch = found.sequence[rows, k]
        frame = tracing.frames.of(patches.obstacle[patch], found.pose[rows], struck_s[rows, k])
        normal[rows, k] = rotated(patches.normal[patch], frame[:, 3])
        offset[rows, k] = patches.offset_m[patch] + dot(normal[rows, k], frame[:, :3])
    return normal, offset
