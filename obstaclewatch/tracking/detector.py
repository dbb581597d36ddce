"""Our detector: obstacles followed over beeps, and a test of each one's trajectory.

Peaks under a low threshold (`moving_peaks`) and likelihood along lines (`track_before_detect`) -> tracks of what
closes in, without range-Doppler bias (`tracks`) -> the phone's oscillation, from the ground's echo
(`pitch_oscillation`) -> the probability of each trajectory, by ranges and microphone 1 (`posterior_grid`), sums of
likelihood along walked paths, for what no track follows (`approach_sums`), and what the last beeps received, laid out
along approaches (`approach_picture`) -> the probability of a collision, as learned from simulated walks
(`collision_model`) -> an alert if that is enough for the distance left. The bearing of a track is learned likewise
(`bearing_model`), from the probability of its trajectories.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import COLUMNS, Decision, Detection, Flag
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.recordings.streaming import StreamingDetector, checked_arguments
from obstaclewatch.signal.carrier_phase import checked_mic_phase
from obstaclewatch.signal.direct_sound import expected_direct_delay_s
from obstaclewatch.signal.pulse import pulse_shape
from obstaclewatch.signal.two_mics import path_difference_at
from obstaclewatch.support.argument_types import as_number
from obstaclewatch.support.arrays import Floats
from obstaclewatch.tracking.approach_picture import NO_PICTURE, Carrier, approach_picture
from obstaclewatch.tracking.approach_sums import ApproachMemory
from obstaclewatch.tracking.bearing_evidence import NUMBERS, bearing_evidence
from obstaclewatch.tracking.bearing_model import bearing_model
from obstaclewatch.tracking.collision_model import collision_model
from obstaclewatch.tracking.evidence import FRONT_M, NO_EVIDENCE, evidence_of
from obstaclewatch.tracking.moving_peaks import MovingPeaks, PeakFinder
from obstaclewatch.tracking.range_fit import Timing, TrackRange
from obstaclewatch.tracking.settings import TrackingSettings
from obstaclewatch.tracking.track_before_detect import LineLikelihood
from obstaclewatch.tracking.tracks import Approaches, Track
from obstaclewatch.trajectories.posterior import WALKING_M_S
from obstaclewatch.trajectories.posterior_grid import Expectation, TrajectoryGrid
from obstaclewatch.walker.pitch_oscillation import STEADY, OscillationEstimator
from obstaclewatch.walker.walking_speed import USUAL, walk_ratio, walking_speed

CONFIRMED_SCORE = 8.0
"""Log likelihood ratio at which a track is shown and judged."""
CREST_LEVEL = 0.5
"""Of its peak, to which the compressed beep must fall soon, as `PaperSettings.crest_level` asks."""
FARTHEST_M = 1.6
"""Distance left from which on collisions were learned, and alerts are given."""
OF_TWO_MICS = ("range2_m", "bearing_rad", "bearing_std_rad")
"""Columns that need two different channels."""
NOTHING_KNOWN = (Flag.NO_BEEP, Flag.DAMAGED)
"""Flags of beeps that say nothing of obstacles."""
MOST_RANGE_STD_M = 0.03
"""Claimed deviation of the range beyond which a track is not shown."""
NO_BEARINGS: Floats = np.zeros((0, NUMBERS))
MOST_MISFIT = 2.0
"""Squared deviations, a reading, beyond which no trajectory explains a track: it began on another echo."""


class TrackingDetector(StreamingDetector):
    """Follows obstacles over beeps and alerts by the probability of a collision.

    Detections hold the confirmed tracks whose range is known: without range-Doppler bias, fitted to the last beeps;
    bearings and their deviations are learned from simulated walks. range2_m and bearing_rad are NaN where microphone 1
    is deaf or its channel a multiple of the other. An alert may be due to an echo that is too weak to be followed: it
    has no candidate then. For a phone held still there is `StandingDetector`.

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
        false_alert_cost: what a false alert costs, re a collision without an alert. More means fewer alerts of both
            kinds, and later ones; docs/learned.md has what it does in the street.
        walk_ratio_m_min: metres that the walker's step is long for each step a minute: a property of the walker,
            measured once (`measured_walk_ratio`). None for not known: people's, give or take 12 %.

    Attributes:
        evidence, picture: what the last beep's decision is based on.
        bearing_evidence: (n, NUMBERS) what the bearings of its candidates are based on.

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
    Detection(index=21, range_m=[1.5], bearing_rad=[0.07], alert=True)
    >>> print(f"{found.closing_speed_m_s[0]:.1f} m/s, contact in {found.decision.time_to_collision_s:.1f} s")
    1.3 m/s, contact in 1.1 s
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
        false_alert_cost: float = 1.0,
        walk_ratio_m_min: float | None = None,
    ) -> None:
        sound_speed_m_s, pitch_rad = checked_arguments(beep, phone, sound_speed_m_s, pitch_rad)
        mic_phase_rad = checked_mic_phase(mic_phase_rad)
        false_alert_cost = as_number("false_alert_cost", false_alert_cost)
        if not 0.0 < false_alert_cost < np.inf:
            raise ValueError(f"false_alert_cost must be positive and finite, got {false_alert_cost}")
        self._walk_ratio = walk_ratio(walk_ratio_m_min)
        self.settings = TrackingSettings.of(settings)
        pulse_shape(beep, CREST_LEVEL, sound_speed_m_s)  # refuses a band so narrow that no crest is one echo's
        super().__init__(beep, phone, expected_direct_delay_s(phone, sound_speed_m_s, self.settings.direct_delay_s))
        self._finder = PeakFinder(beep, phone, self.settings, sound_speed_m_s, pitch_rad)
        likelihood = LineLikelihood(self._finder.cells, self._finder.cell_m, beep.period_s)
        self._separation_m = phone.mic_separation_m
        self._behind_m = -phone.speaker_cosine * float(phone.speaker_to_mic_m[0])
        self._approaches = Approaches(beep.range_doppler_s, likelihood)
        self._memory, self._model = ApproachMemory(self._finder.cells, self._finder.samples), collision_model()
        self._false_alert_cost = false_alert_cost
        self.evidence, self.picture, self.bearing_evidence = NO_EVIDENCE, NO_PICTURE, NO_BEARINGS
        self._bearings = bearing_model()
        wavelength_m, self._mic_phase_rad = self._finder.wavelength_m, mic_phase_rad
        self._steps = OscillationEstimator(
            self._separation_m, wavelength_m, self._finder.pitch_rad, beep.range_doppler_s
        )
        self._pitch_rad = np.nan
        self._take_pitch()
        self._oscillation, self._walking = STEADY, USUAL
        self._timing = Timing(beep.range_doppler_s, beep.period_s)

    def reset(self) -> None:
        """Forget all beeps so far."""
        self._blocks.clear()
        self._finder.reset()
        self._forget()

    def _forget(self) -> None:
        """Forget all that was gathered from peaks."""
        self._approaches.clear()
        self._steps.clear()
        self._memory.clear()
        self.evidence, self.picture, self.bearing_evidence = NO_EVIDENCE, NO_PICTURE, NO_BEARINGS
        self._take_pitch()
        self._oscillation, self._walking = STEADY, USUAL

    def process(self, block: ArrayLike, time_s: float | None = None) -> Detection:
        """Follow one beep and decide; see `StreamingDetector.process`."""
        samples, begin_s = self._blocks.checked(block, time_s)
        found = self._finder.find(samples)
        index = self._blocks.passed(begin_s, time_s)
        if isinstance(found, Flag):
            return self._report(index, begin_s, [], [], found)
        if self._finder.began_anew:
            self._forget()
        start_s, peaks = found
        self._take_pitch()
        emitted_s = begin_s + start_s
        hit_s = emitted_s + 0.5 * self.beep.duration_s
        if self._finder.ground is not None:
            self._steps.add(hit_s, self._finder.ground)
        tracks = [track for track in self._approaches.step(hit_s, peaks) if track.score >= CONFIRMED_SCORE]
        tracks = tracks[: self.settings.max_candidates]
        self._memory.add(hit_s, peaks.moved)
        self._oscillation = self._steps.oscillation(self._finder.ground_m)
        self._walking = walking_speed(self._steps.step_hz, self._walk_ratio)
        trajectories = [self._judged(track, hit_s) for track in tracks]
        self._look(hit_s, peaks, tracks)
        return self._report(index, emitted_s, tracks, trajectories, peaks.flag)

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
            self._behind_m,
        )

    def _judged(self, track: Track, hit_s: float) -> Expectation:
        """What to expect of a track, judged anew if it was detected since it last was."""
        if track.judged is None or track.detected_s > track.judged.time_s:
            samples = track.samples(self.beep.range_doppler_s)
            received = self._oscillation, self._walking
            track.judged = self._grid.posterior(samples, hit_s, self._finder.ground_m, *received)
            if track.judged.misfit > MOST_MISFIT:
                track.forget_oldest()
        track.trajectory = self._grid.trajectory(track.judged, hit_s)
        return track.trajectory

    def _look(self, hit_s: float, peaks: MovingPeaks, tracks: list[Track]) -> None:
        """Gather what the decision is based on."""
        ahead_s, ground_m, place = self.beep.range_doppler_s, self._finder.ground_m, (peaks.first_m, peaks.cell_m)
        speed_m_s = self._walking.mean_m_s
        sums = self._memory.sums(hit_s, *place, ground_m, self._oscillation, speed_m_s, ahead_s)
        carrier = Carrier(speed_m_s, ground_m, self._separation_m, self._pitch_rad, self._oscillation.step_rad_s)
        self.evidence = evidence_of(tracks, sums, carrier, self.evidence)
        phases = self._finder.wavelength_m, None if peaks.flag else self._mic_phase_rad
        recent = self._memory.recent(*place)
        self.picture = approach_picture(recent, hit_s, ahead_s, carrier, self._oscillation, *phases)

    def _report(
        self, index: int, time_s: float, tracks: list[Track], trajectories: list[Expectation], flag: Flag
    ) -> Detection:
        found = [
            track.ranged(trajectory, self._oscillation, self._timing)
            for track, trajectory in zip(tracks, trajectories, strict=True)
        ]
        known = [k for k in range(len(tracks)) if found[k].std_m <= MOST_RANGE_STD_M]
        evidence = [self._bearing_evidence(tracks[k], trajectories[k], found[k]) for k in known]
        self.bearing_evidence = np.array(evidence).reshape(-1, NUMBERS)
        bearings = zip(*self._bearings.bearings(self.bearing_evidence), strict=True)
        rows = [self._row(tracks[k], trajectories[k], found[k], *own) for k, own in zip(known, bearings, strict=True)]
        columns = {name: np.array([row[name] for row in rows], dtype=np.float64) for name in COLUMNS}
        if flag in (Flag.IDENTICAL_CHANNELS, Flag.NO_SECOND_MIC):
            columns |= dict.fromkeys(OF_TWO_MICS, np.full(len(known), np.nan))
        return Detection(
            **columns,
            index=index,
            time_s=time_s,
            collides=np.array([trajectories[k].collision >= 0.5 for k in known], dtype=bool),
            flags=np.full(len(known), int(flag | Flag.NO_RADIUS), dtype=np.int_),
            beep_flags=flag,
            decision=no_decision(time_s) if flag in NOTHING_KNOWN else self._decide(time_s, trajectories, found),
        )

    def _bearing_evidence(self, track: Track, trajectory: Expectation, found: TrackRange) -> Floats:
        """What speaks for each bearing of a judged track."""
        assert track.judged is not None
        shares = self._grid.bearing_shares(track.judged, track.time_s)
        return bearing_evidence(trajectory, found, len(track.past), shares)

    def _row(
        self, track: Track, trajectory: Expectation, found: TrackRange, bearing_rad: float, bearing_std_rad: float
    ) -> dict[str, float]:
        """One candidate's values by column."""
        # Peaks are read as if straight ahead; the path to a speaker behind the microphone is shorter off the axis.
        range_m = found.range_m + 0.5 * self._behind_m * (1.0 - trajectory.cosine)
        return {
            "range_m": range_m,
            "range2_m": range_m + path_difference_at(range_m, trajectory.cosine, self._separation_m),
            "bearing_rad": bearing_rad,
            "bearing_std_rad": bearing_std_rad,
            "radius_m": np.nan,  # no echo depends on the width of what made it: 0.17 is the greatest rank correlation
            "level_db": track.level_db,
            "snr_db": track.snr_db,
            "closing_speed_m_s": found.closing_m_s,
            "range_std_m": found.std_m,
        }

    def _decide(self, time_s: float, trajectories: list[Expectation], found: list[TrackRange]) -> Decision:
        """Of the trajectories that rather collide, the first to do so; without any, or where the sums say what is left,
        that distance."""
        probability, left_m = self._model.probability(self.evidence, self.picture), self.evidence.distance_left_m
        near = left_m <= min(FARTHEST_M, self.settings.danger_m)
        alert = near and bool(self._model.suffices(probability, left_m, self._false_alert_cost))
        likely = [k for k, trajectory in enumerate(trajectories) if trajectory.collision >= 0.5]
        if alert and not (likely and self.evidence.by_track):
            range_m, contact_s = left_m + FRONT_M, left_m / WALKING_M_S
        elif likely:
            first = min(likely, key=lambda k: trajectories[k].contact_s)
            range_m, contact_s = found[first].range_m, trajectories[first].contact_s
        else:
            range_m, contact_s = np.nan, np.nan
        return Decision(alert, time_s, range_m, contact_s, len(likely), probability)


def no_decision(time_s: float) -> Decision:
    """Of a beep that was not received, or is damaged."""
    return Decision(False, time_s, np.nan, np.nan, 0, 0.0)
