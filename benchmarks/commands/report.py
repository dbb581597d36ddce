"""`obstaclewatch report`: write a run's report again."""

from __future__ import annotations

from pathlib import Path

import click

from benchmarks.report import write_report
from benchmarks.results import load_run


@click.command()
@click.argument("run_folder", type=click.Path(path_type=Path))
def report(run_folder: Path) -> None:
    """Write report.html and report.md of RUN_FOLDER."""
    click.echo(write_report(load_run(run_folder)))
