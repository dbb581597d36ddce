"""`obstaclewatch status`: how far a run is."""

from __future__ import annotations

import json
from pathlib import Path

import click

from benchmarks.results import load_run


@click.command()
@click.argument("run_folder", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="for machines")
def status(run_folder: Path, as_json: bool) -> None:
    """Count the cells of RUN_FOLDER that are done, failed and missing."""
    run = load_run(run_folder)
    planned, failed = len(run.manifest["plan"]), len(run.cells) - len(run.ok)
    counts = {"planned": planned, "ok": len(run.ok), "failed": failed, "missing": planned - len(run.cells)}
    if as_json:
        click.echo(json.dumps(counts))
    else:
        click.echo(", ".join(f"{count} {name}" for name, count in counts.items()))
