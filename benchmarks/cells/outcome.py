"""From an alert and the truth to one of TP, FN, TN, FP."""

from __future__ import annotations

from typing import Literal

import numpy as np

from benchmarks.cells.spec import Scoring

Outcome = Literal["TP", "FN", "TN", "FP"]


def outcome(alert: bool, alert_distance_m: float, collides: bool, margin_m: float) -> Outcome:
    """Our rule: a true alert comes at least `margin_m` before contact; any alert on another walk is false.

    Args:
        alert: whether there was one at all.
        alert_distance_m: distance walked from the first alert to contact; negative after contact, NaN without either.
        collides: whether the walker's body meets the target.
    """
    if not collides:
        return "FP" if alert else "TN"
    return "TP" if alert and alert_distance_m >= margin_m else "FN"


def outcome_paper(alert: bool, alert_distance_m: float, collides: bool, within_m: float) -> Outcome:
    """The paper's rule (section 3.2): a true alert comes before contact and within the danger distance, 3 m."""
    if not collides:
        return "FP" if alert else "TN"
    return "TP" if alert and 0.0 < alert_distance_m <= within_m else "FN"


def outcomes(
    alert: bool, alert_distance_m: float, collides: bool, line_collides: bool, rules: Scoring
) -> dict[str, str]:
    """All three: ours, the paper's rule for the alert, and the paper's rule for the collision (the phone's line)."""
    # A walk that the body does not survive but the line does has no contact by the looser rule: an alert is false.
    by_line = line_collides and collides
    return {
        "outcome": outcome(alert, alert_distance_m, collides, rules.alert_margin_m),
        "outcome_paper_alert": outcome_paper(alert, alert_distance_m, collides, rules.alert_within_m),
        "outcome_line": outcome(alert, alert_distance_m, by_line, rules.alert_margin_m),
    }


def distance_before(progress_at_alert_m: float, progress_at_contact_m: float) -> float:
    """Distance walked along the heading from alert to contact; NaN if either is."""
    return float(np.subtract(progress_at_contact_m, progress_at_alert_m))
