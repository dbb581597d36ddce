"""`obstaclewatch figures`: draw a run's figures again, or all of the paper's."""

from __future__ import annotations

from pathlib import Path

import click

from benchmarks.commands import refuse_given


@click.command()
@click.argument("folder", type=click.Path(path_type=Path), required=False)
@click.argument("names", nargs=-1)
@click.option("--claims", "detector", metavar="DETECTOR", help="also write claims.md: the paper beside this detector")
@click.option("--with", "others", multiple=True, type=click.Path(path_type=Path), metavar="RUN",
              help="further runs for the claims that FOLDER does not test")  # fmt: skip
@click.option("--paper", is_flag=True, help="Figures 1-27 and Table 1 into FOLDER, from the suites that reproduce them")
@click.option("--tier", default="ci", show_default=True, help="of these suites: smoke, ci or full")
@click.option(
    "-j", "--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="worker processes for them"
)
@click.option("-o", "--out", type=click.Path(path_type=Path), default=Path("results"), show_default=True,
              help="where their runs are stored; those that are there are not computed again")  # fmt: skip
def figures(
    folder: Path | None, names: tuple[str, ...], detector: str | None, others: tuple[Path, ...], paper: bool, tier: str,
    jobs: int, out: Path,
) -> None:  # fmt: skip
    """Draw the figures of a run's FOLDER, all or the NAMES given (fig16 fig17 ...), as PNG, SVG and CSV.

    With --paper, FOLDER (OUT/paper-figures if none is given) gets every picture of the paper and a page, index.html,
    with the paper's values beside.
    """
    if paper:
        if names or others or detector:
            raise ValueError("--paper draws all of the paper's figures, and takes no names, --claims or --with")
        from benchmarks.paper_figures import paper_runs, write_paper_figures

        click.echo(write_paper_figures(paper_runs(tier, jobs, out), folder or out / "paper-figures"))
        return
    refuse_given(("tier", "jobs", "out"), "there is no --paper")
    if folder is None:
        raise ValueError("FOLDER must name a run, or --paper ask for the paper's figures")
    _draw_run(folder, names, detector, others)


def _draw_run(folder: Path, names: tuple[str, ...], detector: str | None, others: tuple[Path, ...]) -> None:
    from benchmarks.figures import draw_figures
    from benchmarks.figures.measured import detectors_of
    from benchmarks.runs.results import load_run
    from benchmarks.runs.store import write_atomically

    run = load_run(folder)
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
