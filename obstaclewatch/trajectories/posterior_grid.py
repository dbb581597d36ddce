"""On which trajectory does the walker pass? The posterior over straight trajectories, given what a track has measured.

A walker closes in at speed v on a point that will be passed at the miss distance b. With x = v (t0 - t) the distance
ahead and D = sqrt(x^2 + b^2) the distance in plan to the middle of a round body of radius r, the echo has

    range   R = sqrt((D - r)^2 + h^2)
    cosine  k = ((D - r) x / D cos(pitch) - h sin(pitch)) / R      of the cone about the phone's long axis.

h = 0 is an echo from the phone's own height; h = ground is that of the corner which an upright thing makes with hard
ground: it comes back along its own path, as if from as far below as the phone is above the ground. A wall, which
mirrors, stays at an angle a: x closes at v cos(a), and the cosine keeps its factor cos(a). The microphones' path
difference u follows from R and k. Constant bearing and falling range are a collision course.

The chirp reads ranges `range_doppler_s` ahead of their time, and so do envelopes; the phase between the microphones is
that of the moment:
    arg y(peak) = -2 pi center_hz tau(t), peak at tau(t) + range_doppler_s dtau/dt.
Ranges are therefore compared at the times that are read, phases at the times at which the beep met the obstacle.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Floats, SingleComplexes, Singles
from obstaclewatch.trajectories.bearing_shares import bearing_shares, kinds_of
from obstaclewatch.trajectories.geometry import NEAREST_M
from obstaclewatch.trajectories.likelihood import Receivers
from obstaclewatch.trajectories.passed_walls import ends_of_passed
from obstaclewatch.trajectories.posterior import Expectation, Meeting, Posterior, Prior, expectations, posterior
from obstaclewatch.trajectories.prior import Hypotheses, hypotheses
from obstaclewatch.walker.pitch_oscillation import LEAST_COS, STEADY, Oscillation
from obstaclewatch.walker.walking_speed import USUAL, WalkingSpeed


class Samples(NamedTuple):
    """What a track has measured at K beeps, as read.

    Attributes:
        time_s: (K,) times that the readings stand for.
        range_m, range_std_m: (K,) ranges from microphone 0.
        second: (K, W) microphone 1 around each peak, see `carrier_phase`; NaN rows say nothing.
    """

    time_s: Floats
    range_m: Floats
    range_std_m: Floats
    second: SingleComplexes


class TrajectoryGrid:
    """All trajectories that are considered, with their prior.

    Args:
        separation_m: between the microphones.
        wavelength_m: of the carrier.
        pitch_rad: pitch of the phone.
        half_width_m: of the walker.
        ahead_s: how far ahead the chirp reads, `BeepDesign.range_doppler_s`.
        mic_phase_rad: what microphone 1's channel adds to the carrier's phase, compared with microphone 0's; None if it
            is not known.
        baseline_m: from microphone 0 back to the speaker, along the phone.
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
        self._pitch_rad = pitch_rad
        self._receivers = tuple(Receivers(separation_m, 1.0 / wavelength_m, pitch_rad, ahead_s))
        self._all: Hypotheses = hypotheses(half_width_m)
        cos_tilt, lean = np.cos(self._all.tilt_rad), np.sin(pitch_rad) / max(np.cos(pitch_rad), LEAST_COS)
        nearing = np.cos(self._all.angle_rad) * cos_tilt
        toward = nearing - np.sin(self._all.tilt_rad) * lean  # the upright wall with the same cone's cosine
        upright = (self._all.height_m == 0.0) | np.isinf(self._all.height_m)
        has_phase = upright & (mic_phase_rad is not None)
        self._prior = tuple(Prior(self._all.log_prior, nearing, has_phase, mic_phase_rad or 0.0))
        along_m2, up_m2 = _flatness(self._all, separation_m, baseline_m)
        stays = self._all.height_m > 0.0
        body = (self._all.height_m, self._all.radius_m, self._all.miss_m, toward, stays, along_m2, up_m2)
        self._bodies: Singles = np.array(body, dtype=np.float32)
        to_walk = cos_tilt / np.cos(self._all.angle_rad)
        aside = np.where(self._all.is_wall, np.sin(self._all.angle_rad), np.inf)
        meeting = Meeting(self._all.collision, self._all.contact_m, self._all.angle_rad, nearing, to_walk, aside)
        self._meeting, self._ends_m = np.array(meeting), ends_of_passed(half_width_m)
        self._mic_ahead_m = float(0.5 * separation_m * np.cos(pitch_rad))
        self._aside = self._all.miss_m, self._all.angle_rad, kinds_of(self._all)

    def posterior(
        self,
        samples: Samples,
        now_s: float,
        ground_m: float,
        oscillation: Oscillation = STEADY,
        walking: WalkingSpeed = USUAL,
    ) -> Posterior:
        """The posterior after K >= 3 beeps.

        Args:
            samples: the track's readings.
            now_s: time from which the trajectories run.
            ground_m: height of microphone 0 above the ground.
            oscillation: of the phone; `STEADY` if it is not known.
            walking: what is known of the walker's speed.
        """
        known = tuple(oscillation), tuple(walking), tuple(samples)
        found = posterior(self._prior, self._bodies, ground_m, self._receivers, *known, now_s)
        return Posterior(now_s, self._bodies, ground_m, *found)

    def trajectory(self, judged: Posterior, now_s: float) -> Expectation:
        """What to expect at a time: the posterior carried along its trajectories."""
        found = expectations(
            judged.share,
            judged.ahead_m,
            judged.closing_m_s,
            now_s - judged.time_s,
            judged.bodies,
            judged.ground_m,
            self._meeting,
            self._ends_m,
            self._pitch_rad,
            self._mic_ahead_m,
        )
        return Expectation(*found)

    def bearing_shares(self, judged: Posterior, now_s: float) -> Floats:
        """(SHARES,) probabilities of bearings at a time by kinds of things, see `bearing_shares`."""
        ahead_m = np.maximum(judged.ahead_m - judged.closing_m_s * np.float32(now_s - judged.time_s), NEAREST_M)
        return bearing_shares(judged.share, ahead_m, *self._aside)


def _flatness(trajectories: Hypotheses, length_m: float, baseline_m: float) -> tuple[Floats, Floats]:
    """(H,) m^2 by which a mirror shortens the path difference, times sin^2 / range: in the level plane, and upright.

    With speaker and microphone s and m off the ray, a point's path is longer by (s^2 + m^2) / 2R than the ray's, a
    mirror's by (s - m)^2 / 4R, and that of its corner with the ground, which reverses s, by (s + m)^2 / 4R. Upright
    things mirror in the upright plane, walls in the level one as well; what lies between phone and ground is rounded.
    """
    mirror = 0.25 * length_m * (length_m + 2.0 * baseline_m)
    corner = 0.25 * length_m * (length_m - 2.0 * baseline_m)
    up = np.where(trajectories.height_m == 0.0, mirror, np.where(np.isinf(trajectories.height_m), corner, 0.0))
    return np.where(trajectories.is_wall, mirror, 0.0), up
