"""`obstaclewatch report`: write a run's report again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from benchmarks.report.replays import MOST_WALKS

if TYPE_CHECKING:
    from benchmarks.runs.results import RunData


@click.command()
@click.argument("run_folder", type=click.Path(path_type=Path))
@click.option(
    "--walks",
    type=click.IntRange(min=0),
    default=MOST_WALKS,
    show_default=True,
    help="how many walks to pack for watching, at most",
)
@click.option(
    "-j", "--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="worker processes for those walks"
)
@click.option("--allow-code", is_flag=True, help="let detectors of the run's walks that lie in other modules run again")
def report(run_folder: Path, walks: int, jobs: int, allow_code: bool) -> None:
    """Write report.html and report.md of RUN_FOLDER.

    Its worst walks, and one of every category, are computed once more for the page's player, a few seconds each, and
    kept in RUN_FOLDER/replays.
    """
    from benchmarks.plan.trust import check_detectors
    from benchmarks.runs.results import load_run

    found = load_run(run_folder)
    if walks and not allow_code:
        named = {name for cell in found.cells for name in cell["cell"].get("detectors", ())}
        check_detectors(named, f"run '{run_folder}'")
    click.echo(_report_with_walks(found, walks, jobs))


def _report_with_walks(run: RunData, walks: int, jobs: int) -> Path:
    from benchmarks.report.replays.chosen_walks import chosen_walks
    from benchmarks.report.replays.stored_replays import replays_of
    from benchmarks.report.report import write_report

    return write_report(run, replays_of(run.folder, chosen_walks(run, walks), jobs))
