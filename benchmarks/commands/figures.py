"""`obstaclewatch figures`: draw a run's figures again."""

from __future__ import annotations

from pathlib import Path

import click

from benchmarks.figures import draw_figures
from benchmarks.figures.measured import detectors_of
from benchmarks.runs.results import load_run
from benchmarks.runs.store import write_atomically


@click.command()
@click.argument("run_folder", type=click.Path(path_type=Path))
@click.argument("names", nargs=-1)
@click.option("--claims", "detector", metavar="DETECTOR", help="also write claims.md: the paper beside this detector")
@click.option("--with", "others", multiple=True, type=click.Path(path_type=Path), metavar="RUN",
              help="further runs for the claims that RUN_FOLDER does not test")  # fmt: skip
def figures(run_folder: Path, names: tuple[str, ...], detector: str | None, others: tuple[Path, ...]) -> None:
    """Draw the figures of RUN_FOLDER, all or the NAMES given (fig16 fig17 ...), as PNG, SVG and CSV."""
    run = load_run(run_folder)
    if others and detector is None:
        raise ValueError("--with needs --claims DETECTOR")
    further = [load_run(folder) for folder in others]
    known = {name for each in (run, *further) for name in detectors_of(each)}
    if detector is not None and known and detector not in known:  # runs of probes alone have none
        raise ValueError(f"--claims must name a detector of the runs, {sorted(known)}, got '{detector}'")
    for path in draw_figures(run, list(names) or None):
        click.echo(path)
    if detector is not None:
        from benchmarks.figures.paper.paper_claims import claim_rows, claims_markdown

        target = run.folder / "claims.md"
        write_atomically(target, claims_markdown(claim_rows([run, *further], detector), detector))
        click.echo(target)
