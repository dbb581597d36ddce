"""`obstaclewatch validate`: check a file before it is used."""

from __future__ import annotations

from pathlib import Path

import click
import yaml

from benchmarks.gates.config import Gates, gates_path, list_gates, load_gates
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite


@click.command()
@click.argument("config")
def validate(config: str) -> None:
    """Check CONFIG, a suite or a gates file (a name or a YAML file), and say what it holds."""
    if _holds_gates(config):
        gates = load_gates(gates_path(config))
        click.echo(f"{gates.title}: {_counted(gates)}")
        return
    chosen = load_suite(config)
    for tier in chosen.tiers:
        click.echo(f"{tier}: {len(plan_cells(chosen, tier))} cells")


def _holds_gates(config: str) -> bool:
    """Whether the name is that of a gates file, or the file has one of its sections."""
    path = Path(config)
    if not path.is_file():
        return config in list_gates()
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError):
        return False
    return isinstance(data, dict) and bool({"claims", "regression", "physics"} & data.keys())


def _counted(gates: Gates) -> str:
    regressions = sum(len(asked.rates) + len(asked.approach) + len(asked.standing) for asked in gates.regression)
    return f"{len(gates.claims)} claims, {regressions} regression gates, {len(gates.physics)} physics gates"
