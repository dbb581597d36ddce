"""Our detector: obstacles followed over beeps, and a test of each one's trajectory.

Peaks under a low threshold (`moving_peaks`) and likelihood along lines (`track_before_detect`) -> tracks of what
closes in, without range-Doppler bias (`tracks`) -> the phone's oscillation, from the ground's echo
(`pitch_oscillation`) -> the probability of each trajectory, by ranges and microphone 1 (`posterior_grid`) -> an alert
if that is sure and near enough.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import COLUMNS, Decision, Detection, Flag
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.recordings.streaming import StreamingDetector, check_arguments
from obstaclewatch.signal.carrier_phase import check_mic_phase
from obstaclewatch.signal.direct_sound import expected_direct_delay_s
from obstaclewatch.signal.two_mics import path_difference_at
from obstaclewatch.tracking.moving_peaks import PeakFinder
from obstaclewatch.tracking.range_fit import Timing, TrackRange
from obstaclewatch.tracking.settings import TrackingSettings
from obstaclewatch.tracking.track_before_detect import LineLikelihood
from obstaclewatch.tracking.tracks import Approaches, Track
from obstaclewatch.trajectories.posterior_grid import Expectation, TrajectoryGrid
from obstaclewatch.walker.pitch_oscillation import STEADY, OscillationEstimator

CONFIRMED_SCORE = 8.0
"""Log likelihood ratio at which a track is shown and judged."""
FARTHEST_M = 1.35
"""Distance left from which on an alert is given: range and bearing say more with every beep, so the decision waits. A
late alert is better than none."""
SURE = 0.9
"""Probability of a collision that raises the alert. Of 240 walks of development, recipe `paper`, 79 % of the collisions
have it before contact and 95 % of the others never. At 0.79 that is 82 and 91 %, at 0.95 75 and 96 %."""
PRESSING, NEARLY_M = 0.3, 0.25
"""Probability of a collision, and how far before `FARTHEST_M`, from which on a track is judged before others."""
WAITS_M = 1.4
"""Range from which on a track can wait a beep to be judged: alerts are given within it."""
LEAST_BEEPS, LEAST_TRAVEL_M = 6, 0.4
"""Peaks, and fall of range between the first and the last of them, without which no trajectory is believed."""
OF_TWO_MICS = ("range2_m", "bearing_rad", "bearing_std_rad")
"""Columns that need two different channels."""
MOST_RANGE_STD_M = 0.03
"""Claimed deviation of the range beyond which a track is not shown, unless it raises the alert."""
MOST_MISFIT = 2.0
"""Squared deviations, a reading, beyond which no trajectory explains a track: it began on another echo."""
MOST_MISSES = 3
"""Beeps without a peak after which a track no longer raises an alert."""


class TrackingDetector(StreamingDetector):
    """Follows obstacles over beeps and alerts by the probability of a collision.

    Detections hold the confirmed tracks whose range is known: without range-Doppler bias, fitted to the last beeps;
    bearings and their deviations are from the posterior over trajectories. Of several tracks one is judged anew in a
    beep, and the posteriors of the others are carried along their trajectories; a track that begins is shown once it
    has been judged. range2_m and bearing_rad are NaN for identical channels. For a phone held still there is
    `StandingDetector`.

    Args:
        beep: the emitted signal.
        phone: where speaker and microphones are.
        settings: the ranges that are searched, the danger distance, the walker's width and the number of candidates.
            Of `PaperSettings` no other constant may be changed.
        sound_speed_m_s: speed of sound that the detector assumes, whatever the air really does.
        pitch_rad: pitch of the phone, its top edge above the level; None to estimate it from the ground's echo.
        mic_phase_rad: what microphone 1's channel adds to the phase at the beep's centre, compared with microphone 0's:
            a property of the phone, measured once (`measure_mic_phase`). 0 stands for equal channels, as simulated
            phones have; None for not known, then only changes of phase from beep to beep count.

    Raises:
        ValueError: arguments out of range; the message names the value and the rule.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign, TrackingDetector, PhoneGeometry, Recording
    >>> beep = BeepDesign()
    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> time_s = np.arange(25 * beep.period_samples) / beep.sample_rate_hz
    >>> def train(path_m, speed_m_s=0.0):  # beeps by a path that shortens by twice the speed of the walker
    ...     emitted_s = ((343 + speed_m_s) * time_s - path_m) / (343 - speed_m_s)
    ...     return beep.waveform(emitted_s % beep.period_s)
    >>> walk = [0.1 * train(d) + 0.001 * train(e, 1.3) for d, e in [(0.0, 8.0), (0.14, 8.0 + 0.14)]]
    >>> detector = TrackingDetector(beep, phone)
    >>> detector
    TrackingDetector(flat, 18-23 kHz)
    >>> found = next(d for d in detector.stream(Recording(walk, beep.sample_rate_hz)) if d.decision.alert)
    >>> found
    Detection(index=23, range_m=[1.27], bearing_rad=[0.07], alert=True)
    >>> print(f"{found.closing_speed_m_s[0]:.1f} m/s, contact in {found.decision.time_to_collision_s:.1f} s")
    1.3 m/s, contact in 1.0 s
    """

    settings_type = TrackingSettings

    def __init__(
        self,
        beep: BeepDesign,
        phone: PhoneGeometry,
        settings: TrackingSettings | PaperSettings | None = None,
        sound_speed_m_s: float = 343.0,
        pitch_rad: float | None = None,
        mic_phase_rad: float | None = 0.0,
    ) -> None:
        check_arguments(beep, phone, sound_speed_m_s, pitch_rad)
        check_mic_phase(mic_phase_rad)
        self.settings = TrackingSettings.of(settings)
        super().__init__(beep, phone, expected_direct_delay_s(phone, sound_speed_m_s, self.settings.direct_delay_s))
        self._finder = PeakFinder(beep, phone, self.settings, sound_speed_m_s, pitch_rad)
        likelihood = LineLikelihood(self._finder.cells, self._finder.cell_m, beep.period_s)
        self._separation_m, self._baseline_m = phone.mic_separation_m, float(phone.speaker_to_mic_m[0])
        self._approaches = Approaches(beep.range_doppler_s, likelihood)
        wavelength_m, self._mic_phase_rad = self._finder.wavelength_m, mic_phase_rad
        self._steps = OscillationEstimator(
            self._separation_m, wavelength_m, self._finder.pitch_rad, beep.range_doppler_s
        )
        self._pitch_rad = np.nan
        self._take_pitch()
        self._oscillation, self._timing = STEADY, Timing(beep.range_doppler_s, beep.period_s)

    def reset(self) -> None:
        """Forget all beeps so far."""
        self._blocks.clear()
        self._finder.reset()
        self._approaches.clear()
        self._steps.clear()
        self._take_pitch()
        self._oscillation = STEADY

    def process(self, block: ArrayLike, time_s: float | None = None) -> Detection:
        """Follow one beep and decide; see `StreamingDetector.process`."""
        samples, begin_s = self._blocks.checked(block, time_s)
        found = self._finder.find(samples)
        index = self._blocks.passed(begin_s, time_s)
        if found is None:
            return self._report(index, begin_s, [], [], Flag.NO_BEEP)
        start_s, peaks = found
        self._take_pitch()
        emitted_s = begin_s + start_s
        hit_s = emitted_s + 0.5 * self.beep.duration_s
        if self._finder.ground is not None:
            self._steps.add(hit_s, self._finder.ground)
        tracks = [track for track in self._approaches.step(hit_s, peaks) if track.score >= CONFIRMED_SCORE]
        tracks = tracks[: self.settings.max_candidates]
        self._judge(tracks, hit_s)
        flag = Flag.IDENTICAL_CHANNELS if peaks.identical else Flag.NONE
        trajectories = [track.trajectory for track in tracks if track.trajectory is not None]
        return self._report(
            index, emitted_s, [track for track in tracks if track.trajectory is not None], trajectories, flag
        )

    def _take_pitch(self) -> None:
        """Judge by the pitch that is known from now on, if that is another than so far."""
        if self._pitch_rad == self._finder.pitch_rad:
            return
        self._pitch_rad = self._finder.pitch_rad
        self._steps.set_pitch(self._pitch_rad)
        self._grid = TrajectoryGrid(
            self._separation_m,
            self._finder.wavelength_m,
            self._pitch_rad,
            self.settings.walker_half_width_m,
            self.beep.range_doppler_s,
            self._mic_phase_rad,
            self._baseline_m,
        )

    def _judge(self, tracks: list[Track], hit_s: float) -> None:
        """Judge at most one track anew: judging all gains nothing."""
        track = next_to_judge(tracks, hit_s, self._approaches.searched)
        if track is not None:
            ground_m, samples = self._finder.ground_m, track.samples(self.beep.range_doppler_s)
            self._oscillation = self._steps.oscillation(ground_m)
            track.judged = self._grid.posterior(samples, hit_s, ground_m, self._oscillation)
            if track.judged.misfit > MOST_MISFIT:
                track.forget_oldest()
        for track in tracks:
            track.trajectory = None if track.judged is None else self._grid.trajectory(track.judged, hit_s)

    def _report(
        self, index: int, time_s: float, tracks: list[Track], trajectories: list[Expectation], flag: Flag
    ) -> Detection:
        found = [
            track.ranged(trajectory, self._oscillation, self._timing)
            for track, trajectory in zip(tracks, trajectories, strict=True)
        ]
        alarming = [
            self._is_alarming(track, trajectory) for track, trajectory in zip(tracks, trajectories, strict=True)
        ]
        known = [k for k in range(len(tracks)) if alarming[k] or found[k].std_m <= MOST_RANGE_STD_M]
        rows = [self._row(tracks[k], trajectories[k], found[k]) for k in known]
        columns = {name: np.array([row[name] for row in rows], dtype=np.float64) for name in COLUMNS}
        if flag is Flag.IDENTICAL_CHANNELS:
            columns |= dict.fromkeys(OF_TWO_MICS, np.full(len(known), np.nan))
        return Detection(
            **columns,
            index=index,
            time_s=time_s,
            collides=np.array([trajectories[k].collision >= 0.5 for k in known], dtype=bool),
            flags=np.full(len(known), int(flag | Flag.NO_RADIUS), dtype=np.int_),
            beep_flags=flag,
            decision=self._decide(time_s, any(alarming), tracks, trajectories, found),
        )

    def _row(self, track: Track, trajectory: Expectation, found: TrackRange) -> dict[str, float]:
        """One candidate's values by column."""
        # Peaks are read as if straight ahead; the path to the speaker, behind the microphone, is shorter off the axis.
        range_m = found.range_m + 0.5 * self._baseline_m * (1.0 - trajectory.cosine)
        return {
            "range_m": range_m,
            "range2_m": range_m + path_difference_at(range_m, trajectory.cosine, self._separation_m),
            "bearing_rad": trajectory.bearing_rad,
            "radius_m": np.nan,  # no echo depends on the width of what made it: 0.17 is the greatest rank correlation
            "level_db": track.level_db,
            "snr_db": track.snr_db,
            "closing_speed_m_s": found.closing_m_s,
            "range_std_m": found.std_m,
            "bearing_std_rad": trajectory.bearing_std_rad,
        }

    def _decide(
        self,
        time_s: float,
        alert: bool,
        tracks: list[Track],
        trajectories: list[Expectation],
        found: list[TrackRange],
    ) -> Decision:
        """Of the trajectories that rather collide, the first to do so."""
        farthest = min(FARTHEST_M, self.settings.danger_m)
        near = (t for o, t in zip(tracks, trajectories, strict=True) if t.left_m <= farthest and has_approached(o))
        stated = max((trajectory.collision for trajectory in near), default=0.0)
        likely = [k for k, trajectory in enumerate(trajectories) if trajectory.collision >= 0.5]
        if not likely:
            return Decision(False, time_s, np.nan, np.nan, 0, stated)
        first = min(likely, key=lambda k: trajectories[k].contact_s)
        return Decision(alert, time_s, found[first].range_m, trajectories[first].contact_s, len(likely), stated)

    def _is_alarming(self, track: Track, trajectory: Expectation) -> bool:
        """Whether a trajectory collides surely and soon enough."""
        due_now = 0.0 < trajectory.left_m <= min(FARTHEST_M, self.settings.danger_m)
        return due_now and trajectory.collision >= SURE and has_approached(track)


def has_approached(track: Track) -> bool:
    """Whether a track is detected and long enough, in beeps and in range, to be more than an echo that gait moves."""
    range_m = [read_m for _, read_m, _ in track.past]
    travelled = len(range_m) >= LEAST_BEEPS and range_m[0] - range_m[-1] >= LEAST_TRAVEL_M
    return track.misses <= MOST_MISSES and bool(travelled)


def is_pressing(track: Track) -> bool:
    """Whether a track that was just detected may raise an alert now, by what was expected of it a beep ago."""
    if track.trajectory is None or track.misses > 0 or track.trajectory.collision < PRESSING:
        return False
    return 0.0 < track.trajectory.left_m < FARTHEST_M + NEARLY_M


def next_to_judge(tracks: list[Track], now_s: float, searched: bool) -> Track | None:
    """Of the tracks that may raise an alert, if there are any, or else of all, the one that is due.

    A beep that was searched for tracks that begin leaves no time to judge what is far: that waits for the next one.
    """
    pressing = [track for track in tracks if is_pressing(track)]
    near = [track for track in tracks if not searched or track.range_m < WAITS_M]
    return due(pressing or near, now_s)


def due(tracks: list[Track], now_s: float) -> Track | None:
    """The track whose trajectory is to be judged: of those detected since they were, the longest not judged for its
    range."""

    def urgency(track: Track) -> float:
        if track.judged is None:
            return np.inf
        waited_s = now_s - track.judged.time_s if track.detected_s > track.judged.time_s else 0.0
        return waited_s / track.range_m

    most = max(tracks, key=urgency, default=None)
    return None if most is None or urgency(most) == 0.0 else most
