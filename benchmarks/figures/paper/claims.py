"""The paper against the bench, claim by claim, as a table."""

from __future__ import annotations

from benchmarks.figures.paper.paper_claims import claim_rows
from benchmarks.figures.plots import TableFigure
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import first_point

COLUMNS = ("claim", "source", "the paper", "ours", "95 % interval", "n", "verdict")
WIDTHS = (2.3, 1.35, 1.1, 1.35, 1.35, 1.2, 0.9)


def claims_table(run: RunData) -> TableFigure:
    """The claims that this run can test, for the paper's detector."""
    rows = [row for row in claim_rows([run]) if row.verdict != "not measured"]
    cells = tuple((r.claim, r.source, r.paper, r.ours, r.interval, r.count, r.verdict) for r in rows)
    point = first_point(run)[1].removesuffix(".")
    remark = f" {point}, unless a claim compares points." if point else ""
    counts = [sum(row.verdict == word for row in rows) for word in ("reached", "inconclusive", "not reached")]
    return TableFigure(
        "claims",
        "The paper's claims on this bench: PaperDetector",
        COLUMNS,
        cells,
        WIDTHS,
        f"{counts[0]} claims reached, {counts[1]} inconclusive, {counts[2]} not reached.",
        "Reached: all of the 95 % interval is at least as good as the paper says. Rates: Clopper-Pearson; "
        "medians and percentiles: bootstrap over walks; orders: Fisher's exact test." + remark,
    )
