"""A run's verdict in plain lines."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from benchmarks.scoring.scores import NARROW_M, left_in_words
from obstaclewatch.support.words import counted

QUANTITIES = (
    ("range_m", "range error", "cm", 100.0),
    ("range2_m", "range error to mic 2", "cm", 100.0),
    ("bearing_rad", "bearing error", "degrees", 180.0 / math.pi),
    ("radius_m", f"radius error, up to {2 * NARROW_M:g} m wide", "cm", 100.0),
)


def verdict_lines(summary: dict[str, Any]) -> list[str]:
    """TP by the distance left, TN, false alerts, TP where 95 % of the other walks stay quiet, and median errors walking
    and standing, each with n and its 95 % interval.

    Of what the run has cells for; of a sweep, the first four alone.
    """
    lines = [f"{counted(summary['cells'], 'cell')}, {summary['failed']} failed"]
    for point, detectors in summary.get("points", {}).items():
        lines.append(f"[{point}]")
        for name, found in detectors.items():
            lines += [f"  {name}", *(f"    {label:<46}{text}" for label, text in list(_told(found))[:_OF_A_POINT])]
    for name, found in summary.get("detectors", {}).items():
        lines += [name, *(f"  {label:<46}{text}" for label, text in _told(found))]
    return lines


def _told(found: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What is measured and how much; nothing of walks, standing phones or their loud echoes where there are none."""
    if found["false_alerts_over_all"]["n"]:
        for left_m, rate in sorted(found["tp"].items()):
            yield f"TP, {left_in_words(float(left_m))}", _share(rate)
        yield from ((label, _share(found[key])) for key, label in _RATES)
        for left_m, rates in sorted(found["swept"].items()):
            if TOLD_TNR in rates:
                yield f"TP at TN {TOLD_TNR} %, {left_in_words(float(left_m))}", _share(rates[TOLD_TNR])
    for state in ("walking", "standing"):
        for key, label, unit, scale in QUANTITIES:
            if found[state][key]["of"]:
                yield f"median {label}, {state}", _median(found[state][key], unit, scale)
    for key, label in (("range_m", "range"), ("range2_m", "mic 2")):
        entry = found["standing_against_echoes"][key]
        if entry["n"]:
            yield f"{label} against echoes, diagnostic", _median(entry, "cm", 100.0)


_OF_A_POINT = 4
"""TP and TN: a sweep has many points, and `summary.json` and the figures tell the rest."""
TOLD_TNR = "95"
_RATES = (
    ("tn", "TN"),
    ("false_alerts_over_negatives", "false alerts, of walks without a collision"),
    ("false_alerts_over_all", "false alerts, of all walks"),
)


def _share(rate: dict[str, Any]) -> str:
    if rate["n"] == 0:
        return "no data"
    low, high = 100.0 * rate["low"], 100.0 * rate["high"]
    return f"{100.0 * rate['value']:5.1f} %   {rate['k']} of {rate['n']}, 95 % interval {low:.1f}-{high:.1f} %"


def _median(entry: dict[str, Any], unit: str, scale: float) -> str:
    if entry["n"] == 0:
        return f"no estimate in {counted(entry['of'], 'beep')}"
    text = f"{scale * entry['median']:6.2f} {unit}   n = {entry['n']} of {counted(entry['of'], 'beep')}"
    if not math.isfinite(entry["low"]):
        return f"{text}, of too few walks for an interval"
    return f"{text}, 95 % interval {scale * entry['low']:.2f}-{scale * entry['high']:.2f}"
