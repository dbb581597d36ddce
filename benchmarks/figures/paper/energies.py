"""Processor time per beep and the charge of 30 minutes (Figure 27, Table 1)."""

from __future__ import annotations

import numpy as np

from benchmarks.cells.spec import counts_as
from benchmarks.figures.bench.alerts import plain_detectors
from benchmarks.figures.measured import significant
from benchmarks.figures.plots import Line, Panel, PlotFigure, TableFigure
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import first_point
from benchmarks.scoring import paper_values
from benchmarks.scoring.energy import EnergyModel, charge_range_mah
from benchmarks.scoring.statistics import quantile
from obstaclewatch.support.arrays import Floats

PERIOD_S = 0.090
MODEL_NOTE = (
    "A model, not a measurement, and nothing in it was fitted to the paper: 0.4 W (0.3-0.5) of a phone playing and "
    "recording with its screen off, 0.75 W more for a busy core, a phone five (three to ten) times slower than the "
    "machine that measured, 3.85 V. Whiskers and brackets: the ends of these ranges."
)


def cpu_per_beep_s(run: RunData, detector: str) -> np.ndarray:
    """(n,) processor time of a walk's detection over its beeps, s; empty where a run kept no costs.

    The one definition, whose median every figure, table, claim and report shows: walks of a sweep's first point, or
    standing measurements where there are no walks.
    """
    first, _ = first_point(run)
    known = [
        (record["cell"], cost["detect_cpu_s"][detector] / cost["beeps"])
        for record, cost in zip(first.cells, first.costs, strict=False)
        if detector in (cost.get("detect_cpu_s") or {}) and cost.get("beeps")
    ]
    walks = [spent for cell, spent in known if counts_as(cell, "approach")]
    return np.array(walks or [spent for _, spent in known])


def energy_figure(run: RunData) -> PlotFigure:
    """Figure 27: CPU time per beep of every detector, and the modelled charge beside the paper's measured one."""
    spent = _spent_s(run)
    said = [
        f"{name}: {_median_ms(cpu)} a beep, {_charge_mah(cpu)[0]:.0f} mAh in 30 minutes by the model"
        for name, cpu in spent.items()
    ]
    return PlotFigure(
        "fig27",
        "Fig. 27 · CPU time per beep, and the modelled charge of 30 minutes",
        (_measured_panel(spent), _modelled_panel(spent)),
        "; ".join(said) + "; the paper measured 50 to 66 mAh." if said else "No data.",
        f"Left: median and 10-90 % of walks. {MODEL_NOTE}",
    )


def _measured_panel(spent: dict[str, Floats]) -> Panel:
    lines = []
    for k, (name, cpu) in enumerate(spent.items()):
        middle, low, high = (np.array([1e3 * quantile(cpu, q)]) for q in (0.5, 0.1, 0.9))
        lines.append(Line(name, name, np.array([float(k)]), middle, "points", low, high))
    return Panel(
        "Measured here", "", "CPU time per beep (ms)", tuple(lines),
        ticks=tuple(name.removesuffix("Detector") for name in spent),
        y_range=(0.0, 1.2 * max((float(line.high[0]) for line in lines), default=1.0)),
    )  # fmt: skip


def _modelled_panel(spent: dict[str, Floats]) -> Panel:
    phones = paper_values.ENERGY
    place, lines = np.arange(len(phones), dtype=float), []
    for k, (name, cpu) in enumerate(spent.items()):
        charge, low, high = (np.full(len(phones), value) for value in _charge_mah(cpu))
        lines.append(Line(name, name, place + 0.12 * (k - 1), charge, "points", low, high))
    if lines:
        used = np.array([row.used_mah for row in phones])
        lines.append(Line("the paper, measured", "paper", place, used, "ring"))
    ticks = tuple(row.phone.removeprefix("galaxy-") for row in phones)
    return Panel("Modelled", "", "charge of 30 minutes (mAh)", tuple(lines), ticks=ticks, y_range=(0.0, 90.0))


def energy_table(run: RunData) -> TableFigure:
    """Table 1, with our modelled charge beside the paper's measured one."""
    rows = []
    for row in paper_values.ENERGY:
        for name, cpu in _spent_s(run).items():
            charge, low, high = _charge_mah(cpu)
            rows.append(
                (
                    row.phone,
                    f"{row.battery_mah:.0f} mAh",
                    f"{row.used_mah:.0f} mAh, {100 * row.share:.1f} %",
                    name,
                    _median_ms(cpu),
                    f"{charge:.0f} mAh ({low:.0f}-{high:.0f})",
                    f"{100 * charge / row.battery_mah:.1f} %",
                )
            )
    columns = ("phone", "battery", "paper, measured", "detector", "CPU per beep", "model, 30 min", "of battery")
    return TableFigure(
        "table1",
        "Table 1 · Energy consumption of 30 minutes",
        columns,
        tuple(rows),
        (1.2, 0.9, 1.25, 1.75, 1.05, 1.35, 0.8),
        "The model knows phones by their batteries alone.",
        MODEL_NOTE,
    )


def _spent_s(run: RunData) -> dict[str, Floats]:
    """By detector, (n,) processor time of a beep, s; of those whose costs the run kept."""
    spent = {name: cpu_per_beep_s(run, name) for name in plain_detectors(run)}
    return {name: cpu for name, cpu in spent.items() if len(cpu)}


def _median_ms(cpu_s: Floats) -> str:
    return f"{significant(1e3 * float(np.median(cpu_s)))} ms"


def _charge_mah(cpu_s: Floats) -> tuple[float, float, float]:
    """The modelled charge of 30 minutes at the median of some times, and the ends of its interval."""
    middle = float(np.median(cpu_s))
    return EnergyModel().charge_mah(middle, PERIOD_S), *charge_range_mah(middle, PERIOD_S)
