"""The paper's constants, and those it leaves open, as documented defaults."""

from __future__ import annotations

import reprlib
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from obstaclewatch.paper.errata import Errata
from obstaclewatch.signal.direct_delay import check_direct_delay
from obstaclewatch.support.argument_types import as_number, check_counts, check_types, hold_numbers

MOST_COUNT = 10_000
MOST_DB = 500.0
"""Of a level: far beyond, its power is no number any more."""
WIDEST_M = 10.0
"""Of half a walker, and from the phone to a walker; what is wider is given in another unit."""
FASTEST_M_S = 100.0
"""Of an approach: speeds are tried one by one up to it."""
COUNTS = ("max_candidates", "votes_needed", "votes_of")
PAIRS = ("closing_speed_m_s", "body_distance_m", "crest_radius")
OPTIONAL = ("crest_radius", "direct_delay_s")

NOT_NEGATIVE = (
    "threshold_factor", "cfar_factor", "static_tolerance_m", "closing_tolerance_m", "walker_half_width_m",
    "gate_margin_m",
)  # fmt: skip


@dataclass(frozen=True)
class PaperSettings:
    """Constants of the paper's detector.

    Attributes:
        near_m, far_m: one-way ranges that are searched. Far: 7 m (section 3.4). Near: below 0.3 m the direct sound and
            the hand mask everything.
        threshold_factor: lambda of section 3.4, which the paper does not print, for the threshold as printed. At 3,
            noise alone passes once in 1,200 independent cells.
        cfar_factor: multiple of the local 60 % quantile, for the corrected threshold. At 3, noise alone passes once in
            3,800 independent cells.
        floor_db: least threshold, relative to the direct sound; matters only where there is no noise.
        peak_window_s: 0.5 ms, the paper's window, also the least distance between two peaks.
        max_candidates: the five nearest peaks (section 3.4).
        static_tolerance_m: how far a static peak may wander. A phone that bobs by 2.5 cm twice a second moves the
            ground's echo by 2.5 cm and, through range-Doppler coupling (0.205 s x 0.31 m/s), reads +-7 cm.
        static_age_s: only beeps at least this old distinguish static from moving; at 0.45 m/s an echo has left by then.
        history_s: how long peaks are remembered. Three beeps between `static_age_s` and this age are needed to judge.
        closing_speed_m_s: (slowest, fastest) approach that counts as "decreases gradually" (section 3.6).
        closing_tolerance_m: how far a peak may be from a constant approach.
        evaluation_m: collisions are evaluated within 5 m (section 3.6).
        danger_m: alerts are raised within 3 m (section 3.2).
        votes_needed, votes_of: five collision decisions out of nine detections (section 3.6).
        walker_half_width_m: half the width of the walker's body, for Eq. 4.
        crest_level: level, relative to the peak, at which a crest's trailing width is read.
        crest_radius: radius of a crest without width, m, and how much it grows per metre of half a crest's width: a
            line fitted to things of known size, as in Fig. 11, which replaces Eq. 3. It needs the crest as printed
            (`Errata.pulse_width_removed` false). None takes Eq. 3.
        body_distance_m: (least, greatest) distance from microphone 1 to the walker's body.
        gate_margin_m: how far path 2 - path 1 may lie outside +-L before it is another echo; 3 cm is three standard
            deviations at 20 dB.
        second_mic_snr_db: least SNR of a peak at microphone 1.
        second_mic_level_db: least level of a candidate at microphone 1 relative to microphone 0. The rear microphone
            is 8-10 dB weaker to the front; what is 30 dB weaker is a sidelobe.
        direct_delay_s: calibrated delay of the direct peak at microphone 0 after emission; None takes the air path
            speaker_to_mic_m[0] / c. Where sound through the case dominates, measure it (`measured_direct_delay_s`).
        errata: which formulas to correct.

    Raises:
        ValueError: a value out of order; the message names it.

    >>> settings = PaperSettings(votes_needed=3)
    >>> settings.votes_needed, settings.votes_of, settings.danger_m
    (3, 9, 3.0)
    >>> PaperSettings(votes_needed=12)
    Traceback (most recent call last):
    ValueError: votes_needed must be 1..votes_of, got 12 of 9
    """

    near_m: float = 0.3
    far_m: float = 7.0
    threshold_factor: float = 3.0
    cfar_factor: float = 3.0
    floor_db: float = -85.0
    peak_window_s: float = 0.5e-3
    max_candidates: int = 5
    static_tolerance_m: float = 0.12
    static_age_s: float = 0.25
    history_s: float = 0.75
    closing_speed_m_s: tuple[float, float] = (0.4, 3.5)
    closing_tolerance_m: float = 0.08
    evaluation_m: float = 5.0
    danger_m: float = 3.0
    votes_needed: int = 5
    votes_of: int = 9
    walker_half_width_m: float = 0.25
    crest_level: float = 0.5
    crest_radius: tuple[float, float] | None = None
    body_distance_m: tuple[float, float] = (0.1, 0.8)
    gate_margin_m: float = 0.03
    second_mic_snr_db: float = 12.0
    second_mic_level_db: float = -30.0
    direct_delay_s: float | None = None
    errata: Errata = field(default_factory=Errata)

    def __post_init__(self) -> None:
        self._hold_types()
        if not 0.0 < self.near_m < self.far_m < np.inf:
            raise ValueError(f"near_m and far_m must be 0 < near_m < far_m, got {self.near_m} and {self.far_m}")
        if not 1 <= self.votes_needed <= self.votes_of:
            raise ValueError(f"votes_needed must be 1..votes_of, got {self.votes_needed} of {self.votes_of}")
        if not 0.0 < self.crest_level < 1.0:
            raise ValueError(f"crest_level must lie between 0 and 1, got {self.crest_level}")
        line = self.crest_radius
        if line is not None and (self.errata.pulse_width_removed or not np.isfinite(line).all()):
            raise ValueError(f"crest_radius must be two numbers, with the crest as printed, got {line}")
        if not 0.0 < self.static_age_s < self.history_s < np.inf:
            raise ValueError(
                f"static_age_s must be positive and below history_s, got {self.static_age_s} and {self.history_s}"
            )
        self._check_numbers()
        for name, most in (("closing_speed_m_s", FASTEST_M_S), ("body_distance_m", WIDEST_M)):
            low, high = getattr(self, name)
            if not 0.0 < low < high:
                raise ValueError(f"{name} must be (low, high) with 0 < low < high, got {(low, high)}")
            if not high <= most:
                raise ValueError(f"{name} must be (low, high) with high at most {most:g}, got {(low, high)}")

    @classmethod
    def as_printed(cls, **others: Any) -> PaperSettings:
        """Every formula as it stands in the paper; further settings by name."""
        return cls(**READINGS["as_printed"] | others)

    @classmethod
    def calibrated(cls, **others: Any) -> PaperSettings:
        """The paper at its best fair reading: radius calibrated as in its Fig. 11, lambda chosen; further settings by
        name.

        >>> PaperSettings.calibrated().errata.local_threshold
        False
        """
        return cls(**READINGS["calibrated"] | others)

    @classmethod
    def of(cls, settings: PaperSettings | None) -> PaperSettings:
        """Settings as they are given; None takes the defaults.

        Raises:
            ValueError: another type.
        """
        if settings is None:
            return cls()
        check_types(settings=(settings, cls))
        return settings

    def _hold_types(self) -> None:
        """Hold Python's own numbers, and refuse what no comparison can refuse: texts, fractions of a count."""
        check_types(errata=(self.errata, Errata))
        for name in (each.name for each in fields(self) if each.name != "errata"):
            value = getattr(self, name)
            if name in OPTIONAL and value is None:
                continue
            if name in COUNTS:
                check_counts(1, **{name: value})
                if value > MOST_COUNT:
                    raise ValueError(f"{name} must be at most {MOST_COUNT}, got {reprlib.repr(value)}")
                object.__setattr__(self, name, int(value))
            elif name not in PAIRS:
                hold_numbers(self, name)
            elif not isinstance(value, (tuple, list)) or len(value) != 2:
                raise ValueError(f"{name} must be two numbers, got {value!r}")
            else:
                object.__setattr__(self, name, tuple(as_number(f"{name}[{k}]", value[k]) for k in (0, 1)))

    def _check_numbers(self) -> None:
        """Refuse what would stop all detections without an error: NaN is below, above and within nothing."""
        if not self.peak_window_s < np.inf:
            raise ValueError(f"peak_window_s must be finite, got {self.peak_window_s}")
        for name in ("peak_window_s", "evaluation_m", "danger_m"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        for name in NOT_NEGATIVE:
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be finite and not negative, got {getattr(self, name)}")
        for name in ("floor_db", "second_mic_snr_db", "second_mic_level_db"):
            level_db = getattr(self, name)
            if not level_db < np.inf:
                raise ValueError(f"{name} must be a level in dB, got {level_db}")
            if level_db > MOST_DB:
                raise ValueError(f"{name} must be at most {MOST_DB:g} dB, got {level_db}")
        if self.walker_half_width_m > WIDEST_M:
            raise ValueError(f"walker_half_width_m must be at most {WIDEST_M:g} m, got {self.walker_half_width_m}")
        if self.direct_delay_s is not None:
            check_direct_delay(self.direct_delay_s)


READINGS: dict[str, dict[str, Any]] = {
    "as_printed": {"errata": Errata.as_printed()},
    "calibrated": {
        "threshold_factor": 3.0,
        "crest_radius": (0.306, 0.005),
        "errata": Errata(pulse_width_removed=False, local_threshold=False),
    },
}
"""Named settings of the paper's detector; by default its formulas are corrected. "calibrated" was chosen on 40
development walks of the recipe `paper`. With lambda 2, 2.5 and 3 it has TP 7 and TN 20 of 20 (as corrected TP 1; with
1.5, TN 19), with 3 the most alerts a metre before contact. The line is the least-squares fit to its 18 narrow targets,
whose crests hardly tell the radius: correlation 0.05 (`docs.studies.crest_calibration`)."""
