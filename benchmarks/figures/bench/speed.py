"""What things cost: growth of path search, and every number of the suite `speed` in a table."""

from __future__ import annotations

import numpy as np

from benchmarks.figures.plots import Line, Panel, PlotFigure, TableFigure
from benchmarks.runs.results import RunData

AXES = ("triangles", "obstacles", "order", "places")


def speed_numbers(run: RunData) -> dict[str, float]:
    """Every number that the run's probes of speed measured, as "probe/what is set: name"."""
    found = {}
    for record in run.ok:
        cell = record["cell"]
        if cell["kind"] == "speed":
            point = " ".join(str(value) for key, value in cell["probe"].items() if key != "values")
            for name, value in record["result"]["speed"]["numbers"].items():
                found[f"{cell['category']} {point}: {name}"] = value
    return found


def missing_peers(run: RunData) -> list[str]:
    """Peers that were not installed."""
    return sorted({peer for record in run.ok for peer in record["result"].get("speed", {}).get("missing", [])})


def speed_growth(run: RunData) -> PlotFigure:
    """Processor time a pair of source and microphone over the size of the question."""
    numbers = speed_numbers(run)
    panels = []
    for axis in AXES:
        begin = f"scaling {axis}: {axis}_"
        sizes = {int(name[len(begin) : -3]): value for name, value in numbers.items() if name.startswith(begin)}
        if sizes:
            line = Line("", "0", np.array(list(sizes)), np.array(list(sizes.values())), "ring")
            panels.append(Panel(axis, axis, "processor time a pair (ms)", (line,), log="xy", width_in=3.2))
    return PlotFigure(
        "speed_growth",
        "Path search: processor time a pair of source and microphone",
        tuple(panels),
        f"{len(panels)} axes." if panels else "No data.",
        "Each point in a prepared scene; answers are checked before they are timed.",
    )


def speed_table(run: RunData) -> TableFigure:
    """Every number."""
    numbers, missing = speed_numbers(run), missing_peers(run)
    ratios = [f"{name.split(': ')[1]} {value:.2g}" for name, value in numbers.items() if name.endswith("_ratio")]
    return TableFigure(
        "speed",
        "Processor time of stages, peers and floors",
        ("what", "value"),
        tuple((name, f"{value:.3g}") for name, value in numbers.items()),
        (4.0, 1.0),
        "; ".join(ratios) + "." if ratios else "No data.",
        "ms: milliseconds of processor time on one thread, a pair, a beep or a block. ratio: to our walk call for "
        "peers, to one Fourier transform of a beep's block for rendering."
        + (f" Not installed, so not compared: {', '.join(missing)}." if missing else ""),
    )
