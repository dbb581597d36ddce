"""What fidelity costs and what it buys: error of the target's echo against processor time, level by level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.cells.probes.fidelities import POINTS
from benchmarks.cells.probes.motions import DEGREES, degree_named
from benchmarks.cells.probes.tessellations import SEGMENTS, segments_named
from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure, TableFigure
from benchmarks.runs.results import RunData
from benchmarks.scoring.statistics import exact_rate
from obstaclewatch.support.arrays import Floats

LEVELS = ("standard", "auto 2 dB", "auto 0.5 dB", "auto 0.1 dB")
KINDS = ("fidelity", "tessellation", "motion")
ORDER = [*POINTS, *(segments_named(n) for n in SEGMENTS), *(degree_named(n) for n in DEGREES), "reference"]
REFERENCES = {"fidelity": "reference", "tessellation": "192 segments", "motion": "degree 6"}
STANDARD_DB = 2.0  # what `standard` is to be right to
LEAST_DB, MOST_DB = 1e-5, 100.0
"""Errors beyond these are drawn there."""


@dataclass(frozen=True)
class Price:
    """One level or setting over all approaches.

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


def prices(run: RunData, kind: str = "fidelity") -> dict[str, Price]:
    """Every level and setting that the run's cells of a kind measured, and "reference" for its cost."""
    pairs = zip(run.cells, run.costs, strict=True)
    kept = [(r["result"]["fidelity"], c) for r, c in pairs if r["status"] == "ok" and r["cell"]["kind"] == kind]
    names = sorted(kept[0][0], key=ORDER.index) if kept else []
    return {name: _price(name, [found for found, _ in kept], [cost for _, cost in kept]) for name in names}


def _price(name: str, found: list[dict], costs: list[dict]) -> Price:
    def every(key: str) -> Floats:
        return np.array([x for each in found for x in (each[name].get(key, []) if name != "reference" else [])])

    cpu = [c["trace_cpu_s"][name] * 2 / len(f["reference"]["level_db"]) for f, c in zip(found, costs, strict=True) if c]
    return Price(np.abs(every("level_db")), np.abs(every("delay_samples")), every("correlation"), np.array(cpu))


def fidelity_pareto(run: RunData) -> PlotFigure:
    """Error against cost of levels and settings, of segments round a body, and of following motion."""
    found = {kind: _measured(run, kind) for kind in KINDS}
    levels = {name: price for name, price in found["fidelity"].items() if name in LEVELS}
    settings = {name: price for name, price in found["fidelity"].items() if name not in LEVELS}
    titled = {"levels": levels, "reference but for one setting": settings}
    titled |= {"segments round a body": found["tessellation"], "motion in a beep": found["motion"]}
    said = [f"{name}: {np.quantile(price.error_db, 0.95):.2g} dB" for name, price in levels.items()]
    return PlotFigure(
        "pareto",
        "Error of the target's echo against processor time",
        tuple(_priced(title, points) for title, points in titled.items() if points),
        f"95 % of the echoes are within, {'; '.join(said)}." if said else "No data.",
        "Circles: 90th percentile over poses and microphones against the median cost; whiskers from the median to the "
        "95th percentile. Errors below 1e-5 dB are drawn there, those above 100 dB, echoes that are missing, at 100.",
    )


def _measured(run: RunData, kind: str) -> dict[str, Price]:
    return {name: price for name, price in prices(run, kind).items() if len(price.error_db) and len(price.cpu_s)}


def _priced(title: str, points: dict[str, Price]) -> Panel:
    lines = tuple(_spot(name, k, price) for k, (name, price) in enumerate(points.items()))
    cost = np.array([line.x[0] for line in lines])
    room = (float(cost.min()) / 1.3, float(cost.max()) * (cost.max() / cost.min()) ** 0.35 * 1.6)
    highest = max(1.0, *(float(line.high[0]) for line in lines))
    return Panel(
        title, "processor time a pose, ms", "error of the target's echo, dB", lines, (Guide("y", 0.5, "0.5 dB"),),
        log="xy", x_range=room, y_range=(0.2 * LEAST_DB, 20.0 * highest), width_in=3.4,
    )  # fmt: skip


def _spot(name: str, key: int, price: Price) -> Line:
    ends = (np.array([np.clip(np.quantile(price.error_db, q), LEAST_DB, MOST_DB)]) for q in (0.5, 0.9, 0.95))
    low, middle, high = ends
    return Line(name, str(key), np.array([1e3 * np.median(price.cpu_s)]), middle, "named", low, high)


def fidelity_table(run: RunData) -> TableFigure:
    """By level and setting: cost, errors, share within half a decibel."""
    rows = tuple(
        (
            name if name != "reference" else REFERENCES[kind],
            f"{1e3 * np.median(price.cpu_s):.0f}",
            *(_two_digits(price.error_db, q) for q in (0.5, 0.95)),
            f"{100 * price.within(0.5):.0f}" if len(price.error_db) else "-",
            _two_digits(price.delay_samples, 0.95),
            f"{np.quantile(price.correlation, 0.05):.3f}" if len(price.correlation) else "-",
        )
        for kind in KINDS
        for name, price in prices(run, kind).items()
        if len(price.cpu_s)
    )
    heads = (
        "level or setting", "CPU a pose, ms", "median, dB", "95 %, dB", "within 0.5 dB, %", "95 % delay, samples",
        "5 % correlation",
    )  # fmt: skip
    return TableFigure(
        "fidelity",
        "Fidelity levels and settings: processor time and echo errors",
        heads,
        rows,
        (1.9, 1.3, 1.0, 0.9, 1.4, 1.6, 1.3),
        f"{len(rows)} levels and settings." if rows else "No data.",
        "Errors of the target's compressed echo against the level `reference`; of bodies, against those of 192 "
        "segments; of motion (one beep, level `standard`), against polynomials of degree 6.",
    )


def _two_digits(values: Floats, share: float) -> str:
    if not len(values):
        return "-"
    quantile = float(np.quantile(values, share))
    return f"{quantile:.0f}" if quantile >= 100.0 else f"{quantile:.2g}"


def tolerance_table(run: RunData) -> TableFigure:
    """Level by level, all pairs of scene and pose and then by category: errors, and how many pairs were kept."""
    categories = list(dict.fromkeys(r["cell"]["category"] for r in run.cells if r["cell"]["kind"] == "fidelity"))
    parts = {"all": run} | {name: _of_category(run, name) for name in categories}
    rows = tuple(
        _kept(name, category, price, _worst(parts[category], name))
        for name in prices(run)
        for category in parts
        for price in [prices(parts[category])[name]]
        if len(price.cpu_s)
    )
    return TableFigure(
        "tolerance",
        "Errors of levels against their tolerance",
        (
            "level", "category", "CPU a pose, ms", "median, dB", "95 %, dB", "pairs within the tolerance",
            "95 % delay, samples", "within 3 samples, %",
        ),
        rows,
        (1.0, 1.05, 1.0, 0.85, 0.8, 2.5, 1.2, 1.15),
        f"{len(rows)} rows." if rows else "No data.",
        "A pair is a pose in a scene; it is kept if the target's compressed echo at both microphones is within the "
        f"tolerance of the level `reference`, {STANDARD_DB:g} dB at `standard`. Pairs whose echo is below -60 dB re "
        "1 m do not count.",
    )  # fmt: skip


def _of_category(run: RunData, category: str) -> RunData:
    return run.part([k for k, r in enumerate(run.cells) if r["cell"]["category"] == category])


def _worst(run: RunData, name: str) -> Floats:
    """(R,) greatest error of a cell's audible echoes; a cell of the suite `tolerance` is one pose."""
    kept = [r["result"]["fidelity"] for r in run.cells if r["status"] == "ok" and r["cell"]["kind"] == "fidelity"]
    errors = [each[name].get("level_db", []) for each in kept]
    return np.array([np.abs(each).max() for each in errors if name != "reference" and len(each)])


def _kept(name: str, category: str, price: Price, worst_db: Floats) -> tuple[str, ...]:
    cost = f"{1e3 * np.mean(price.cpu_s):.0f}"
    if not len(worst_db):
        return name, category, cost, *("-",) * 5
    spread = (f"{np.quantile(worst_db, q):.2g}" for q in (0.5, 0.95))
    tolerance_db = POINTS[name].get("tolerance_db", STANDARD_DB)
    rate = exact_rate(int((worst_db <= tolerance_db).sum()), len(worst_db))
    late = price.delay_samples
    return name, category, cost, *spread, str(rate), _two_digits(late, 0.95), f"{100 * np.mean(late <= 3.0):.0f}"
