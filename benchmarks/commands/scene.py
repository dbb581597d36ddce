"""`obstaclewatch scene`: look at scenes."""

from __future__ import annotations

from pathlib import Path

import click

from scenes import load_scene, make_approach
from scenes.preview import preview_approach, preview_scene


@click.group()
def scene() -> None:
    """Draw a scene or an approach."""


@scene.command()
@click.argument("name")
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="a .png file")
@click.option("--seed", default=0, show_default=True)
@click.option("--category", help="one approach instead of the whole street")
@click.option("--index", default=0, show_default=True)
@click.option("--collision/--no-collision", default=True, show_default=True)
def preview(name: str, output: Path, seed: int, category: str | None, index: int, collision: bool) -> None:
    """Draw NAME (a scene or a YAML file) from above."""
    if category is None:
        preview_scene(load_scene(name, seed), output)
    else:
        preview_approach(make_approach(name, category, index, seed=seed, collision=collision), output)
    click.echo(output)
