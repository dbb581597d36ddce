"""`obstaclewatch ls`: what there is to name."""

from __future__ import annotations

import click


@click.command()
@click.argument("what", type=click.Choice(["suites", "scenes", "phones", "figures", "gates", "checks"]))
def ls(what: str) -> None:
    """List the names of suites, scenes, phones, figures, gates files or physics checks."""
    for name in _names(what):
        click.echo(name)


def _names(what: str) -> list[str]:
    if what == "suites":
        from benchmarks.plan.suite import list_suites

        return list_suites()
    if what == "scenes":
        from scenes import list_scenes

        return list_scenes()
    if what == "phones":
        from simulator.phone.presets import list_phones

        return list(list_phones())
    if what == "gates":
        from benchmarks.gates.config import list_gates

        return list_gates()
    if what == "checks":
        from benchmarks.gates.physics import CHECKS

        return list(CHECKS)
    from benchmarks.plan.figure_names import FIGURE_RULES

    return list(FIGURE_RULES)
