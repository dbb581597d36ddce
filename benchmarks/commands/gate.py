"""`obstaclewatch gate`: an exit code that says whether a run is good enough."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from benchmarks.gates.config import Gates


@click.command()
@click.argument("run_folder", type=click.Path(path_type=Path))
@click.option("--gates", "gates_file", default="project", show_default=True, help="name or YAML file of the gates")
@click.option("--baseline", "baseline_file", type=click.Path(path_type=Path), help="replaces the gates file's own")
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="of the noise in the physics gates"
)
def gate(run_folder: Path, gates_file: str, baseline_file: Path | None, seed: int) -> None:
    """Judge RUN_FOLDER and leave gate.json, junit.xml and gate.md in it.

    Exit codes: 0 all green; 1 a gate is red; 3 none is, but cells failed or are missing; 4 a gate measured nothing, or
    the baseline cannot be compared.
    """
    from benchmarks.gates.baseline import IncompatibleBaselineError, load_baseline
    from benchmarks.gates.config import gates_path, load_gates
    from benchmarks.gates.judge import is_complete, judge
    from benchmarks.gates.output import table_lines, write_gate_files
    from benchmarks.gates.verdict import UNMEASURED, exit_code
    from benchmarks.runs.manifest import other_source
    from benchmarks.runs.results import load_run

    path = gates_path(gates_file)
    gates = load_gates(path)
    run = load_run(run_folder)
    note = other_source(run.manifest)
    if note is not None:
        click.echo(note, err=True)
    baseline = _baseline_path(gates, path, baseline_file)
    try:
        before = None if baseline is None else load_baseline(baseline)
    except IncompatibleBaselineError as error:
        click.echo(f"obstaclewatch: {error}", err=True)
        sys.exit(UNMEASURED)
    verdicts = judge(run, gates, before, seed)
    code = exit_code(verdicts, is_complete(run))
    write_gate_files(run_folder, gates.title, verdicts, code, note)
    click.echo("\n".join(table_lines(verdicts)))
    if not run.ok:
        click.echo("the run holds no measured cell: nothing was judged of it", err=True)
    elif not is_complete(run):
        click.echo(f"the run is incomplete: {len(run.ok)} good cells of {len(run.manifest['plan'])}", err=True)
    if code == UNMEASURED:
        click.echo("a gate that measured nothing is not green; see its line above", err=True)
    sys.exit(code)


def _baseline_path(gates: Gates, path: Path, given: Path | None) -> Path | None:
    if given is not None:
        return given
    return None if gates.baseline is None or not gates.regression else path.parent / gates.baseline
