"""How well H trajectories agree with what K beeps read: the line along which each is walked, its ranges, its phases.

Compiled, a beep at a time over all trajectories, in single precision; `geometry` holds the formulas.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.signal.carrier_phase import add_rotated, deviation_factor, received_at
from obstaclewatch.support.arrays import Floats, SingleComplexes, Singles
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.trajectories.geometry import (
    NEAREST_M,
    Bodies,
    cone_cosine,
    distance_ahead,
    mirror_off,
    path_difference,
    sight,
    steady_range,
)
from obstaclewatch.walker.gait import line_weights, whitening


class Receivers(NamedTuple):
    """What of the phone is the same in every beep.

    Attributes:
        separation_m: between the microphones.
        cycles_m: of the carrier per metre.
        pitch_rad: mean pitch of the phone.
        ahead_s: how far ahead the chirp reads.
    """

    separation_m: float
    cycles_m: float
    pitch_rad: float
    ahead_s: float


class Agreement(NamedTuple):
    """How H trajectories agree with what was read.

    Attributes:
        ahead_m, closing_m_s: (H,) distances ahead at time 0 that explain the ranges best, and how fast they fall.
        misfit: (H,) squared deviations of the ranges that are left.
        gathered: (2, H) real and imaginary part of what microphone 1 adds up to.
    """

    ahead_m: Singles
    closing_m_s: Singles
    misfit: Singles
    gathered: Singles


@inlined
def agreement(
    bodies: Bodies,
    receivers: Receivers,
    time_s: Floats,
    read_m: Floats,
    covariance: Floats,
    second: SingleComplexes,
    oscillation_read: Floats,
    oscillation_hit: Floats,
) -> Agreement:
    """Lines through the ranges of K beeps, and how well ranges and phases agree with them.

    Args:
        bodies: (H,) what trajectories lead to.
        receivers: the phone.
        time_s: (K,) that the readings stand for, from the asked time on.
        read_m: (K,) ranges.
        covariance: (K, K) of the ranges about a straight line.
        second: (K, W) microphone 1 around each peak, see `carrier_phase`; NaN rows say nothing.
        oscillation_read, oscillation_hit: (3, K) pitch of the phone, height and fore-aft oscillation, as the chirp
            reads them, and as they are.
    """
    steady_m = steady_ranges(bodies, read_m, oscillation_read[1], oscillation_read[2])
    white = whitening(covariance)
    of_ahead, of_closing = line_weights(time_s, white)
    ahead_m, closing_m_s = straight_lines(bodies, steady_m, of_ahead, of_closing)
    misfit = misfits(bodies, steady_m, ahead_m, closing_m_s, time_s, white)
    total = gathered(bodies, receivers, ahead_m, closing_m_s, time_s, second, oscillation_read, oscillation_hit)
    return Agreement(ahead_m, closing_m_s, misfit, total)


@inlined
def steady_ranges(bodies: Bodies, read_m: Floats, rise_m: Floats, fore_aft_m: Floats) -> Singles:
    """(K, H) ranges as a phone would read them that moves neither up nor fore and aft, from (K,) readings and
    departures."""
    steady = np.empty((len(read_m), len(bodies.miss_m)), dtype=np.float32)
    for beep in range(len(read_m)):
        read, rise, fore_aft = np.float32(read_m[beep]), np.float32(rise_m[beep]), np.float32(fore_aft_m[beep])
        for trajectory in range(len(bodies.miss_m)):
            own = bodies.stays[trajectory] * rise
            steady[beep, trajectory] = steady_range(
                read, own, fore_aft, bodies.height_m[trajectory], bodies.cos_angle[trajectory]
            )
    return steady


@inlined
def straight_lines(bodies: Bodies, steady_m: Singles, of_ahead: Floats, of_closing: Floats) -> tuple[Singles, Singles]:
    """(H,) distances ahead at time 0 and closing speeds: sums, by (K,) weights, of the distances that ranges say."""
    ahead, closing = np.zeros_like(bodies.miss_m), np.zeros_like(bodies.miss_m)
    for beep in range(len(steady_m)):
        to_ahead, to_closing = np.float32(of_ahead[beep]), np.float32(of_closing[beep])
        for trajectory in range(len(ahead)):
            radius, miss = bodies.radius_m[trajectory], bodies.miss_m[trajectory]
            distance = distance_ahead(steady_m[beep, trajectory], bodies.height_m[trajectory], radius, miss)
            ahead[trajectory] += to_ahead * distance
            closing[trajectory] += to_closing * distance
    return ahead, closing


@inlined
def misfits(
    bodies: Bodies, steady_m: Singles, ahead_m: Singles, closing_m_s: Singles, time_s: Floats, white: Floats
) -> Singles:
    """(H,) squared deviations of ranges (K, H) from straight lines, once a triangle (K, K) has whitened them."""
    error, misfit, white_error = np.empty_like(steady_m), np.zeros_like(ahead_m), np.empty_like(ahead_m)
    for beep in range(len(steady_m)):
        time = np.float32(time_s[beep])
        for trajectory in range(len(ahead_m)):
            line = max(ahead_m[trajectory] - closing_m_s[trajectory] * time, NEAREST_M)
            radius, miss = bodies.radius_m[trajectory], bodies.miss_m[trajectory]
            seen, _, _ = sight(line, bodies.height_m[trajectory], radius, miss, bodies.cos_angle[trajectory])
            error[beep, trajectory] = steady_m[beep, trajectory] - seen
        weighted_sum(white_error, error, white[beep], beep + 1)
        for trajectory in range(len(ahead_m)):
            misfit[trajectory] += white_error[trajectory] * white_error[trajectory]
    return misfit


@inlined
def weighted_sum(total: Singles, rows: Singles, weight: Floats, count: int) -> None:
    """Fill in (H,) the weighted sum of the first rows (count, H)."""
    total[:] = np.float32(0.0)
    for row in range(count):
        own = np.float32(weight[row])
        for trajectory in range(len(total)):
            total[trajectory] += own * rows[row, trajectory]


@compiled
def path_differences(
    u_m: Singles, bodies: Bodies, line_m: Singles, pitch_rad: float, rise_m: float, separation_m: float
) -> None:
    """Fill in (H,) path differences to obstacles (H,) ahead of a phone so pitched and risen, less what mirrors."""
    cos_pitch, sin_pitch = np.float32(np.cos(pitch_rad)), np.float32(np.sin(pitch_rad))
    rise, separation = np.float32(rise_m), np.float32(separation_m)
    for trajectory in range(len(line_m)):
        height = bodies.height_m[trajectory] + bodies.stays[trajectory] * rise
        radius, miss = bodies.radius_m[trajectory], bodies.miss_m[trajectory]
        seen, plan, toward = sight(line_m[trajectory], height, radius, miss, bodies.cos_angle[trajectory])
        cosine = cone_cosine(seen, plan, toward, height, cos_pitch, sin_pitch)
        off = mirror_off(seen, cosine, toward, cos_pitch, bodies.along_m2[trajectory], bodies.up_m2[trajectory])
        u_m[trajectory] = path_difference(seen, cosine, separation) - off


@compiled
def lines_ahead(line_m: Singles, ahead_m: Singles, closing_m_s: Singles, time_s: float, earlier_s: float) -> None:
    """Fill in (H,) distances ahead some time before one at which none is less than the least."""
    time, earlier = np.float32(time_s), np.float32(earlier_s)
    for trajectory in range(len(line_m)):
        line_m[trajectory] = (
            max(ahead_m[trajectory] - closing_m_s[trajectory] * time, NEAREST_M) + closing_m_s[trajectory] * earlier
        )


@inlined
def gathered(
    bodies: Bodies,
    receivers: Receivers,
    ahead_m: Singles,
    closing_m_s: Singles,
    time_s: Floats,
    second: SingleComplexes,
    oscillation_read: Floats,
    oscillation_hit: Floats,
) -> Singles:
    """(2, H) real and imaginary part of what trajectories gather in phase at microphone 1; its squared size is 1 for
    noise.

    Ranges are read without the phone's bobbing, which was taken off them. Arguments as for `agreement`.
    """
    total, count = np.zeros((2, len(ahead_m)), dtype=np.float32), 0
    line_m, u_m, received = np.empty_like(ahead_m), np.empty_like(ahead_m), np.empty_like(total)
    sample = np.empty(len(ahead_m), dtype=np.int32)
    for beep in range(len(second)):
        if np.isnan(second[beep, 0].real):
            continue
        count += 1
        lines_ahead(line_m, ahead_m, closing_m_s, time_s[beep], 0.0)
        path_differences(
            u_m, bodies, line_m, receivers.pitch_rad + oscillation_read[0, beep], 0.0, receivers.separation_m
        )
        received_at(received, sample, second[beep], u_m)
        lines_ahead(line_m, ahead_m, closing_m_s, time_s[beep], receivers.ahead_s)
        pitch_rad, rise_m = receivers.pitch_rad + oscillation_hit[0, beep], oscillation_hit[1, beep]
        path_differences(u_m, bodies, line_m, pitch_rad, rise_m, receivers.separation_m)
        add_rotated(total, received, u_m, np.float32(receivers.cycles_m), deviation_factor(second[beep]))
    share = np.float32(1.0 / np.sqrt(max(count, 1)))
    for trajectory in range(len(ahead_m)):
        total[0, trajectory] *= share
        total[1, trajectory] *= share
    return total
