"""Estimated against true radius (Figure 11), and crest widths (Figures 10 and 12)."""

from __future__ import annotations

import numpy as np

from benchmarks.figures.measured import judged_detectors
from benchmarks.figures.paper.signals import signals_of
from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure, Style
from benchmarks.runs.results import RunData
from benchmarks.scoring import paper_values
from benchmarks.scoring.scores import beep_table
from obstaclewatch.support.arrays import Floats

WIDEST_M = 1.2
LEAST_ESTIMATES = 3
STATES: tuple[tuple[str, str, str, Style], ...] = (
    ("approach", "walking", "1", "faint"),
    ("standing", "standing", "0", "ring"),
)
"""Kinds of cells, in words, their colours and marks: the many first, so that they hide no other."""


def radius_correlation(run: RunData) -> PlotFigure:
    """Figure 11: median estimate of every walk and standing measurement against the truth."""
    panels, said, axes = [], [], ("true radius (cm)", "estimated radius (cm)")
    for detector in judged_detectors(run):
        lines = []
        pooled: list[Floats] = []
        for kind, state, key, style in STATES:
            true, found = radius_medians(run, detector, kind)
            lines.append(Line(state, key, 100 * true, 100 * found, style))
            pooled.append(np.stack([true, found]))
        both = np.concatenate(pooled, axis=1)
        if not both.shape[1]:
            continue
        ends = np.array([0.0, 100.0 * WIDEST_M])
        lines.append(Line("estimate = truth", "muted", ends, ends, "dashed"))
        panels.append(Panel(detector, *axes, tuple(lines), x_range=(0.0, 85.0), y_range=(-3.0, 85.0)))
        said.append(f"{detector}: correlation {_correlation(both)} over {both.shape[1]} objects")
    return PlotFigure(
        "fig11",
        "Fig. 11 · Estimated against true radius",
        tuple(panels) or (Panel("", *axes, ()),),
        f"{'; '.join(said) or 'No radius'}; the paper prints {paper_values.RADIUS_CORRELATION}.",
        f"One point an object: the median over its beeps, where at least {LEAST_ESTIMATES} gave an estimate. Up to "
        f"{2 * WIDEST_M:g} m wide; estimates above the axis are left out of the picture, not of the correlation. "
        f"The paper: correlation {paper_values.RADIUS_CORRELATION}. Detectors that state no radius are left out.",
    )


def crest_shapes(run: RunData) -> PlotFigure:
    """Figure 10: crests of objects of different width at one distance."""
    found = signals_of(run, "crests")
    lines, guides, said, where = [], [], [], ""
    for signal in found[:1]:
        for k, name in enumerate(signal["things"]):
            width, radius = signal["crest_samples"][k], signal["true_radius_m"][k]
            words = "no crest" if width is None else f"{width:.0f} samples"
            lines.append(
                Line(
                    f"{name}, radius {100 * radius:.0f} cm: {words}",
                    name,
                    np.array(signal["range_m"][k]),
                    np.array(signal["level_db"][k], dtype=float),
                )
            )
            said.append(f"{name} {words}")
        guides = [Guide("x", at, "", name) for at, name in zip(signal["true_m"], signal["things"], strict=True)]
        where = " at 2 m"
    panel = Panel("", "range (m)", "level re direct sound (dB)", tuple(lines), tuple(guides), width_in=5.6)
    return PlotFigure(
        "fig10",
        f"Fig. 10 · Crests of objects of different size{where}",
        (panel,),
        f"Crest widths above the average: {', '.join(said)}." if said else "No data.",
        "Width: samples at 192 kHz above the average envelope of the target range (section 3.6). Lines up: true ranges "
        "of the nearest points to microphone 1, which is 7 cm ahead of the phone's middle.",
    )


def crest_against_distance(run: RunData) -> PlotFigure:
    """Figure 12: crest width while the walker comes nearer."""
    lines, said = [], []
    for signal in signals_of(run, "approach"):
        true = np.array(signal["true_m"], dtype=float)
        width = np.array(signal["crest_samples"], dtype=float)
        near, far = (
            np.nanmedian(width[part]) if np.isfinite(width[part]).any() else np.nan for part in (true < 2.0, true > 3.5)
        )
        lines.append(Line(signal["category"], signal["category"], true, width, "points"))
        said.append(f"{signal['category']} {far:.0f} beyond 3.5 m and {near:.0f} within 2 m")
    if lines:
        lines.append(_trend(lines))
    panel = Panel("", "true distance (m)", "crest width (samples at 192 kHz)", tuple(lines), width_in=5.6)
    return PlotFigure(
        "fig12",
        "Fig. 12 · Crest width against distance",
        (panel,),
        f"Median crest widths in samples: {'; '.join(said)}. The paper: wider when nearer." if said else "No data.",
        "Samples above the average envelope of the target range (section 3.6), highest peak within 25 cm "
        "of the truth; a gap where it stays below.",
    )


def _trend(lines: list[Line]) -> Line:
    """Medians over half metres of what the lines hold."""
    x, y = (np.concatenate([getattr(line, axis) for line in lines]) for axis in "xy")
    x, y = x[np.isfinite(y)], y[np.isfinite(y)]
    places = np.unique(np.floor(2.0 * x)) / 2.0 + 0.25
    middle = np.array([np.median(y[np.abs(x - place) <= 0.25]) for place in places])
    return Line("median of all, by half metre", "ink", places, middle)


def radius_medians(run: RunData, detector: str, kind: str) -> tuple[Floats, Floats]:
    """True and estimated radius of every object up to `WIDEST_M`, the median over its beeps."""
    table = beep_table(run, detector, kind)
    true, found = [], []
    for label in np.unique(table["label"]):
        rows = (table["label"] == label) & np.isfinite(table["radius_m"])
        truth = table["true_radius_m"][table["label"] == label]
        if rows.sum() >= LEAST_ESTIMATES and np.nanmedian(truth) <= WIDEST_M:
            true.append(np.nanmedian(truth))
            found.append(np.median(table["radius_m"][rows]))
    return np.array(true), np.array(found)


def _correlation(pairs: np.ndarray) -> str:
    if pairs.shape[1] < 3 or np.ptp(pairs[0]) == 0.0 or np.ptp(pairs[1]) == 0.0:
        return "unknown"
    return f"{np.corrcoef(pairs)[0, 1]:.2f}"
