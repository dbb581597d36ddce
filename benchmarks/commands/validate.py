"""`obstaclewatch validate`: check a file before it is used."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from benchmarks.commands import ALLOW_CODE
from obstaclewatch.support.words import counted

if TYPE_CHECKING:
    from benchmarks.gates.config import Gates


@click.command()
@click.argument("config")
@click.option("--allow-code", is_flag=True, help=ALLOW_CODE)
def validate(config: str, allow_code: bool) -> None:
    """Check CONFIG, a suite or a gates file (a name or a YAML file), and say what it holds.

    Scene files are for `scene check`.
    """
    from benchmarks.gates.config import gates_path, list_gates, load_gates
    from benchmarks.gates.names import foreign_names
    from benchmarks.plan.cells import plan_cells
    from benchmarks.plan.suite import load_suite
    from benchmarks.plan.trust import check_trust

    sections = _sections(config)
    if "obstacles" in sections:
        raise click.UsageError(f"{config} is a scene file: obstaclewatch scene check {config}")
    if config in list_gates() or sections & {"claims", "regression", "physics"}:
        gates = load_gates(gates_path(config))
        click.echo(f"{gates.title}: {_counted(gates)}")
        for line in foreign_names(gates):
            click.echo(f"{line}; if no run has it, the gate measures nothing")
        return
    chosen = load_suite(config)
    check_trust(chosen, config, allow_code)
    for tier in chosen.tiers:
        click.echo(f"{tier}: {counted(len(plan_cells(chosen, tier)), 'cell')}")


def _sections(config: str) -> set[str]:
    """The sections of a file; none of a name."""
    from scenes.files.bounded_yaml import parsed, read_text

    path = Path(config)
    data = parsed(read_text(path, "file"), path.name, "file")[0] if path.is_file() else {}
    return set(data) if isinstance(data, dict) else set()


def _counted(gates: Gates) -> str:
    regressions = sum(len(asked.rates) + len(asked.approach) + len(asked.standing) for asked in gates.regression)
    counts = {"claim": len(gates.claims), "regression gate": regressions, "physics gate": len(gates.physics)}
    return ", ".join(counted(count, name) for name, count in counts.items())
