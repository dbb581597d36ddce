"""The numbers that the paper prints, each with its place. What it shows only as bars or curves is absent, not guessed.

Everything is in SI: rates are fractions, distances metres, angles radians.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple

import numpy as np

from scenes.streets.approaches import DATA_COLLECTION

Relation = Literal["=", "~", ">", "<="]
Unit = Literal["1", "m", "rad"]

SHOWN: dict[str, tuple[float, str]] = {"1": (100.0, " %"), "m": (100.0, " cm"), "rad": (180.0 / np.pi, "°")}
"""Unit in memory -> factor and the unit that people read."""
_SIGNS: dict[str, str] = {"=": "", "~": "about ", ">": ">", "<=": "≤"}


@dataclass(frozen=True)
class PaperValue:
    """One printed number.

    Attributes:
        value: SI, or a fraction for a rate.
        unit: "1" for rates, "m" or "rad".
        source: section and figure.
        relation: what the paper says of it: exactly, about, over, or at most.
    """

    value: float
    unit: Unit
    source: str
    relation: Relation = "="

    @property
    def display(self) -> float:
        """The number in the unit people read: %, cm or degrees."""
        return round(self.value * SHOWN[self.unit][0], 6)

    @property
    def short(self) -> str:
        """The number with its relation, without a unit: "94.6", ">93", "≤2"."""
        return f"{_SIGNS[self.relation].replace('about ', '~')}{self.display:.3g}"

    @property
    def text(self) -> str:
        """The number for a sentence: "94.6 %", ">93 %", "about 1 cm"."""
        return f"{_SIGNS[self.relation]}{self.display:.3g}{SHOWN[self.unit][1]}"


class RatePair(NamedTuple):
    """True positive and true negative rate of one stratum."""

    true_positive: PaperValue
    true_negative: PaperValue


def _rates(tp_percent: float, tn_percent: float, source: str, relation: Relation = "=") -> RatePair:
    return RatePair(
        PaperValue(tp_percent / 100.0, "1", source, relation), PaperValue(tn_percent / 100.0, "1", source, relation)
    )


def _cm(value_cm: float, source: str, relation: Relation = "=") -> PaperValue:
    return PaperValue(value_cm / 100.0, "m", source, relation)


def _degrees(value: float, source: str, relation: Relation = "=") -> PaperValue:
    return PaperValue(float(np.deg2rad(value)), "rad", source, relation)


OVERALL = _rates(93.0, 92.0, "section 4.2, Fig. 16", ">")
"""As printed. The case-weighted mean of its own scenes says otherwise of TN: see `case_weighted_mean`."""

BY_SCENE = MappingProxyType(
    {"supermarket": _rates(94.6, 93.2, "section 4.2, Fig. 17"), "campus": _rates(91.3, 89.1, "section 4.2, Fig. 17")}
)

BY_BAND = MappingProxyType(
    {"16-23 kHz": _rates(94.3, 91.4, "section 4.3, Fig. 18"), "18-23 kHz": _rates(93.7, 92.5, "section 4.3, Fig. 18")}
)
"""Supermarket only. Fig. 17 gives 94.6 / 93.2 for the same place: 1.5 points are noise."""

FALSE_ALERTS = MappingProxyType(
    {
        "PaperDetector": PaperValue(0.035, "1", "section 4.8, Fig. 26", "~"),
        "DistanceOnlyDetector": PaperValue(0.321, "1", "section 4.8, Fig. 26"),
    }
)
"""With and without fine-grained information. The denominator is not stated: 1 - TN is 6.8 to 10.9 % in Fig. 17."""

DISTANCE1_MEDIAN = MappingProxyType({1.5: _cm(0.25, "section 4.6, Fig. 21"), 5.0: _cm(0.3, "section 4.6, Fig. 23")})
"""Median error of D1 by standing distance, m; the paper prints none for 3 m."""

DISTANCE1_P90 = _cm(1.0, "section 4.6, Figs 21-23", "~")
DISTANCE2_P90 = _cm(2.0, "section 4.6, Figs 21-23", "<=")
"""Both "across different distances"."""

BEARING_MEDIAN = _degrees(4.0, "section 4.7, Fig. 24")
BEARING_P80 = _degrees(8.0, "section 4.7, Fig. 24", "<=")
RADIUS_MEDIAN = _cm(3.0, "section 4.7, Fig. 25")
RADIUS_P80 = _cm(7.0, "section 4.7, Fig. 25", "<=")

RADIUS_CORRELATION = 0.93
"""Of estimated and true radius (section 3.6, Fig. 11)."""


@dataclass(frozen=True)
class EnergyRow:
    """A row of Table 1: 30 minutes on one phone.

    Attributes:
        battery_mah, used_mah: charge, mAh.
        share: printed share of the battery.
    """

    phone: str
    battery_mah: float
    used_mah: float
    share: float
    duration_s: float = 1800.0


ENERGY = (
    EnergyRow("galaxy-s5", 2800.0, 64.0, 0.023),
    EnergyRow("galaxy-note5", 3000.0, 66.0, 0.022),
    EnergyRow("galaxy-s8-plus", 3500.0, 50.0, 0.014),
)
"""Table 1."""


def case_weighted_mean() -> RatePair:
    """TP and TN over both scenes as the scenes' own rates and cases imply: 93.4 and 91.7 %."""
    weights = [sum(DATA_COLLECTION[scene].cases.values()) for scene in BY_SCENE]
    tp, tn = (float(np.average([pair[k].value for pair in BY_SCENE.values()], weights=weights)) for k in range(2))
    source = "case-weighted mean of Fig. 17"
    return RatePair(PaperValue(tp, "1", source, "~"), PaperValue(tn, "1", source, "~"))
