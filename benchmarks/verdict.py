"""A run's verdict in plain lines."""

from __future__ import annotations

import math
from typing import Any

QUANTITIES = (
    ("range_m", "range", "cm", 100.0),
    ("range2_m", "range to mic 2", "cm", 100.0),
    ("bearing_rad", "bearing", "degrees", 180.0 / math.pi),
    ("radius_m", "radius", "cm", 100.0),
)


def verdict_lines(summary: dict[str, Any]) -> list[str]:
    """TP, TN, false alerts, and median errors walking and standing, each with n and its 95 % interval."""
    lines = [f"{summary['cells']} cells, {summary['failed']} failed"]
    for name, found in summary["detectors"].items():
        lines.append(name)
        lines += [f"  {label:<24}{_share(found[key])}" for key, label in _RATES]
        for state in ("walking", "standing"):
            lines += [
                f"  {f'median {label} error, {state}':<40}{_median(found[state][key], unit, scale)}"
                for key, label, unit, scale in QUANTITIES
            ]
    return lines


_RATES = (("tp", "TP"), ("tn", "TN"), ("false_alerts_over_all", "false alerts over all"))


def _share(rate: dict[str, Any]) -> str:
    if rate["n"] == 0:
        return "no data"
    low, high = 100.0 * rate["low"], 100.0 * rate["high"]
    return f"{100.0 * rate['value']:5.1f} %   {rate['k']} of {rate['n']}, 95 % interval {low:.1f}-{high:.1f} %"


def _median(entry: dict[str, Any], unit: str, scale: float) -> str:
    if entry["n"] == 0:
        return f"no estimate in {entry['of']} beeps"
    text = f"{scale * entry['median']:6.2f} {unit}   n = {entry['n']} of {entry['of']} beeps"
    if not math.isfinite(entry["low"]):
        return f"{text} of one walk"
    return f"{text}, 95 % interval {scale * entry['low']:.2f}-{scale * entry['high']:.2f}"
