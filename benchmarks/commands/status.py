"""`obstaclewatch status`: how far a run is."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from benchmarks.gates.verdict import INCOMPLETE

if TYPE_CHECKING:
    from benchmarks.runs.results import RunData


@click.command()
@click.argument("run_folder", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="for machines")
@click.option(
    "--failures", type=click.IntRange(min=0), default=5, show_default=True, help="how many failed cells to name"
)
def status(run_folder: Path, as_json: bool, failures: int) -> None:
    """Count the cells of RUN_FOLDER that are done, failed and missing. Exit code 3 unless all are done."""
    from benchmarks.runs.results import load_run

    run = load_run(run_folder)
    found = _counts(run)
    if as_json:
        click.echo(json.dumps(found))
    else:
        click.echo("\n".join(_lines(run, found, failures)))
    if found["ok"] < found["planned"]:
        sys.exit(INCOMPLETE)


def _counts(run: RunData) -> dict[str, Any]:
    planned, failed = len(run.manifest["plan"]), len(run.cells) - len(run.ok)
    spent = [cost["total_s"] for cost in run.costs if "total_s" in cost]
    memory = [cost["peak_rss_mb"] for cost in run.costs if "peak_rss_mb" in cost]
    return {
        "planned": planned,
        "ok": len(run.ok),
        "failed": failed,
        "missing": planned - len(run.cells),
        "computing_s": sum(spent),
        "peak_rss_mb": max(memory, default=None),
    }


def _lines(run: RunData, found: dict[str, Any], failures: int) -> Iterator[str]:
    from benchmarks.runs.reasons import reason

    yield ", ".join(f"{found[name]} {name}" for name in ("planned", "ok", "failed", "missing"))
    if found["ok"] and found["computing_s"]:
        left_s = found["computing_s"] / found["ok"] * (found["planned"] - found["ok"])
        yield f"{found['computing_s']:.0f} s of computing so far, about {left_s:.0f} s left, over all processes"
    broken = [cell for cell in run.cells if cell["status"] == "failed"]
    for cell in broken[:failures]:
        yield f"failed: {cell['label']}: {reason(cell['error'])}"
    if found["missing"] or found["failed"]:
        yield f"to go on: obstaclewatch {shlex.join(run.manifest['argv'])}"
