"""`obstaclewatch export`: a labelled data set of a suite."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from benchmarks.commands import ALLOW_CODE
from benchmarks.gates.verdict import INCOMPLETE
from benchmarks.interrupts import tell
from obstaclewatch.support.words import counted


@click.command()
@click.argument("suite")
@click.argument("out", type=click.Path(path_type=Path, file_okay=False))
@click.option("--walks", type=click.IntRange(min=1), required=True, help="how many, of all splits together")
@click.option("-j", "--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="worker processes")
@click.option("--seed", type=click.IntRange(min=0), help="replaces the suite's seed")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="change one value of the suite")
@click.option("--allow-code", is_flag=True, help=ALLOW_CODE)
def export(
    suite: str, out: Path, walks: int, jobs: int, seed: int | None, settings: tuple[str, ...], allow_code: bool
) -> None:
    """Write recordings of SUITE (a name or a YAML file) with truth, paths and splits to the folder OUT.

    For people who train detectors of their own: FLAC, Parquet, and a card with a loader that needs nothing of this
    project. The same command goes on where it stopped; more --walks add to those that are there.
    """
    from benchmarks.bench import planned
    from benchmarks.dataset import split_walks, write_data_set
    from benchmarks.runs.executors import choose_executor

    chosen = planned(suite, settings, seed, allow_code)
    cells = split_walks(chosen, walks)
    tell(f"{counted(len(cells), 'walk')} of suite '{chosen.name}' into {out}")
    tally = write_data_set(out, chosen, cells, choose_executor(None, jobs), sys.argv[1:])
    tell(f"{out / 'README.md'}: {counted(len(tally.ok), 'walk')}")
    for line in tally.remarks():
        tell(line, sys.stderr)
    if not tally.complete:
        tell(f"{counted(len(tally.failed), 'walk')} failed, {len(tally.missing)} missing", sys.stderr)
        sys.exit(INCOMPLETE)
