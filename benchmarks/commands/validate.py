"""`obstaclewatch validate`: check a suite before it runs."""

from __future__ import annotations

import click

from benchmarks.plan import plan_cells
from benchmarks.suite import load_suite


@click.command()
@click.argument("suite")
def validate(suite: str) -> None:
    """Check SUITE (a name or a YAML file) and count its cells by tier."""
    chosen = load_suite(suite)
    for tier in chosen.tiers:
        click.echo(f"{tier}: {len(plan_cells(chosen, tier))} cells")
