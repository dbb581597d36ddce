"""What fidelity costs and what it buys: error of the target's echo against processor time, level by level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.cells.probes.echo_errors import AUDIBLE_DB, DIP_DB, NEAR_SAMPLES
from benchmarks.cells.probes.fidelities import POINTS
from benchmarks.cells.probes.motions import DEGREES, degree_named
from benchmarks.cells.probes.tessellations import SEGMENTS, segments_named
from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure, TableFigure
from benchmarks.runs.results import RunData
from benchmarks.scoring.statistics import exact_rate
from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.words import counted

LEVELS = ("standard", "auto 2 dB", "auto 0.5 dB", "auto 0.1 dB")
KINDS = ("fidelity", "tessellation", "motion")
ORDER = [*POINTS, *(segments_named(n) for n in SEGMENTS), *(degree_named(n) for n in DEGREES), "reference"]
REFERENCES = {"fidelity": "reference", "tessellation": "192 segments", "motion": "degree 6"}
STANDARD_DB = 2.0  # what `standard` is to be right to
LATE_SAMPLES = 3.0  # of 192 kHz, what delays are to be right to


@dataclass(frozen=True)
class Price:
    """One level or setting over all approaches.

    Attributes:
        error_db: (E,) absolute errors of the target's level, one a pose and microphone.
        delay_samples, correlation: (E,) of the same echoes.
        resolved_db, resolved_samples: (R,) the same of every echo of the target that is resolved.
        cpu_s: (C,) processor time a pose of each approach.
    """

    error_db: Floats
    delay_samples: Floats
    correlation: Floats
    resolved_db: Floats
    resolved_samples: Floats
    cpu_s: Floats

    def within(self, tolerance_db: float) -> float:
        """Share of the echoes within a tolerance."""
        return float(np.mean(self.error_db <= tolerance_db)) if len(self.error_db) else float("nan")


@dataclass(frozen=True)
class Error:
    """A measure of a `Price` as it is drawn.

    Attributes:
        name: the attribute.
        words: of the axis.
        least, most: ends of the axis, where errors beyond them are drawn.
    """

    name: str
    words: str
    least: float
    most: float

    def of(self, price: Price) -> float:
        """95th percentile; NaN without errors."""
        errors = getattr(price, self.name)
        return float(np.clip(np.quantile(errors, 0.95), self.least, self.most)) if len(errors) else float("nan")


LEVEL, DELAY = "95 % level error (dB)", "95 % delay error (samples of 192 kHz)"
OF_ECHOES = Error("resolved_db", LEVEL, 1e-3, 100.0), Error("resolved_samples", DELAY, 1e-2, NEAR_SAMPLES)
OF_BODIES = Error("error_db", LEVEL, 1e-3, 100.0), Error("delay_samples", DELAY, 1e-2, 1e3)
"""Of every resolved echo of a target; of what a body, or a beep on the way, returns as a whole."""


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
    level, late, resolved, resolved_late = (
        np.abs(every(key)) for key in ("level_db", "delay_samples", "resolved_db", "resolved_samples")
    )
    return Price(level, late, every("correlation"), resolved, resolved_late, np.array(cpu))


def fidelity_pareto(run: RunData) -> PlotFigure:
    """Error against cost of levels by category, and error of settings, of segments round a body, of motion's degree."""
    every = {kind: prices(run, kind) for kind in KINDS}
    found = {kind: _measured(every[kind]) for kind in KINDS}
    levels = {name: price for name, price in found["fidelity"].items() if name in LEVELS}
    settings = {name: _time_beside(every["fidelity"], name) for name in found["fidelity"] if name not in LEVELS}
    by_category = {name: _measured(prices(_of_category(run, name))) for name in _categories(run)}
    others = found["tessellation"] | found["motion"]
    ticks = {name: _time_beside(every[kind], name) for kind in KINDS[1:] for name in found[kind]}
    one = "reference but for one setting"
    panels = [_curves(error, levels, by_category) for error in OF_ECHOES if levels]
    panels += [_rows_of(error, one, settings, by_category) for error in OF_ECHOES if settings]
    panels += [_rows_of(error, "bodies and motion", ticks, {"all": others}) for error in OF_BODIES if others]
    said = [f"{name}: {OF_ECHOES[0].of(price):.2g} dB" for name, price in levels.items()]
    return PlotFigure(
        "pareto",
        "Error of the target's echoes against processor time",
        tuple(panels),
        f"95 % of the echoes are within, {'; '.join(said)}." if said else "No data.",
        f"95th percentile against the level `reference`, of every echo of the target above {AUDIBLE_DB:g} dB re 1 m, a "
        f"quiet street's noise, with a dip of {DIP_DB:g} dB to any louder one, looked for within {NEAR_SAMPLES:g} "
        "samples; of the whole echo of bodies against those of 192 segments, and of motion against polynomials of "
        "degree 6. Time is the median over approaches, in a prepared scene; in brackets, a setting's over that of what "
        "it is held against. Errors beyond an axis are drawn at its end: those of echoes that are missing, too.",
        height_in=2.9,
    )


def _measured(every: dict[str, Price]) -> dict[str, Price]:
    return {name: price for name, price in every.items() if len(price.error_db) and len(price.cpu_s)}


def _curves(error: Error, levels: dict[str, Price], by_category: dict[str, dict[str, Price]]) -> Panel:
    """A category's error over its cost from level to level, levels named at their cost over all."""
    lines: list[Line] = []
    for category, measured in by_category.items():
        kept = [measured[name] for name in levels if name in measured]
        x, y = np.array([_cost_ms(price) for price in kept]), np.array([error.of(price) for price in kept])
        lines += [Line(category, category, x, y), Line(category, category, x, y, "points")]
    guides = tuple(Guide("x", _cost_ms(price), name) for name, price in levels.items())
    return Panel(
        "levels", "processor time a pose (ms)", error.words, tuple(lines), guides, log="xy",
        y_range=(0.8 * error.least, 1.2 * error.most), width_in=2.4,
    )  # fmt: skip


def _rows_of(error: Error, title: str, settings: dict[str, str], by_series: dict[str, dict[str, Price]]) -> Panel:
    """A row a setting, with its name on the axis; a point a series."""
    lines = []
    for key, (series, measured) in enumerate(by_series.items()):
        at = {k: measured[name] for k, name in enumerate(settings) if name in measured}
        x = np.array([error.of(price) for price in at.values()])
        aside = 0.12 * (key - 0.5 * (len(by_series) - 1))
        lines.append(Line(series, "muted" if series == "all" else series, x, np.array(list(at)) + aside, "points"))
    return Panel(
        title, error.words, "", tuple(lines), log="x", x_range=(0.8 * error.least, 1.2 * error.most),
        ticks=tuple(settings.values()), flat=True, width_in=2.4,
    )  # fmt: skip


def _time_beside(every: dict[str, Price], name: str) -> str:
    """A setting's name and its time over that of what it is held against."""
    return f"{name} ({_cost_ms(every[name]) / _cost_ms(every['reference']):.2g})"


def _cost_ms(price: Price) -> float:
    return 1e3 * float(np.median(price.cpu_s))


def fidelity_table(run: RunData) -> TableFigure:
    """By level and setting: cost, errors, share within half a decibel."""
    rows = tuple(
        (
            name if name != "reference" else REFERENCES[kind],
            f"{_cost_ms(price):.0f}",
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
        "level or setting", "CPU a pose (ms)", "median (dB)", "95 % (dB)", "within 0.5 dB (%)", "95 % delay (samples)",
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
    parts = {"all": run} | {name: _of_category(run, name) for name in _categories(run)}
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
            "level", "category", "CPU a pose (ms)", "median (dB)", "95 % (dB)", "pairs within the tolerance",
            "95 % delay (samples)", f"within {LATE_SAMPLES:g} samples (%)", "resolved echoes within the tolerance",
            f"and {LATE_SAMPLES:g} samples",
        ),
        rows,
        (1.0, 1.05, 1.0, 0.85, 0.8, 2.5, 1.2, 1.15, 2.5, 2.5),
        f"{counted(len(rows), 'row')}." if rows else "No data.",
        "A pair is a pose in a scene; it is kept if the target's compressed echo at both microphones is within the "
        f"tolerance of the level `reference`, {STANDARD_DB:g} dB at `standard`. Pairs whose echo is below -60 dB re "
        f"1 m do not count. Resolved is every echo of the target above {AUDIBLE_DB:g} dB, a quiet street's noise, with "
        f"a dip of {DIP_DB:g} dB to any louder one.",
    )  # fmt: skip


def _categories(run: RunData) -> list[str]:
    return list(dict.fromkeys(r["cell"]["category"] for r in run.cells if r["cell"]["kind"] == "fidelity"))


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
        return name, category, cost, *("-",) * 7
    spread = (f"{np.quantile(worst_db, q):.2g}" for q in (0.5, 0.95))
    tolerance_db = POINTS[name].get("tolerance_db", STANDARD_DB)
    rate = exact_rate(int((worst_db <= tolerance_db).sum()), len(worst_db))
    late, right = price.delay_samples, price.resolved_db <= tolerance_db
    in_time = f"{100 * np.mean(late <= LATE_SAMPLES):.0f}"
    resolved = (
        str(exact_rate(int(kept.sum()), len(kept)))
        for kept in (right, right & (price.resolved_samples <= LATE_SAMPLES))
    )
    return name, category, cost, *spread, str(rate), _two_digits(late, 0.95), in_time, *resolved
