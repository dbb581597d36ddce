"""What the paper reports in numbers. What it shows as bars or curves without numbers is absent here, not guessed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PaperValue:
    """One published number.

    Attributes:
        quantity: key by which scores and figures ask for it.
        condition: scene, band, distance or phone; "" if none.
        value: in `unit`.
        unit: "%", "cm", "deg" or "mAh".
        source: figure, table and section.
        wording: what the paper says, where that is less exact than a number.
    """

    quantity: str
    condition: str
    value: float
    unit: str
    source: str
    wording: str = ""


PAPER: tuple[PaperValue, ...] = (
    PaperValue("tp_rate", "overall", 93.0, "%", "Fig. 16, section 4.2", "over 93 %"),
    PaperValue("tn_rate", "overall", 92.0, "%", "Fig. 16, section 4.2", "over 92 %"),
    PaperValue("tp_rate", "supermarket", 94.6, "%", "Fig. 17, section 4.2"),
    PaperValue("tn_rate", "supermarket", 93.2, "%", "Fig. 17, section 4.2"),
    PaperValue("tp_rate", "campus", 91.3, "%", "Fig. 17, section 4.2"),
    PaperValue("tn_rate", "campus", 89.1, "%", "Fig. 17, section 4.2"),
    PaperValue("tp_rate", "16-23 kHz", 94.3, "%", "Fig. 18, section 4.3"),
    PaperValue("tp_rate", "18-23 kHz", 93.7, "%", "Fig. 18, section 4.3"),
    PaperValue("tn_rate", "16-23 kHz", 91.4, "%", "Fig. 18, section 4.3"),
    PaperValue("tn_rate", "18-23 kHz", 92.5, "%", "Fig. 18, section 4.3"),
    PaperValue("range1_median", "1.5 m", 0.25, "cm", "Fig. 21, section 4.6"),
    PaperValue("range1_median", "5 m", 0.3, "cm", "Fig. 23, section 4.6"),
    PaperValue("range1_p90", "1.5 m", 1.0, "cm", "Fig. 21, section 4.6", "around 1 cm"),
    PaperValue("range1_p90", "3 m", 1.0, "cm", "Fig. 22, section 4.6", "around 1 cm"),
    PaperValue("range1_p90", "5 m", 1.0, "cm", "Fig. 23, section 4.6", "around 1 cm"),
    PaperValue("range2_p90", "1.5 m", 2.0, "cm", "Fig. 21, section 4.6", "within 2 cm"),
    PaperValue("range2_p90", "3 m", 2.0, "cm", "Fig. 22, section 4.6", "within 2 cm"),
    PaperValue("range2_p90", "5 m", 2.0, "cm", "Fig. 23, section 4.6", "within 2 cm"),
    PaperValue("bearing_median", "", 4.0, "deg", "Fig. 24, section 4.7"),
    PaperValue("bearing_p80", "", 8.0, "deg", "Fig. 24, section 4.7"),
    PaperValue("radius_median", "", 3.0, "cm", "Fig. 25, section 4.7"),
    PaperValue("radius_p80", "", 7.0, "cm", "Fig. 25, section 4.7"),
    PaperValue("false_alerts", "DistanceOnlyDetector", 32.1, "%", "Fig. 26, section 4.8"),
    PaperValue("false_alerts", "PaperDetector", 3.5, "%", "Fig. 26, section 4.8", "around 3.5 %"),
    PaperValue("energy_30_min", "galaxy-s5", 64.0, "mAh", "Table 1, section 4.9"),
    PaperValue("energy_30_min", "galaxy-note5", 66.0, "mAh", "Table 1, section 4.9"),
    PaperValue("energy_30_min", "galaxy-s8-plus", 50.0, "mAh", "Table 1, section 4.9"),
)


def paper_value(quantity: str, condition: str = "") -> PaperValue | None:
    """The published number, or None where the paper prints none."""
    return next((v for v in PAPER if (v.quantity, v.condition) == (quantity, condition)), None)
