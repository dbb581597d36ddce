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

from obstaclewatch.breadth import narrow_radius, radius_shares
from obstaclewatch.course_evidence import Ears, agreement
from obstaclewatch.course_geometry import Bodies, Singles
from obstaclewatch.course_posterior import Course, Meeting, expectations, posterior
from obstaclewatch.course_prior import Hypotheses, hypotheses, speed_density
from obstaclewatch.gait import READING_M, SWING_KNOWN_M, reading_covariance
from obstaclewatch.swing import LEAST_COS, STEADY, Swing
from obstaclewatch.wall_ends import ends_of_passed

Array = NDArray[np.float64]


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
class Posterior:
    """Probabilities of H courses, and where they are at a time.

    Attributes:
        time_s: from which the courses run.
        share: (H,) probabilities.
        ahead_m: (H,) distances ahead then.
        closing_m_s: (H,) speeds at which these fall.
        bodies: what the courses lead to.
        misfit: squared deviations, a reading, of the ranges from the course that they fit best; 1 is to be expected.
        radius_m, radius_std_m: half the breadth of what they lead to; NaN of what is not thought narrow.
    """

    time_s: float
    share: Array
    ahead_m: Singles
    closing_m_s: Singles
    bodies: Bodies
    misfit: float
    radius_m: float
    radius_std_m: float


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
        self._ears = Ears(separation_m, 1.0 / wavelength_m, pitch_rad, ahead_s)
        self._all: Hypotheses = hypotheses(half_width_m)
        cos_tilt, lean = np.cos(self._all.tilt_rad), np.sin(pitch_rad) / max(np.cos(pitch_rad), LEAST_COS)
        self._nearing = np.cos(self._all.angle_rad) * cos_tilt
        toward = self._nearing - np.sin(self._all.tilt_rad) * lean  # the upright wall with the same cone's cosine
        upright = (self._all.height_m == 0.0) | np.isinf(self._all.height_m)
        self._tells_phase = upright & (mic_phase_rad is not None)
        self._mic_phase_rad = mic_phase_rad or 0.0
        along_m2, up_m2 = _flatness(self._all, separation_m, baseline_m)
        stays = self._all.height_m > 0.0
        body = (self._all.height_m, self._all.radius_m, self._all.miss_m, toward, stays, along_m2, up_m2)
        self._bodies = Bodies(*(np.asarray(column, dtype=np.float32) for column in body))
        way = cos_tilt / np.cos(self._all.angle_rad)
        self._meeting = Meeting(
            self._all.collision,
            self._all.contact_m,
            self._all.angle_rad,
            self._nearing,
            way,
            np.where(self._all.is_wall, np.sin(self._all.angle_rad), np.inf),
            ends_of_passed(half_width_m),
        )
        self._radii = radius_shares(self._all)
        self._mic_ahead_m = 0.5 * separation_m * np.cos(pitch_rad)

    def posterior(self, samples: Samples, now_s: float, ground_m: float, swing: Swing = STEADY) -> Posterior:
        """The posterior after K >= 3 beeps.

        Args:
            samples: the track's readings.
            now_s: time from which the courses run.
            ground_m: height of microphone 0 above the ground.
            swing: of the phone; `STEADY` if it is not known.
        """
        bodies, hit_s, time_s = self._at_height(ground_m), samples.time_s - self._ears.ahead_s, samples.time_s - now_s
        swing_read, swing_hit = swing.as_read(hit_s, self._ears.ahead_s), swing.at(hit_s)
        covariance = reading_covariance(time_s, samples.range_std_m, SWING_KNOWN_M if swing.surge_m else READING_M)
        found = agreement(
            bodies, self._ears, time_s, samples.range_m, covariance, samples.second, swing_read, swing_hit
        )
        density = speed_density(found.closing_m_s / self._nearing, swing.step_hz)
        share = posterior(self._all.log_prior, found, density, self._tells_phase, self._mic_phase_rad)
        misfit = float(found.misfit.min()) / len(time_s)
        radius = narrow_radius(share, self._radii)
        return Posterior(now_s, share, found.ahead_m, found.closing_m_s, bodies, misfit, *radius)

    def _at_height(self, ground_m: float) -> Bodies:
        return self._bodies._replace(height_m=np.minimum(self._bodies.height_m, np.float32(ground_m)))

    def course(self, judged: Posterior, now_s: float) -> Course:
        """What to expect at a time: the posterior carried along its courses."""
        return expectations(
            judged.share,
            judged.bodies,
            self._meeting,
            judged.ahead_m,
            judged.closing_m_s,
            now_s - judged.time_s,
            self._ears.pitch_rad,
            self._mic_ahead_m,
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
