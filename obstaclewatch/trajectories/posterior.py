"""The posterior over trajectories: prior, agreement with ranges and with microphone 1, and how walkers walk.

One compiled call a judgement: calls between compiled parts cost as much as what they compute. What they are handed are
tables and plain tuples, which take a third of the time of named tuples of arrays; inside these have their names again.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from obstaclewatch.signal.carrier_phase import log_agreement
from obstaclewatch.support.arrays import Flags, Floats, Singles
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.trajectories.geometry import NEAREST_M, bodies_at, cone_cosine, sight
from obstaclewatch.trajectories.likelihood import Agreement, Receivers, agreement
from obstaclewatch.trajectories.passed_walls import still_received
from obstaclewatch.trajectories.prior import speed_density
from obstaclewatch.walker.gait import OSCILLATION_KNOWN_M, READING_M, reading_covariance
from obstaclewatch.walker.pitch_oscillation import Oscillation, oscillation_as_read, oscillation_at

RECEIVED_SHARE = 0.4
"""Share of microphone 1's power that counts: beeps within a step share their deviations."""
MOST_MISFIT = 40.0
"""Squared deviations. Larger misfits lower the likelihood no further, since some peaks belong to other echoes."""
WALKING_M_S = 1.4
"""Of a faster approach, the obstacle's own speed makes up the rest."""
NEGLIGIBLE = 1e-10
"""Probability of a trajectory that no expectation needs."""


class Prior(NamedTuple):
    """What is known of H trajectories before anything is received.

    Attributes:
        log_share: (H,) of the probabilities, up to a constant.
        nearing: (H,) fall of a wall's distance along its normal per distance walked; 1 for other things.
        has_phase: (H,) whether the phase of what adds up is known: of upright things and walls alone, whose height is
            known, as 10 cm of another height rotate it by a quarter of a cycle; and not of phones that were not
            measured.
        phase_rad: what microphone 1 adds to it.
    """

    log_share: Floats
    nearing: Floats
    has_phase: Flags
    phase_rad: float


class Posterior(NamedTuple):
    """Probabilities of H trajectories, and where they are at a time.

    Attributes:
        time_s: from which the trajectories run.
        bodies, ground_m: (7, H) what the trajectories lead to, and height of microphone 0 above the ground; see
            `bodies_at`.
        share: (H,) probabilities.
        ahead_m: (H,) distances ahead then.
        closing_m_s: (H,) speeds at which these fall.
        misfit: squared deviations, a reading, of the ranges from the trajectory that they fit best; 1 is to be
            expected.
    """

    time_s: float
    bodies: Singles
    ground_m: float
    share: Floats
    ahead_m: Singles
    closing_m_s: Singles
    misfit: float


@compiled
def posterior(
    known: tuple[Any, ...],
    table: Singles,
    ground_m: float,
    phone: tuple[Any, ...],
    oscillating: tuple[Any, ...],
    walking: tuple[Any, ...],
    samples: tuple[Any, ...],
    now_s: float,
) -> tuple[Floats, Singles, Singles, float]:
    """What `Posterior` has from `share` on, after K >= 3 beeps.

    Args:
        known: `Prior` of the trajectories.
        table: (7, H) what they lead to, see `bodies_at`.
        ground_m: height of microphone 0 above the ground, from which on things are corners.
        phone: its `Receivers`.
        oscillating: its `Oscillation`.
        walking: the walker's `WalkingSpeed`.
        samples: what was read, see `Samples`.
        now_s: time from which the trajectories run.
    """
    prior, receivers, oscillation = Prior(*known), Receivers(*phone), Oscillation(*oscillating)
    time_s, range_m, range_std_m, second = samples
    bodies = bodies_at(table, ground_m)
    hit_s, since_s = time_s - receivers.ahead_s, time_s - now_s
    covariance = reading_covariance(
        since_s, range_std_m, OSCILLATION_KNOWN_M if oscillation.fore_aft_m != 0.0 else READING_M
    )
    oscillation_read, oscillation_hit = (
        oscillation_as_read(oscillation, hit_s, receivers.ahead_s),
        oscillation_at(oscillation, hit_s),
    )
    found = agreement(bodies, receivers, since_s, range_m, covariance, second, oscillation_read, oscillation_hit)
    own_m_s, std_m_s = walking
    density = speed_density(found.closing_m_s / prior.nearing, own_m_s, std_m_s)
    share = shares(prior.log_share, found, density, prior.has_phase, prior.phase_rad)
    misfit = float(found.misfit[np.argmin(found.misfit)]) / len(time_s)
    return share, found.ahead_m, found.closing_m_s, misfit


@inlined
def shares(log_prior: Floats, found: Agreement, density: Floats, has_phase: Flags, phase_rad: float) -> Floats:
    """(H,) probabilities, which sum to 1.

    Args:
        log_prior: (H,).
        found: how the trajectories agree with what was read.
        density: (H,) of the speed of approach.
        has_phase, phase_rad: see `Prior`.
    """
    log = np.empty(len(log_prior))
    for trajectory in range(len(log)):
        real, imaginary = float(found.gathered[0, trajectory]), float(found.gathered[1, trajectory])
        received = RECEIVED_SHARE * (real * real + imaginary * imaginary)
        if has_phase[trajectory]:
            received += log_agreement(real, imaginary, phase_rad)
        log[trajectory] = (
            log_prior[trajectory] + log_fit(float(found.misfit[trajectory])) + received + np.log(density[trajectory])
        )
    share = np.exp(log - log[np.argmax(log)])
    return share / share.sum()


@inlined
def log_fit(misfit: float) -> float:
    """Log likelihood of squared deviations, which saturates."""
    return -0.5 * MOST_MISFIT * (1.0 - np.exp(-misfit / MOST_MISFIT))


class Meeting(NamedTuple):
    """What H trajectories come to, (H,) each.

    Attributes:
        collision: probability that they are collisions.
        contact_m: distance ahead of the phone's middle at which the walker's body meets the obstacle.
        angle_rad: at which walls stay; 0 for other things.
        nearing: fall of a wall's distance along its normal per distance walked; 1 for other things.
        to_walk: distance to walk to a wall, as high as its nearest point, per distance along its normal; 1 likewise.
        aside: how far aside a wall's nearest point lies per distance along its normal; infinite for other things.
    """

    collision: Floats
    contact_m: Floats
    angle_rad: Floats
    nearing: Floats
    to_walk: Floats
    aside: Floats


class Expectation(NamedTuple):
    """The posterior in a few numbers.

    Attributes:
        collision: probability that walker and obstacle meet.
        left_m: expected distance that the walker still walks until they meet, on trajectories that collide if there
            are any.
        speed_m_s: expected speed of approach.
        bearing_rad, bearing_std_rad: of the reflecting point at the asked time, unsigned.
        cosine: of the cone about the phone's long axis at which the echo arrives.
        miss_m: expected miss distance; walls count with 0.
        bob, fore_aft: expected share by which the range grows as the phone rises, and falls as it moves ahead.
    """

    collision: float
    left_m: float
    speed_m_s: float
    bearing_rad: float
    bearing_std_rad: float
    cosine: float
    miss_m: float
    bob: float
    fore_aft: float

    @property
    def contact_s(self) -> float:
        """Time until they meet, s: of the speed of approach, the walker's own share covers what is left."""
        return self.left_m / min(self.speed_m_s, WALKING_M_S)


@compiled
def expectations(
    share: Floats,
    ahead_m: Singles,
    closing_m_s: Singles,
    later_s: float,
    table: Singles,
    ground_m: float,
    meetings: Floats,
    ends_m: tuple[float, float],
    pitch_rad: float,
    mic_m: float,
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """What to expect of trajectories, the numbers of `Expectation`.

    Args:
        share: (H,) probabilities; those below `NEGLIGIBLE` are left out.
        ahead_m, closing_m_s: (H,) distances ahead of microphone 0, a wall's along its normal, and how they fall.
        later_s: how much later the asked time is.
        table, ground_m: what the trajectories lead to, see `bodies_at`.
        meetings: (6, H) what they come to, a table of `Meeting`.
        ends_m: how far aside passed walls end, see `passed_walls`.
        pitch_rad: pitch of the phone.
        mic_m: how far microphone 0 is ahead of the phone's middle.
    """
    bodies = bodies_at(table, ground_m)
    meeting = Meeting(meetings[0], meetings[1], meetings[2], meetings[3], meetings[4], meetings[5])
    cos_pitch, sin_pitch, later = np.float32(np.cos(pitch_rad)), np.float32(np.sin(pitch_rad)), np.float32(later_s)
    total = hit = left = left_of_hits = speed = bearing = bearing2 = cosine = miss = bob = fore_aft = 0.0
    for trajectory in range(len(share)):
        if share[trajectory] < NEGLIGIBLE:
            continue
        ahead = max(ahead_m[trajectory] - closing_m_s[trajectory] * later, NEAREST_M)
        hits = share[trajectory] * meeting.collision[trajectory]
        own = hits + (share[trajectory] - hits) * still_received(meeting.aside[trajectory] * ahead, ends_m)
        height, aside = bodies.height_m[trajectory], bodies.miss_m[trajectory]
        seen, plan, toward = sight(ahead, height, bodies.radius_m[trajectory], aside, bodies.cos_angle[trajectory])
        bob, fore_aft = bob + own * bodies.stays[trajectory] * height / seen, fore_aft + own * toward * plan / seen
        cosine += own * cone_cosine(seen, plan, toward, height, cos_pitch, sin_pitch)
        closing = float(closing_m_s[trajectory]) / meeting.nearing[trajectory]
        left_m = float(ahead) * meeting.to_walk[trajectory] + mic_m - meeting.contact_m[trajectory]
        walked_m = left_m * walked_share(closing)
        total, hit, left_of_hits = total + own, hit + hits, left_of_hits + hits * walked_m
        left, speed, miss = left + own * walked_m, speed + own * closing, miss + own * aside
        angle = meeting.angle_rad[trajectory] + (np.arctan2(float(aside), float(ahead)) if aside > 0.0 else 0.0)
        bearing, bearing2 = bearing + own * angle, bearing2 + own * angle * angle
    left = left_of_hits / hit if hit > 1e-6 * total else left / total
    bearing /= total
    spread = np.sqrt(max(bearing2 / total - bearing * bearing, 0.0))
    rest = cosine / total, miss / total, bob / total, fore_aft / total
    return hit / total, left, speed / total, bearing, spread, *rest


@inlined
def walked_share(closing_m_s: float) -> float:
    """Of an approach, what the walker walks; of a faster one the obstacle's own speed makes up the rest."""
    return min(1.0, WALKING_M_S / max(closing_m_s, WALKING_M_S))
