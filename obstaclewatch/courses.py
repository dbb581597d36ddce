"""On which course does the walker pass? The posterior over straight courses, given what a track has measured.

A walker closes in at speed v on a point that will be passed at the miss distance b. With x = v (t0 - t) the distance
ahead and D = sqrt(x^2 + b^2) the distance in plan to the middle of a round body of radius r, the echo has

    range   R = sqrt((D - r)^2 + h^2)
    cosine  k = ((D - r) x / D cos(pitch) - h sin(pitch)) / R      of the cone about the phone's long axis.

h = 0 is an echo from the phone's own height; h = ground is that of the corner which an upright thing makes with hard
ground: it comes back the way it went, as if from as far below as the phone is above the ground. A wall, which mirrors,
stays at an angle a: x closes at v cos(a), and the cosine keeps its factor cos(a). The microphones' path difference u
follows from R and k. Constant bearing and falling range are a collision course.

The chirp reads ranges `range_doppler_s` ahead of their time, and so do envelopes; the phase between the microphones is
that of the moment:
    arg y(peak) = -2 pi center_hz tau(t), peak at tau(t) + range_doppler_s dtau/dt.
Ranges are therefore compared at the times that are read, phases at the times at which the beep met the obstacle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.carrier_phase import (
    WOBBLE,
    at_path_differences,
    coherent_sum,
    log_agreement,
    with_deviation,
)
from obstaclewatch.course_geometry import (
    NEAREST_M,
    as_seen,
    distances_ahead,
    mirrors_off,
    path_differences,
    steady_ranges,
)
from obstaclewatch.course_prior import Hypotheses, hypotheses, speed_density
from obstaclewatch.gait import READING_M, SWING_KNOWN_M, reading_covariance
from obstaclewatch.swing import STEADY, Swing

Array = NDArray[np.float64]

SHARE_HEARD = 0.4
"""Share of microphone 1's power that counts: beeps within a step share their deviations."""
MOST_MISFIT = 40.0
"""Squared deviations in all, beyond which a course is not thought less likely: some peaks are of another echo."""
WALKING_M_S = 1.4
"""Of a faster approach, the obstacle's own speed makes up the rest."""


@dataclass(frozen=True)
class Samples:
    """What a track has measured at K beeps, as read.

    Attributes:
        time_s: (K,) times that the readings stand for.
        range_m, range_std_m: (K,) ranges from microphone 0.
        second: (K, W) microphone 1 around each peak, see `carrier_phase`; NaN rows say nothing.
    """

    time_s: Array
    range_m: Array
    range_std_m: Array
    second: NDArray[np.complex64]


@dataclass(frozen=True)
class Course:
    """The posterior in a few numbers.

    Attributes:
        collision: probability that walker and obstacle meet.
        ahead_m: expected distance that the walker still walks until abreast of the obstacle's middle, on courses that
            collide if there are any.
        speed_m_s: expected speed of approach.
        bearing_rad, bearing_std_rad: of the reflecting point at the asked time, unsigned.
        cosine: of the cone about the phone's long axis at which the echo arrives.
        miss_m: expected miss distance; walls count with 0.
    """

    collision: float
    ahead_m: float
    speed_m_s: float
    bearing_rad: float
    bearing_std_rad: float
    cosine: float
    miss_m: float


class CourseGrid:
    """All courses that are considered, with their prior.

    Args:
        separation_m: between the microphones.
        wavelength_m: of the carrier.
        pitch_rad: lift of the phone's top edge.
        half_width_m: of the walker.
        ahead_s: how far ahead the chirp reads, `BeepDesign.range_doppler_s`.
        mic_phase_rad: what microphone 1's channel adds to the carrier's phase, compared with microphone 0's; None if it
            is not known.
        baseline_m: from microphone 0 back to the speaker.
    """

    def __init__(
        self,
        separation_m: float,
        wavelength_m: float,
        pitch_rad: float,
        half_width_m: float,
        ahead_s: float,
        mic_phase_rad: float | None = 0.0,
        baseline_m: float = 0.0,
    ) -> None:
        self._separation_m, self._wavelength_m, self._ahead_s = separation_m, wavelength_m, ahead_s
        self._pitch_rad = np.array([pitch_rad])
        self._all: Hypotheses = hypotheses(half_width_m)
        self._cos_angle = np.cos(self._all.angle_rad)
        self._mic_phase_rad = mic_phase_rad
        self._upright = (self._all.height_m == 0.0) | np.isinf(self._all.height_m)
        self._stays = (self._all.height_m > 0.0).astype(np.float64)
        self._flat_m2 = _flatness(self._all, separation_m, baseline_m)

    def judge(self, samples: Samples, now_s: float, ground_m: float, swing: Swing = STEADY) -> Course:
        """The posterior after K >= 3 beeps.

        Args:
            samples: the track's readings.
            now_s: time of the asked state.
            ground_m: height of microphone 0 above the ground.
            swing: of the phone; `STEADY` if it is not known.
        """
        height = np.minimum(self._all.height_m, ground_m)
        time_s, hit_s = samples.time_s - now_s, samples.time_s - self._ahead_s
        step_std_m = SWING_KNOWN_M if swing.surge_m else READING_M
        covariance = reading_covariance(time_s, samples.range_std_m, step_std_m)
        precision: Array = np.linalg.inv(covariance).astype(np.float64, copy=False)
        turn_rad, lift_m, surge_m = swing.as_read(hit_s, self._ahead_s)
        steady_m = steady_ranges(samples.range_m, lift_m, surge_m, height, self._cos_angle, self._stays)
        read_at = distances_ahead(steady_m, height, self._all.radius_m, self._all.miss_m)
        ahead, closing = _straight(time_s, read_at, precision)
        line = np.maximum(ahead - closing * time_s, NEAREST_M)
        range_m, cosine = self._seen(line, self._pitch_rad + turn_rad, np.zeros(len(time_s)), height)
        log = self._all.log_prior + _log_fit(steady_m - range_m, precision)
        speed = closing[:, 0] / self._cos_angle
        heard = np.isfinite(samples.second[:, 0])
        if heard.any():
            u_m = self._path_differences(line, range_m, cosine, self._pitch_rad + turn_rad)
            turn_rad, lift_m, _ = swing.at(hit_s)
            then, pitch_rad = line + closing * self._ahead_s, self._pitch_rad + turn_rad
            now_m = self._path_differences(then, *self._seen(then, pitch_rad, lift_m, height), pitch_rad)
            u_m, now_m = np.compress(heard, u_m, axis=1), np.compress(heard, now_m, axis=1)
            log += self._log_heard(samples.second[heard], u_m, now_m)
        log += np.log(speed_density(speed, swing.step_hz))
        share = np.exp(log - log.max())
        return self._summary(share / share.sum(), np.maximum(ahead, NEAREST_M), speed, height)

    def _seen(self, ahead_m: Array, pitch_rad: Array, lift_m: Array, height_m: Array) -> tuple[Array, Array]:
        """(H, K) ranges and cosines of the cone, the obstacle that far ahead and the phone pitched and lifted so."""
        radius_m, miss_m = self._all.radius_m, self._all.miss_m
        return as_seen(ahead_m, pitch_rad, lift_m, height_m, radius_m, miss_m, self._cos_angle, self._stays)

    def _path_differences(self, ahead_m: Array, range_m: Array, cosine: Array, pitch_rad: Array) -> Array:
        """(H, K) as from points, less what mirrors take off."""
        off_m = mirrors_off(ahead_m, range_m, cosine, pitch_rad, self._all.miss_m, self._cos_angle, *self._flat_m2)
        difference: Array = path_differences(range_m, cosine, self._separation_m) - off_m
        return difference

    def _log_heard(self, second: NDArray[np.complex64], u_m: Array, now_m: Array) -> Array:
        """(H,) log likelihood ratio of microphone 1: what adds up in phase over beeps, and that sum's own phase.

        The phase itself counts for upright things and walls alone, whose height is known: 10 cm of another height turn
        it by a quarter of a cycle.
        """
        value = at_path_differences(second, u_m) * with_deviation(second, WOBBLE)
        total = coherent_sum(value, now_m, self._wavelength_m)
        log: Array = SHARE_HEARD * np.abs(total) ** 2
        if self._mic_phase_rad is None:
            return log
        return log + np.where(self._upright, log_agreement(total, self._mic_phase_rad), 0.0)

    def _summary(self, share: Array, ahead_m: Array, speed: Array, height_m: Array) -> Course:
        meeting = share * self._all.collision
        collision = float(meeting.sum())
        likely = meeting / collision if collision > 1e-6 else share
        own = np.minimum(1.0, WALKING_M_S / np.maximum(speed, WALKING_M_S))
        angle = np.arctan2(self._all.miss_m, ahead_m[:, 0])
        bearing = np.where(self._all.is_wall, self._all.angle_rad, angle)
        mean = float(share @ bearing)
        return Course(
            collision=collision,
            ahead_m=float(likely @ (ahead_m[:, 0] * own)),
            speed_m_s=float(share @ speed),
            bearing_rad=mean,
            bearing_std_rad=float(np.sqrt(share @ (bearing - mean) ** 2)),
            cosine=float(share @ self._seen(ahead_m, self._pitch_rad, np.zeros(1), height_m)[1][:, 0]),
            miss_m=float(share @ self._all.miss_m),
        )


def _flatness(courses: Hypotheses, length_m: float, baseline_m: float) -> tuple[Array, Array]:
    """(H,) m^2 by which a mirror shortens the path difference, times sin^2 / range: in the level plane, and upright.

    With speaker and microphone s and m off the ray, a point's path is longer by (s^2 + m^2) / 2R than the ray's, a
    mirror's by (s - m)^2 / 4R, and that of its corner with the ground, which turns s over, by (s + m)^2 / 4R. Upright
    things mirror in the upright plane, walls in the level one as well; what lies between phone and ground is rounded.
    """
    mirror = 0.25 * length_m * (length_m + 2.0 * baseline_m)
    corner = 0.25 * length_m * (length_m - 2.0 * baseline_m)
    up = np.where(courses.height_m == 0.0, mirror, np.where(np.isinf(courses.height_m), corner, 0.0))
    return np.where(courses.is_wall, mirror, 0.0), up


def _straight(time_s: Array, ahead_m: Array, precision: Array) -> tuple[Array, Array]:
    """(H, 1) distance ahead at time 0 and closing speed, from (H, K) distances by generalised least squares."""
    total, first = precision.sum(axis=1), precision @ time_s
    moments = np.array([[total.sum(), -first.sum()], [-first.sum(), time_s @ first]])
    fit = ahead_m @ np.stack([total, -first], axis=1) @ np.linalg.inv(moments)
    return fit[:, :1], fit[:, 1:]


def _log_fit(error_m: Array, precision: Array) -> Array:
    """(H,) log likelihood of range errors (H, K), which saturates."""
    misfit = np.einsum("hk,hk->h", error_m @ precision, error_m)
    fit: Array = -0.5 * MOST_MISFIT * (1.0 - np.exp(-misfit / MOST_MISFIT))
    return fit
