"""`obstaclewatch validate`: check a file before it is used."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from benchmarks.commands import ALLOW_CODE

if TYPE_CHECKING:
    from benchmarks.gates.config import Gates


@click.command()
@click.argument("config")
@click.option("--allow-code", is_flag=True, help=ALLOW_CODE)
def validate(config: str, allow_code: bool) -> None:
    """Check CONFIG, a suite or a gates file (a name or a YAML file), and say what it holds."""
    from benchmarks.gates.config import gates_path, load_gates
    from benchmarks.plan.cells import plan_cells
    from benchmarks.plan.suite import load_suite
    from benchmarks.plan.trust import check_trust

    if _holds_gates(config):
        gates = load_gates(gates_path(config))
        click.echo(f"{gates.title}: {_counted(gates)}")
        return
    chosen = load_suite(config)
    check_trust(chosen, config, allow_code)
    for tier in chosen.tiers:
        click.echo(f"{tier}: {len(plan_cells(chosen, tier))} cells")


def _holds_gates(config: str) -> bool:
    """Whether the name is that of a gates file, or the file has one of its sections."""
    from benchmarks.gates.config import list_gates
    from scenes.files.bounded_yaml import parsed, read_text

    path = Path(config)
    if not path.is_file():
        return config in list_gates()
    data = parsed(read_text(path, "file"), path.name, "file")[0]
    return isinstance(data, dict) and bool({"claims", "regression", "physics"} & data.keys())


def _counted(gates: Gates) -> str:
    regressions = sum(len(asked.rates) + len(asked.approach) + len(asked.standing) for asked in gates.regression)
    return f"{len(gates.claims)} claims, {regressions} regression gates, {len(gates.physics)} physics gates"
