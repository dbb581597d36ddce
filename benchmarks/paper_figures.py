"""Every picture of the paper, Figures 1 to 27 and Table 1, from the suites that reproduce them, on one page."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from benchmarks.bench import run
from benchmarks.figures import FIGURES, DrawnFigure, write_figures
from benchmarks.figures.paper.paper_claims import ClaimRow, claim_rows
from benchmarks.runs.results import RunData, load_run
from benchmarks.runs.store import write_atomically

SUITE_OF = {
    **{f"fig{number}": "signals" for number in (*range(1, 11), 12, 13, 14, 15)},
    **dict.fromkeys(["fig11", "fig25"], "size"),
    **dict.fromkeys(["fig16", "fig17", "fig19", "fig20", "fig26"], "paper"),
    "fig18": "bands",
    **dict.fromkeys(["fig21", "fig22", "fig23"], "ranging"),
    "fig24": "bearing",
    **dict.fromkeys(["fig27", "table1"], "energy"),
}
"""Picture of the paper -> the suite that reproduces it."""
PAPER_FIGURES = sorted(SUITE_OF, key=lambda name: (name[:3] != "fig", int(re.sub(r"\D", "", name))))
"""In the paper's order, the table last."""


def paper_runs(tier: str, jobs: int, out: Path) -> dict[str, RunData]:
    """The suites' runs by name; cells that are stored are not computed again."""
    return {
        suite: load_run(run(suite, tier, jobs=jobs, out=out).attrs["folder"])
        for suite in dict.fromkeys(SUITE_OF.values())
    }


def write_paper_figures(runs: Mapping[str, RunData], folder: Path) -> Path:
    """Write figures/<name>.{png,svg,csv} and index.html, where the paper's values stand beside the pictures.

    Returns:
        The path of index.html.
    """
    figures = {name: DrawnFigure(FIGURES[name](runs[SUITE_OF[name]])) for name in PAPER_FIGURES}
    write_figures(folder, list(figures.values()))
    rows = {suite: claim_rows([data]) for suite, data in runs.items()}
    shown = [(drawn.figure, SUITE_OF[name], claims_of(name, rows[SUITE_OF[name]])) for name, drawn in figures.items()]
    templates = Environment(loader=PackageLoader("benchmarks"), autoescape=True, undefined=StrictUndefined,
                            trim_blocks=True, lstrip_blocks=True)  # fmt: skip
    tiers = sorted({str(data.manifest.get("tier")) for data in runs.values()})
    page = templates.get_template("paper_figures.html.j2").render(shown=shown, tier=", ".join(tiers))
    write_atomically(folder / "index.html", page)
    return folder / "index.html"


def claims_of(name: str, rows: list[ClaimRow]) -> list[ClaimRow]:
    """The rows whose source is the figure or table, such as "section 4.6, Fig. 21"."""
    number = int(re.sub(r"\D", "", name))
    told = rf"Fig\. {number}\b" if name.startswith("fig") else rf"Table {number}\b"
    return [row for row in rows if re.search(told, row.source) and row.verdict != "not measured"]
