"""`obstaclewatch ls`: what there is to name."""

from __future__ import annotations

from collections.abc import Callable

import click


@click.command()
@click.argument(
    "what", type=click.Choice(["suites", "scenes", "phones", "detectors", "materials", "figures", "gates", "checks"])
)
def ls(what: str) -> None:
    """List the names of suites or figures, with what they show, or of scenes, phones, detectors, materials, gates files
    or physics checks."""
    for name in NAMES[what]():
        click.echo(name)


def _suites() -> list[str]:
    from benchmarks.plan.suite import list_suites, load_suite

    return _beside({name: load_suite(name).title for name in list_suites()})


def _beside(titles: dict[str, str]) -> list[str]:
    width = max(map(len, titles))
    return [f"{name:<{width}}  {title}" for name, title in titles.items()]


def _scenes() -> list[str]:
    from scenes import list_scenes

    return list_scenes()


def _phones() -> list[str]:
    from simulator.phone.presets import list_phones

    return list(list_phones())


def _detectors() -> list[str]:
    from benchmarks.cells.detectors import own_detectors

    return own_detectors()


def _materials() -> list[str]:
    from simulator.scene.materials import list_materials

    return list_materials()


def _figures() -> list[str]:
    from benchmarks.plan.figure_names import FIGURE_RULES, FIGURE_SUBJECTS

    return _beside({name: FIGURE_SUBJECTS[name] for name in FIGURE_RULES})


def _gates() -> list[str]:
    from benchmarks.gates.config import list_gates

    return list_gates()


def _checks() -> list[str]:
    from benchmarks.gates.physics import CHECKS

    return list(CHECKS)


NAMES: dict[str, Callable[[], list[str]]] = {
    "suites": _suites, "scenes": _scenes, "phones": _phones, "detectors": _detectors, "materials": _materials,
    "figures": _figures, "gates": _gates, "checks": _checks,
}  # fmt: skip
