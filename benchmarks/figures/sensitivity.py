"""What one thing changed at a time does to alerts and errors (tornado), and left against right."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from benchmarks.figures.measured import judged_detectors
from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure
from benchmarks.figures.variants import holding_name, variant_name, variants
from benchmarks.results import RunData
from benchmarks.scores import (
    absolute_errors,
    approach_table,
    beep_table,
    rate,
    true_negative_rate,
    true_positive_rate,
)

Measure = Callable[[RunData, str], float]
_SHORT = {
    "recording.": "",
    "knowledge.": "",
    "walk.": "",
    "air.": "",
    "phone.": "beep ",
    "noise.level_spl_db": "noise dB",
    "level_spl_db": "dB",
    "mic_gain_db": "gain dB",
    "mic_delay_samples": "lag",
    "clock_ppm": "clock ppm",
    "pitch_error_rad": "lift error rad",
    "pitch_rad": "lift rad",
    "temperature_c": "°C",
    "relative_humidity": "humidity",
    "speed_m_s": "speed m/s",
    "gait_scale": "gait x",
    "identical=True": "equal channels",
}


def error_tornado(run: RunData) -> PlotFigure:
    """Change of the median range error, the median bearing error, and the share of beeps with an estimate."""
    return _tornado(
        run,
        "tornado",
        "One thing changed at a time · errors of the target",
        (
            ("range, median error", "cm", _range_error),
            ("bearing, median error", "°", _bearing_error),
            ("beeps with an estimate", "%", _estimates),
        ),
        judged_detectors(run)[:1],
    )


def alert_tornado(run: RunData) -> PlotFigure:
    """Change of TP and TN."""
    measures = (("TP", "%", _tp), ("TN", "%", _tn))
    return _tornado(run, "tornado_alerts", "One thing changed at a time · alerts", measures, judged_detectors(run))


def sides(run: RunData) -> PlotFigure:
    """How often the side of an obstacle is known, by its true bearing: landscape holding tells left from right."""
    panels, said = [], []
    edges = np.array([0.0, 5.0, 10.0, 20.0, 30.0, 45.0])
    for part in variants(run).values():
        lines = []
        for detector in judged_detectors(part):
            x, y, low, high = [], [], [], []
            bearing, right = side_calls(part, detector)
            for least, most in pairwise(edges):
                inside = (bearing >= least) & (bearing < most)
                found = rate(right[inside])
                if found.n:
                    x.append(0.5 * (least + most))
                    y.append(100 * found.value)
                    low.append(100 * found.low)
                    high.append(100 * found.high)
            lines.append(Line(detector, detector, np.array(x), np.array(y), "points", np.array(low), np.array(high)))
            total = rate(right[bearing >= 5.0])
            if total.n:
                said.append(
                    f"{_holding(part)}: {100 * total.value:.0f} % of {total.n} beeps beyond 5° on the right side"
                )
        panels.append(
            Panel(
                _holding(part),
                "true bearing off the heading, °",
                "right side called, %",
                tuple(lines),
                (Guide("y", 50.0, "guessing"),),
                x_range=(0.0, 45.0),
                y_range=(0.0, 103.0),
            )
        )
    return PlotFigure(
        "sides",
        "Left or right?",
        tuple(panels),
        f"{'; '.join(said)}." if said else "No data.",
        "The side is called by which half of the phone the bearing lies in: an estimate below 90° is "
        "towards microphone 1, to the left in landscape. In portrait that says nothing of sides, and the "
        "share is that of targets on the left. Whiskers: Wilson, beeps taken as independent.",
    )


def _tornado(
    run: RunData, name: str, title: str, measures: tuple[tuple[str, str, Measure], ...], detectors: list[str]
) -> PlotFigure:
    parts = variants(run)
    base, changed = parts.get("as it is"), {k: v for k, v in parts.items() if k != "as it is"}
    panels: list[Panel] = []
    said: list[str] = []
    if base is not None and changed:
        order = _by_effect(base, changed, measures[0][2], detectors[0])
        ticks = tuple(_shortened(each) for each in order)
        for label, unit, measure in measures:
            lines = []
            for k, detector in enumerate(detectors):
                before = measure(base, detector)
                delta = np.array([measure(changed[each], detector) - before for each in order])
                place = np.arange(len(order)) + 0.16 * (k - 0.5 * (len(detectors) - 1))
                lines.append(Line(detector, detector, delta, place, "points"))
                worst = int(np.nanargmax(np.abs(delta))) if np.isfinite(delta).any() else 0
                most = f"most changed by {ticks[worst]} ({delta[worst]:+.1f})"
                said.append(f"{label}, {detector}: {before:.1f} {unit} as it is, {most}")
            shown = ticks if not panels else tuple("" for _ in ticks)
            panels.append(
                Panel(
                    label,
                    f"change, {unit}",
                    "",
                    tuple(lines),
                    (Guide("x", 0.0, ""),),
                    ticks=shown,
                    flat=True,
                    width_in=2.4,
                )
            )
    return PlotFigure(
        name,
        title,
        tuple(panels) or (Panel("", "", "", ()),),
        f"{'; '.join(said)}." if said else "No data.",
        "The same walks with one thing changed; 0 is the suite as it is. Errors are over the beeps that "
        "have an estimate, so a change that silences the detector may look harmless in the first two."
        if name == "tornado"
        else "The same walks with one thing changed; 0 is the suite as it is.",
        height_in=max(2.7, 0.2 * len(changed) + 0.5),
    )


def _by_effect(base: RunData, changed: dict[str, RunData], measure: Measure, detector: str) -> list[str]:
    before = measure(base, detector)
    effect = {name: abs(measure(part, detector) - before) for name, part in changed.items()}
    return sorted(changed, key=lambda name: -np.nan_to_num(effect[name], nan=-1.0))


def _shortened(name: str) -> str:
    for long, short in _SHORT.items():
        name = name.replace(long, short)
    return name


def side_calls(run: RunData, detector: str) -> tuple[np.ndarray, np.ndarray]:
    """True bearing off the heading, degrees, and whether the side was called right, of every beep with a bearing."""
    tables = [beep_table(run, detector, kind) for kind in ("approach", "standing")]
    signed, found = (
        np.concatenate([table.get(column, np.zeros(0)) for table in tables])
        for column in ("true_signed_bearing_rad", "bearing_rad")
    )
    kept = np.isfinite(signed) & np.isfinite(found) & (np.abs(signed) > 0.0)
    return np.rad2deg(np.abs(signed[kept])), (found[kept] < 0.5 * np.pi) == (signed[kept] > 0.0)


def _holding(run: RunData) -> str:
    cell = run.cells[0]["cell"]
    variant = cell.get("variant") or {}
    return holding_name({}, cell) if "walk.holding" in variant else variant_name(variant)


def _range_error(run: RunData, detector: str) -> float:
    return 100.0 * _median(run, detector, "range_m", "true_range_m")


def _bearing_error(run: RunData, detector: str) -> float:
    return float(np.rad2deg(_median(run, detector, "bearing_rad", "true_bearing_rad")))


def _median(run: RunData, detector: str, column: str, truth: str) -> float:
    errors = absolute_errors(beep_table(run, detector, "approach"), column, truth)
    errors = errors[np.isfinite(errors)]
    return float(np.median(errors)) if len(errors) else np.nan


def _estimates(run: RunData, detector: str) -> float:
    found = beep_table(run, detector, "approach")["range_m"]
    return 100.0 * float(np.isfinite(found).mean()) if len(found) else np.nan


def _tp(run: RunData, detector: str) -> float:
    return 100.0 * true_positive_rate(approach_table(run, detector)).value


def _tn(run: RunData, detector: str) -> float:
    return 100.0 * true_negative_rate(approach_table(run, detector)).value
