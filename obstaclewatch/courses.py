"""On which course does the walker pass? The posterior over straight courses, given what a track has measured.

A walker at speed v passes a point at a miss distance b and a height difference h: at the time t,
range = sqrt((v (t0 - t))^2 + b^2 + h^2) - r, with r the radius of curvature of a round body; and the microphones differ
by the cosine of the cone that the point and the phone's long axis make. A wall, which mirrors, stays at an angle a:
its range falls by v cos(a) a second. Constant bearing and falling range are a collision course. The chirp reads ranges
`range_doppler_s` ahead of their time, and so do envelopes; the phase between the microphones is that of the moment:
    arg y(peak) = -2 pi center_hz tau(t), peak at tau(t) + range_doppler_s dtau/dt.
Ranges are therefore compared at the times that are read, phases at the times at which the beep met the obstacle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.carrier_phase import coherent_power

Array = NDArray[np.float64]

SPEEDS_M_S = np.array([0.85, 1.0, 1.15, 1.3, 1.45, 1.6, 2.0, 2.5])
"""Of approach: walkers at 0.8-1.6 m/s (mean 1.25, deviation 0.25), and one in ten that comes the other way."""
MISSES_M = np.arange(0.0, 2.0, 0.15)
RADII_M = np.array([0.0, 0.35])
HEIGHTS_M = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.3])
"""Phone above reflecting point: at its own height, a low rim, the corner that a thing makes with the ground."""
HEIGHT_PRIOR = np.array([0.3, 0.15, 0.1, 0.1, 0.1, 0.25])
WALL_ANGLES_RAD = np.deg2rad([0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0])
WALL_PRIOR = 0.35
WALL_COLLISION_RAD = np.deg2rad(45.0)
ONCOMING_PRIOR = 0.12
EDGE_M = 0.05
"""A reflecting point lies inside the obstacle's near edge by about as much."""

GAIT_RANGE_M = 0.03
"""Deviation of a range from a straight course: 1 cm of surge, and 0.205 s of its 0.13 m/s."""
COHERENT = 0.15
"""Share of microphone 1's coherent power that counts: the wobbling hand and other echoes spoil the phase."""
INDEPENDENT = 0.5
"""Share of beeps that say something new: a step lasts six beeps, and deviations within it go together."""
FREEDOM = 3.0


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
        contact_s: expected time until the walker is at the obstacle, from the asked time; on courses that collide
            if there are any.
        speed_m_s: expected speed of approach.
        bearing_rad, bearing_std_rad: of the reflecting point at the asked time, unsigned.
        miss_m: expected miss distance; 0 for walls.
        radius_m: expected radius.
    """

    collision: float
    contact_s: float
    speed_m_s: float
    bearing_rad: float
    bearing_std_rad: float
    miss_m: float
    radius_m: float


class CourseGrid:
    """All courses that are considered, with their prior.

    Args:
        separation_m: between the microphones.
        wavelength_m: of the carrier.
        pitch_rad: lift of the phone's top edge.
        half_width_m: of the walker.
        ahead_s: how far ahead the chirp reads, `BeepDesign.range_doppler_s`.
    """

    def __init__(
        self, separation_m: float, wavelength_m: float, pitch_rad: float, half_width_m: float, ahead_s: float
    ) -> None:
        self._separation_m, self._wavelength_m = separation_m, wavelength_m
        self._ahead_s = np.float32(ahead_s)
        self.cos_pitch = float(np.cos(pitch_rad))
        point = np.meshgrid(SPEEDS_M_S, MISSES_M, RADII_M, HEIGHTS_M, [0.0], indexing="ij")
        wall = np.meshgrid(SPEEDS_M_S, [0.0], [0.0], HEIGHTS_M[[0, -1]], WALL_ANGLES_RAD, indexing="ij")
        columns = [
            np.concatenate([p.ravel(), w.ravel()])[:, None].astype(np.float32) for p, w in zip(point, wall, strict=True)
        ]
        self.speed, self.miss, self.radius, self.height, self.angle = columns
        self._is_wall = np.arange(len(self.speed)) >= point[0].size
        touches = self.miss <= self.radius + half_width_m + EDGE_M
        self.collides = np.where(self._is_wall, self.angle[:, 0] <= WALL_COLLISION_RAD, touches[:, 0])
        self._log_prior = self._prior()
        self._closing, self._across2 = self.speed * np.cos(self.angle), self.miss**2 + self.height**2
        self._forwards = np.cos(self.angle) * np.float32(self.cos_pitch)
        self._downwards = self.height * np.float32(np.sin(pitch_rad))

    def _prior(self) -> Array:
        speed, height = self.speed[:, 0], self.height[:, 0]
        steps = np.gradient(SPEEDS_M_S)[np.searchsorted(SPEEDS_M_S, speed - 1e-3)]
        walking = np.where(speed <= 1.61, np.exp(-0.5 * ((speed - 1.25) / 0.25) ** 2) / 0.627, 0.0)
        oncoming = np.where(speed > 1.61, 1.0 / 1.2, 0.0)
        prior = ((1.0 - ONCOMING_PRIOR) * walking + ONCOMING_PRIOR * oncoming) * steps
        prior *= HEIGHT_PRIOR[np.searchsorted(HEIGHTS_M, height - 1e-3)]
        share = np.where(self._is_wall, WALL_PRIOR, 1.0 - WALL_PRIOR)
        for kind in (self._is_wall, ~self._is_wall):  # half of either kind collides
            for group in (kind & self.collides, kind & ~self.collides):
                prior[group] *= 0.5 * share[group] / prior[group].sum()
        return np.log(prior)

    def judge(self, samples: Samples, now_s: float) -> Course:
        """The posterior after K >= 1 beeps."""
        time_s, read_m = (samples.time_s - now_s).astype(np.float32), samples.range_m.astype(np.float32)
        center_m = read_m + self.radius
        along = np.sqrt(np.maximum(center_m**2 - self._across2, np.float32(1e-4)))
        weight = (along / center_m) ** 2
        passing_s = np.sum(weight * (time_s + along / self._closing), axis=1) / np.sum(weight, axis=1)
        ahead = self._closing * (passing_s[:, None] - time_s)
        range_m, u_m = self._seen(ahead)
        _, u_now_m = self._seen(ahead + self._closing * self._ahead_s)
        log = self._log_prior + self._likelihood(samples, range_m, u_m, u_now_m)
        share = np.exp(log - log.max())
        return self._summary(share / share.sum(), passing_s)

    def _seen(self, ahead_m: Array) -> tuple[Array, Array]:
        """(H, K) ranges and path differences with the obstacle that far ahead."""
        center = np.sqrt(ahead_m**2 + self._across2)
        range_m = np.maximum(center - self.radius, np.float32(0.1))
        lean = self._separation_m * (ahead_m * self._forwards - self._downwards) / center
        u_m: Array = np.sqrt(range_m * (range_m + 2.0 * lean) + self._separation_m**2) - range_m
        return range_m, u_m

    def _likelihood(self, samples: Samples, range_m: Array, u_m: Array, u_now_m: Array) -> Array:
        """(H,) log likelihood; the tails are Student's, so that a wrong echo does not decide."""
        deviation = np.hypot(GAIT_RANGE_M, samples.range_std_m).astype(np.float32)
        total = _student(samples.range_m.astype(np.float32) - range_m, deviation)
        total = INDEPENDENT * total
        heard = np.isfinite(samples.second[:, 0])
        if heard.any():
            total += COHERENT * coherent_power(
                samples.second[heard], u_m[:, heard], u_now_m[:, heard], self._wavelength_m
            )
        return total

    def _summary(self, share: Array, passing_s: Array) -> Course:
        collision = float(share[self.collides].sum())
        meeting = share * self.collides if collision > 1e-6 else share
        meeting = meeting / meeting.sum()
        ahead = np.maximum(self.speed[:, 0] * passing_s, 0.05)
        bearing = np.where(self._is_wall, self.angle[:, 0], np.arctan2(self.miss[:, 0], ahead))
        mean = float(share @ bearing)
        return Course(
            collision=collision,
            contact_s=float(meeting @ passing_s),
            speed_m_s=float(share @ self.speed[:, 0]),
            bearing_rad=mean,
            bearing_std_rad=float(np.sqrt(share @ (bearing - mean) ** 2)),
            miss_m=float(share @ self.miss[:, 0]),
            radius_m=float(share @ self.radius[:, 0]),
        )


def _student(error: NDArray[np.floating], deviation: NDArray[np.floating]) -> Array:
    """(H,) sum over the last axis of Student's log density, up to a constant."""
    return -0.5 * (FREEDOM + 1.0) * np.log(np.prod(1.0 + (error / deviation) ** 2 / FREEDOM, axis=-1, dtype=np.float64))
