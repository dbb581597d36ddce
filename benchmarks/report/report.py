"""The report of a run: one HTML file that needs no network, and a short Markdown summary."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from benchmarks.figures import DrawnFigure, figures_of
from benchmarks.figures.draw.interactive import interactive
from benchmarks.figures.draw.style import csv_text
from benchmarks.figures.measured import detectors_of, rules_text
from benchmarks.figures.plots import TableFigure
from benchmarks.report.cases import failures, strata_table, worst_cases
from benchmarks.report.provenance import cost_lines, environment_lines, reproduction_command
from benchmarks.report.verdict import headline, verdict_rows
from benchmarks.runs.markdown import as_code, plain
from benchmarks.runs.results import RunData
from benchmarks.runs.store import write_atomically
from benchmarks.runs.variants import first_point
from scenes.preview.page import KINDS
from scenes.preview.pictures import COLORS
from scenes.preview.plotly_page import in_script, library_script

WIDE_IN = 7.0
"""Figures wider than this, inches, stand alone in a row."""


@dataclass(frozen=True)
class ReportFigure:
    """A figure as the report shows it.

    Attributes:
        image: data URI; empty for a table, which is shown as one.
        note: small print; part of the image, if there is one.
        wide: whether it asks for the whole width of the page.
    """

    name: str
    title: str
    reading: str
    note: str
    image: str
    columns: Sequence[str]
    cells: Sequence[Sequence[str]]
    wide: bool


def write_report(
    run: RunData, walks: Sequence[Mapping[str, Any]] = (), figures: Sequence[DrawnFigure] | None = None
) -> Path:
    """Write report.html and report.md into the run's folder.

    Args:
        run: what was measured.
        walks: to play in the page; see `benchmarks.report.replays.stored_replays`.
        figures: those that the run shows, if they have been computed.

    Returns:
        The path of report.html.
    """
    figures = figures_of(run) if figures is None else figures
    context = report_context(run, walks, figures)
    (run.folder / "figures").mkdir(parents=True, exist_ok=True)
    for drawn in figures:
        if not drawn.figure.empty:
            write_atomically(run.folder / "figures" / f"{drawn.figure.name}.csv", csv_text(drawn.figure))
    templates = Environment(
        loader=PackageLoader("benchmarks"), autoescape=lambda name: str(name).endswith(".html.j2"),
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    templates.filters |= {"plain": plain, "as_code": as_code}
    write_atomically(run.folder / "report.md", templates.get_template("report.md.j2").render(context))
    path = run.folder / "report.html"
    write_atomically(path, templates.get_template("report.html.j2").render(context))
    return path


def report_context(run: RunData, walks: Sequence[Mapping[str, Any]], figures: Sequence[DrawnFigure]) -> dict[str, Any]:
    """Everything that the templates show, as text."""
    judged, remark = first_point(run)  # pooled points of a sweep would be no measurement of anything
    names, rows = detectors_of(run), verdict_rows(judged)
    planned = len(run.manifest.get("plan") or run.cells)
    return {
        "title": run.manifest.get("title") or run.manifest.get("suite") or "Run",
        "suite": run.manifest.get("suite") or "unknown",
        "tier": run.manifest.get("tier") or "unknown",
        "detectors": names,
        "headline": [*headline(rows, names), *([remark] if remark else [])],
        "rows": rows,
        "rules": rules_text(run),
        "counts": {"planned": planned, "ok": len(run.ok), "failed": len(run.cells) - len(run.ok),
                   "missing": planned - len(run.cells)},
        "figures": [_embedded(drawn) for drawn in figures if not drawn.figure.empty],
        "empty_figures": [drawn.figure.title for drawn in figures if drawn.figure.empty],
        "strata": strata_table(judged),
        "worst": worst_cases(judged),
        "failures": failures(run),
        "shown_walks": walks,
        "walk_numbers": _numbers(walks),
        "replays_json": in_script(walks),
        "charts_json": in_script(charts) if (charts := _charts(figures)) else "",
        "library": library_script() if charts else "",
        "kinds": KINDS,
        "colors": COLORS,
        "cost": cost_lines(run),
        "environment": environment_lines(run.manifest),
        "command": reproduction_command(run.manifest),
    }  # fmt: skip


def _numbers(walks: Sequence[Mapping[str, Any]]) -> dict[str, int]:
    """Where the player finds a walk, by its label."""
    playable = [walk["label"] for walk in walks if "error" not in walk]
    return {label: number for number, label in enumerate(playable)}


def _charts(figures: Sequence[DrawnFigure]) -> dict[str, Any]:
    """What Plotly draws, by the figure's name."""
    charts = {drawn.figure.name: interactive(drawn.figure) for drawn in figures}
    return {name: chart for name, chart in charts.items() if chart is not None}


def _embedded(drawn: DrawnFigure) -> ReportFigure:
    figure = drawn.figure
    named = figure.name, figure.title, figure.reading, figure.note
    if isinstance(figure, TableFigure):
        return ReportFigure(*named, "", figure.columns, figure.cells, True)
    encoded = base64.b64encode(drawn.svg).decode("ascii")
    wide = bool(drawn.canvas.get_size_inches()[0] > WIDE_IN)
    return ReportFigure(*named, f"data:image/svg+xml;base64,{encoded}", (), (), wide)
