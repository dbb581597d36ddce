"""What fidelity costs and what it buys: error of the target's echo against processor time, level by level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.cells.fidelities import POINTS
from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure, TableFigure
from benchmarks.results import RunData
from benchmarks.statistics import wilson

Floats = NDArray[np.float64]

LEVELS = ("draft", "standard", "auto 2 dB", "auto 0.5 dB", "auto 0.1 dB")
LEAST_DB = 1e-3
"""Errors below this are drawn there."""


@dataclass(frozen=True)
class Price:
    """One level or knob over all approaches.

    Attributes:
        error_db: (E,) absolute errors of the target's level, one a pose and microphone.
        delay_samples, correlation: (E,) of the same echoes.
        cpu_s: (C,) processor time a pose of each approach.
    """

    error_db: Floats
    delay_samples: Floats
    correlation: Floats
    cpu_s: Floats

    def within(self, tolerance_db: float) -> float:
        """Share of the echoes within a tolerance."""
        return float(np.mean(self.error_db <= tolerance_db)) if len(self.error_db) else float("nan")


def prices(run: RunData) -> dict[str, Price]:
    """Every level and knob that the run measured, and "reference" for its cost."""
    pairs = zip(run.cells, run.costs, strict=True)
    kept = [(r["result"]["fidelity"], c) for r, c in pairs if r["status"] == "ok" and r["cell"]["kind"] == "fidelity"]
    names = list(kept[0][0]) if kept else []
    return {name: _price(name, [found for found, _ in kept], [cost for _, cost in kept]) for name in names}


def _price(name: str, found: list[dict], costs: list[dict]) -> Price:
    def every(key: str) -> Floats:
        return np.array([x for each in found for x in (each[name].get(key, []) if name != "reference" else [])])

    cpu = [c["trace_cpu_s"][name] * 2 / len(f["reference"]["level_db"]) for f, c in zip(found, costs, strict=True) if c]
    return Price(np.abs(every("level_db")), np.abs(every("delay_samples")), every("correlation"), np.array(cpu))


def fidelity_pareto(run: RunData) -> PlotFigure:
    """Error against cost of levels and knobs."""
    found = {name: price for name, price in prices(run).items() if len(price.error_db) and len(price.cpu_s)}
    panels, said = [], []
    for title, names in (("levels", LEVELS), ("the reference but for", [n for n in found if n not in LEVELS])):
        lines = [_spot(name, k, found[name]) for k, name in enumerate(n for n in names if n in found)]
        panels.append(
            Panel(
                title, "processor time a pose, ms", "error of the target's echo, dB", tuple(lines),
                (Guide("y", 0.5, "0.5 dB"),), log="xy", width_in=3.6,
            )
        )  # fmt: skip
        said += [f"{n}: {np.quantile(found[n].error_db, 0.95):.2g} dB" for n in names if n in found and n in LEVELS]
    return PlotFigure(
        "pareto",
        "What fidelity costs",
        tuple(panels),
        f"95 % of the echoes are within, {'; '.join(said)}." if said else "No data.",
        "Circles: 90th percentile over poses and microphones of all categories against the median cost; whiskers from "
        "the median to the 95th percentile. Errors below 0.001 dB are drawn there.",
    )


def _spot(name: str, key: int, price: Price) -> Line:
    low, middle, high = (np.array([max(np.quantile(price.error_db, q), LEAST_DB)]) for q in (0.5, 0.9, 0.95))
    return Line(name, str(key), np.array([1e3 * np.median(price.cpu_s)]), middle, "points", low, high)


def fidelity_table(run: RunData) -> TableFigure:
    """Level by level: cost, errors, share within half a decibel."""
    found = prices(run)
    rows = tuple(
        (
            name,
            f"{1e3 * np.median(price.cpu_s):.0f}",
            *(f"{np.quantile(price.error_db, q):.2g}" if len(price.error_db) else "-" for q in (0.5, 0.95)),
            f"{100 * price.within(0.5):.0f}" if len(price.error_db) else "-",
            f"{np.quantile(price.delay_samples, 0.95):.2g}" if len(price.delay_samples) else "-",
            f"{np.quantile(price.correlation, 0.05):.3f}" if len(price.correlation) else "-",
        )
        for name, price in found.items()
        if len(price.cpu_s)
    )
    heads = (
        "level or knob", "CPU a pose, ms", "median, dB", "95 %, dB", "within 0.5 dB, %", "95 % delay, samples",
        "5 % correlation",
    )  # fmt: skip
    return TableFigure(
        "fidelity",
        "Speed against accuracy",
        heads,
        rows,
        (2.0, 1.0, 1.0, 1.0, 1.2, 1.4, 1.2),
        f"{len(rows)} levels and knobs." if rows else "No data.",
        "Errors of the target's compressed echo against the level `reference`.",
    )


def tolerance_table(run: RunData) -> TableFigure:
    """Tolerance by tolerance: how many pairs of scene and pose `auto` kept within it, and at what cost."""
    found = prices(run)
    rows = tuple(_kept(name, price, _worst(run, name)) for name, price in found.items() if len(price.cpu_s))
    return TableFigure(
        "tolerance",
        "Whether auto keeps its tolerance",
        ("level", "CPU a pose, ms", "median, dB", "95 %, dB", "pairs within the tolerance"),
        rows,
        (1.6, 1.2, 1.0, 1.0, 4.2),
        f"{len(rows)} levels." if rows else "No data.",
        "A pair is a pose in a scene; it is kept if the target's compressed echo at both microphones is within the "
        "tolerance of the level `reference`. Pairs whose echo is below -60 dB re 1 m do not count.",
    )


def _worst(run: RunData, name: str) -> Floats:
    """(R,) greatest error of a cell's audible echoes; a cell of the suite `tolerance` is one pose."""
    kept = [r["result"]["fidelity"] for r in run.cells if r["status"] == "ok" and r["cell"]["kind"] == "fidelity"]
    errors = [each[name].get("level_db", []) for each in kept]
    return np.array([np.abs(each).max() for each in errors if name != "reference" and len(each)])


def _kept(name: str, price: Price, worst_db: Floats) -> tuple[str, ...]:
    cost = f"{1e3 * np.mean(price.cpu_s):.0f}"
    if not len(worst_db):
        return name, cost, "-", "-", "-"
    spread = (f"{np.quantile(worst_db, q):.2g}" for q in (0.5, 0.95))
    tolerance_db = POINTS[name].get("tolerance_db", 0.5)
    return name, cost, *spread, str(wilson(int((worst_db <= tolerance_db).sum()), len(worst_db)))
