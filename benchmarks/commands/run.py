"""`obstaclewatch run`: a suite from plan to report."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from benchmarks.commands import ALLOW_CODE
from benchmarks.gates.verdict import FAILED, INCOMPLETE
from benchmarks.interrupts import tell
from benchmarks.report.replays import MOST_WALKS
from benchmarks.runs import EXECUTORS
from obstaclewatch.support.words import counted

if TYPE_CHECKING:
    from benchmarks.cells.spec import Cell
    from benchmarks.plan.suite import Suite

APPROACH_S = 15.0
"""No approach of the recipes lasts longer."""
MOST_FAILURES = 5
"""That are named with their reasons."""


@click.command()
@click.argument("suite")
@click.option("--tier", default="ci", show_default=True, help="smoke, ci or full")
@click.option("-j", "--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="worker processes")
@click.option("--seed", type=click.IntRange(min=0), help="replaces the suite's seed")
@click.option("--split", type=click.Choice(["dev", "test"]), help="which seeds: dev to tune, test to report")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="change one value of the suite")
@click.option("--limit", type=click.IntRange(min=1), help="so many of the cells at most, spread over the suite")
@click.option("--only", metavar="LABEL", help="one cell alone, e.g. supermarket/dustbin/17")
@click.option("-k", "expression", metavar="EXPR", help="cells whose label fits, e.g. 'dustbin and not campus'")
@click.option("--executor", type=click.Choice(EXECUTORS), help="where cells are computed  [local if -j > 1]")
@click.option("--scheduler", metavar="ADDR", help="of a Dask scheduler, e.g. tcp://10.0.0.1:8786; --executor dask")
@click.option(
    "--retries",
    type=click.IntRange(min=0),
    default=1,
    show_default=True,
    help="how often failed or lost cells are tried again",
)
@click.option("--keep-going/--fail-fast", default=True, show_default=True, help="after a cell has failed")
@click.option(
    "--walks",
    type=click.IntRange(min=0),
    default=MOST_WALKS,
    show_default=True,
    help="how many to pack into the report, at most",
)
@click.option("--allow-code", is_flag=True, help=ALLOW_CODE)
@click.option("-n", "--dry-run", is_flag=True, help="print the plan and stop")
@click.option("-o", "--out", type=click.Path(path_type=Path), default=Path("results"), show_default=True)
def run(
    suite: str, tier: str, jobs: int, seed: int | None, split: str | None, settings: tuple[str, ...],
    limit: int | None, only: str | None, expression: str | None, executor: str | None, scheduler: str | None,
    retries: int, keep_going: bool, walks: int, allow_code: bool, dry_run: bool, out: Path,
) -> None:  # fmt: skip
    """Run SUITE (a name or a YAML file) and leave a run folder with results, figures and report.

    The folder's name follows from the plan and the version of the source, so the same command resumes what is
    missing and never mixes results of another plan or version.
    """
    from benchmarks.bench import chosen_cells, planned, prepared
    from benchmarks.cells.memory import check_workers
    from benchmarks.runs.executors import choose_executor
    from benchmarks.runs.runner import run_cells, shortfall

    place = choose_executor(executor, jobs, scheduler)
    chosen = planned(suite, [*settings, *([f"split={split}"] if split else [])], seed, allow_code)
    cells = chosen_cells(chosen, tier, only, expression, limit)
    walk = _longest_s(cells), chosen.beep.sample_rate_hz
    memory = "" if scheduler else check_workers(jobs, *walk, _process_bytes(cells))
    if dry_run:
        _print_plan(chosen, tier, cells)
        click.echo(memory)
        return
    folder = prepared(out, chosen, tier, cells)
    tell(f"{counted(len(cells), 'cell')} of suite '{chosen.name}', tier {tier}, into {folder}")
    tell(memory)
    try:
        tally = run_cells(folder, cells, place, retries=retries, keep_going=keep_going)
        finish(folder, walks, jobs)
    except OSError as error:
        tell(f"cannot store results: {error}; what is done is kept, the same command goes on", sys.stderr)
        sys.exit(INCOMPLETE)
    for line in [*tally.remarks(), *shortfall(folder, tally, MOST_FAILURES)]:
        tell(line, sys.stderr)
    if wrong := _wrong(folder):
        tell("\n".join(wrong), sys.stderr)
        sys.exit(FAILED)
    if not tally.complete:
        sys.exit(INCOMPLETE)


def finish(folder: Path, walks: int, jobs: int) -> None:
    """Tables and summary of what is stored, the verdict on standard output, and then figures and report.

    Figures are drawn while other processes pack the walks.

    Args:
        folder: of the run.
        walks: how many the report packs for watching, at most.
        jobs: processes to compute these with.
    """
    from benchmarks.bench import tabulated
    from benchmarks.figures import figures_of, write_figures
    from benchmarks.report.replays.chosen_walks import chosen_walks
    from benchmarks.report.replays.stored_replays import replays_begun
    from benchmarks.report.report import write_report
    from benchmarks.report.verdict_lines import verdict_lines

    data, found = tabulated(folder)
    if not data.ok:
        return
    tell("\n".join(verdict_lines(found)))
    packed = replays_begun(folder, chosen_walks(data, walks), jobs)
    figures = figures_of(data)
    write_figures(folder, [drawn for drawn in figures if not drawn.figure.empty])
    tell(f"report: {write_report(data, packed(), figures)}")


def _longest_s(cells: list[Cell]) -> float:
    """Duration of the longest walk of a scene of one's own, or of any approach."""
    from scenes import load_encounter

    own = {(cell.approach["file"], cell.seed, cell.approach["phone"]) for cell in cells if cell.kind == "scene"}
    return max((load_encounter(*walk).walk.duration_s for walk in own), default=APPROACH_S)


def _process_bytes(cells: list[Cell]) -> float:
    """What a process takes beside its walk; cells that compare levels run the finest as well."""
    from benchmarks.cells.memory import FINE_BYTES, FINE_FACET_M, PROCESS_BYTES
    from simulator import Fidelity

    fine = any(cell.kind == "fidelity" or Fidelity(**cell.fidelity).facet_m < FINE_FACET_M for cell in cells)
    return FINE_BYTES if fine else PROCESS_BYTES


def _wrong(folder: Path) -> list[str]:
    """A line for every case of an extreme that came out silently wrong, or was refused though it can be."""
    from benchmarks.runs.results import load_run

    cases = [(record, record["result"].get("numerics", {})) for record in load_run(folder).ok]
    return [_why(record, case) for record, case in cases if case.get("verdict") == "wrong"]


def _why(record: dict[str, Any], case: dict[str, Any]) -> str:
    name = f"{record['label']} {record['cell']['probe']}"
    if case["refused"]:
        return f"refused though it can be: {name}: {case['refused']}"
    return f"silently wrong: {name}: {case['errors']}, limits {case['limits']}"


def _print_plan(suite: Suite, tier: str, cells: list[Cell]) -> None:
    click.echo(f"suite '{suite.name}', tier {tier}: {counted(len(cells), 'cell')}")
    for name in sorted({(cell.kind, cell.scene, cell.category) for cell in cells}):
        count = sum((cell.kind, cell.scene, cell.category) == name for cell in cells)
        click.echo(f"  {' '.join(name)}: {count}")
