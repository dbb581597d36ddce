"""Numerical stability at the extremes."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure
from benchmarks.runs.results import RunData
from obstaclewatch.support.arrays import Floats

SMALLEST = 1e-17
"""Errors of exactly 0 are drawn here."""
CHECKS = {
    "wall-distance": ("a wall at", "distance, m", "x"),
    "wall-offset": ("scene moved by", "offset, m", "x"),
    "grazing": ("grazing at", "angle, rad", "x"),
    "slivers": ("slivers", "aspect ratio", "x"),
    "coincident": ("mic at speaker", "gap, m", "x"),
    "temperature": ("air at", "temperature, °C", ""),
    "sample-rate": ("rendered at", "sample rate, kHz", ""),
}


def simulator_extremes(run: RunData) -> PlotFigure:
    """Relative errors of the simulator against exact images, over each parameter."""
    panels: list[Panel] = []
    worst: list[str] = []
    for check, (title, label, log) in CHECKS.items():
        x, columns = _errors_of(run, check)
        if len(x) == 0:
            continue
        scale = 1e-3 if check == "sample-rate" else 1.0
        lines = tuple(
            Line(name, _KEYS[name], scale * x, np.maximum(np.abs(y), SMALLEST), "points")
            for name, y in columns.items()
            if name in _KEYS
        )
        panels.append(
            Panel(
                title,
                label,
                "relative error" if not panels else "",
                lines,
                (Guide("y", 2.2e-16, ""),),
                log="xy" if log else "y",
                y_range=(3e-18, 1e-3),
                width_in=1.45,
            )
        )
        worst.append(f"{check} {max(float(np.nanmax(np.abs(line.y))) for line in lines):.0e}")
        if "echoes" in columns and np.nansum(columns["echoes"]) > 0:
            worst[-1] += f" ({np.nansum(columns['echoes']):.0f} echoes missing or too many)"
    return PlotFigure(
        "extremes",
        "Relative errors of the simulator at extremes",
        tuple(panels),
        f"Largest errors: {', '.join(worst)}." if worst else "No data.",
        "Against the image of a rigid wall; for sample rates, the beep's formula. Dashed: the rounding of one number, "
        "2.2e-16; errors of exactly 0 are drawn at 1e-17.",
    )


def detector_extremes(run: RunData) -> PlotFigure:
    """The detector from no echo to no noise: missed beeps, and the range error against its bound."""
    snr, columns = _errors_of(run, "detector-snr")
    panels: tuple[Panel, ...] = ()
    reading = "No data."
    if len(snr):
        rms, bound, missed = (columns[name] for name in ("range_rms_m", "bound_m", "missed"))
        error = Line("PaperDetector", "PaperDetector", snr, 100 * rms, "points")
        least = Line("Cramer-Rao bound", "muted", snr, 100 * bound, "dashed")
        panels = (
            Panel("", "2E/N0, dB", "range error (rms), cm", (error, least), log="y", y_range=(1e-5, 10.0)),
            Panel(
                "",
                "2E/N0, dB",
                "beeps without an estimate, %",
                (Line("PaperDetector", "PaperDetector", snr, 100 * missed, "points"),),
                y_range=(-3.0, 103.0),
            ),
        )
        ratio = (rms / bound)[(snr >= 20.0) & (snr <= 80.0) & np.isfinite(rms)]
        reading = (
            f"From 20 to 80 dB the error is {ratio.max():.2f} times the bound at most."
            if len(ratio)
            else "No beep between 20 and 80 dB has an estimate."
        )
    return PlotFigure(
        "extremes_snr",
        "Range error and missed beeps against SNR",
        panels,
        reading,
        "A standing point at 2 m, 60 beeps each. Near 120 dB float32 samples bound the error.",
    )


_KEYS = {"delay": "0", "pressure": "1", "field": "2", "samples": "3", "direct_level": "4"}


def _errors_of(run: RunData, check: str) -> tuple[Floats, dict[str, Floats]]:
    """Values of a check's parameter, and its errors by name."""
    cells = [r for r in run.ok if r["cell"]["kind"] == "numerics" and r["cell"]["category"] == check]
    values = np.array([_only(record["cell"]["probe"]) for record in cells], dtype=float)
    names = list(cells[0]["result"]["numerics"]) if cells else []
    return values, {n: np.array([r["result"]["numerics"][n] for r in cells], dtype=float) for n in names}


def _only(probe: dict[str, Any]) -> float:
    return float(next(value for name, value in probe.items() if name != "seed"))
