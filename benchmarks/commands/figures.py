"""`obstaclewatch figures`: draw a run's figures again."""

from __future__ import annotations

from pathlib import Path

import click

from benchmarks.figures import draw_figures
from benchmarks.results import load_run


@click.command()
@click.argument("run_folder", type=click.Path(path_type=Path))
@click.argument("names", nargs=-1)
def figures(run_folder: Path, names: tuple[str, ...]) -> None:
    """Draw the figures of RUN_FOLDER, all or the NAMES given (fig16 fig17 ...), as PNG, SVG and CSV."""
    for path in draw_figures(load_run(run_folder), list(names) or None):
        click.echo(path)
