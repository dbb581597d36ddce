"""`obstaclewatch scene`: look at scenes."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from benchmarks.commands import OF_APPROACH, check_output, refuse_given
from obstaclewatch.support.words import counted

if TYPE_CHECKING:
    from scenes import Encounter
    from scenes.checks.check import Finding
    from scenes.checks.requirements import Cost, Need

UNFIT = 2
"""Exit code of a scene with errors."""


@click.group()
def scene() -> None:
    """Check or draw a scene or an approach."""


@scene.command()
@click.argument("name")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@click.option("--json", "as_json", is_flag=True, help="one JSON object")
@click.option(
    "--cost/--no-cost", default=True, show_default=True, help="simulate the opening of a walk, to say what one takes"
)
@click.option("--auto", is_flag=True, help="trace five instants at level auto, to say whom it integrates: minutes")
def check(name: str, seed: int, as_json: bool, cost: bool, auto: bool) -> None:
    """Check NAME (a scene or a YAML file) and say what the simulator will need for it.

    Exit codes: 0 fit, warnings or none; 2 an error that would make its echoes wrong.
    """
    from tqdm import tqdm

    from scenes import load_encounter
    from scenes.checks.check import check_scene
    from scenes.checks.requirements import INSTANTS, TIMED_STEPS, integrals_needed, needs_of, rendering_cost
    from scenes.files.encounter import has_walk

    walked = has_walk(name)
    met = load_encounter(name, seed) if walked else _walked_straight(name, seed)
    price, integrals = None, None
    steps = 1 + cost * TIMED_STEPS + auto * INSTANTS
    with tqdm(desc="meshes", total=steps, unit="step", leave=False, disable=not sys.stderr.isatty()) as bar:
        findings = check_scene(met.scene, met.walk, met.phone) if walked else check_scene(met.scene)
        bar.update()
        sound = not any(finding.severity == "error" for finding in findings)
        if cost and sound:
            bar.set_description("first beeps")
            price = rendering_cost(met.scene, met.phone, met.walk, step=bar.update)
        needs = needs_of(met.scene)
        if auto and sound:
            bar.set_description("instants at level auto")
            integrals = integrals_needed(met.scene, met.phone, met.walk, bar.update)
    show = _as_json if as_json else _as_text
    click.echo(show(name, findings, needs, price, integrals))
    if not sound:
        sys.exit(UNFIT)


def _walked_straight(name: str, seed: int) -> Encounter:
    """A scene without a walk of its own on the one that `simulate` takes: from the origin along +x."""
    from scenes import Encounter, GaitWalk, load_scene, walker_body
    from simulator import Phone

    held = Phone.named("galaxy-s5").held_by(walker_body(phone_height_m=1.3))
    return Encounter(load_scene(name, seed), GaitWalk(np.array([0.0, 0.0, 1.3]), duration_s=4.5), held, ())


def _as_json(
    name: str, findings: list[Finding], needs: list[Need], cost: Cost | None, integrals: list[str] | None
) -> str:
    rows = [asdict(need) | {"mechanisms": need.mechanisms} for need in needs]
    price: dict[str, Any] | None = None if cost is None else asdict(cost) | {"walk_s": cost.walk_s}
    return json.dumps(
        {
            "scene": name,
            "findings": [asdict(one) for one in findings],
            "obstacles": rows,
            "cost": price,
            "integrals": integrals,
        },
        indent=1,
    )


def _as_text(
    name: str, findings: list[Finding], needs: list[Need], cost: Cost | None, integrals: list[str] | None
) -> str:
    width = max((len(need.name) for need in needs), default=0)
    lines = [f"{'obstacle':{width}}  category    triangles  closed  planes  curved  edges  size (m)"]
    for need in needs:
        size = " x ".join(f"{extent:.3g}" for extent in need.size_m)
        closed = "yes" if need.closed else "no"
        lines.append(
            f"{need.name:{width}}  {need.category or '-':10}  {need.triangles:9d}  {closed:6}  {need.planes:6d}"
            f"  {need.curved:6d}  {need.edges:5d}  {size}{'  moves' if need.moves else ''}"
        )
    asked = sorted({mechanism for need in needs for mechanism in need.mechanisms})
    lines.append(f"mechanisms needed: {', '.join(asked) or 'none'}")
    if cost is not None:
        lines.append(
            f"rendering: {cost.prepare_s:.2f} s to prepare the scene and {1e3 * cost.per_beep_s:.0f} ms a beep here, "
            f"{cost.walk_s:.1f} s for {counted(cost.beeps, 'beep')}"
        )
    if integrals:
        lines.append(f"rays err by more than 0.5 dB, so that level auto integrates: {', '.join(integrals)}")
    lines += [f"{one.severity}: {one.obstacle}: {one.rule}: {one.message}" for one in findings]
    errors = sum(one.severity == "error" for one in findings)
    return "\n".join([*lines, f"{name}: errors: {errors}, warnings: {len(findings) - errors}"])


@scene.command()
@click.argument("name")
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="a .html or .png file")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@click.option("--category", help="one approach instead of the whole street")
@click.option("--index", type=click.IntRange(min=0), default=0, show_default=True)
@click.option("--collision/--no-collision", default=True, show_default=True)
def preview(name: str, output: Path, seed: int, category: str | None, index: int, collision: bool) -> None:
    """Draw NAME (a scene or a YAML file): .html to turn in a browser, with its sound; .png from above."""
    from scenes.files.encounter import has_walk
    from scenes.preview.page import preview_html
    from scenes.preview.pictures import preview_around, preview_scene

    if category is None:
        refuse_given(OF_APPROACH, "there is no --category")
    check_output(output, "--output", (".html", ".png"))
    suffix = output.suffix.lower()
    met = _shown(name, seed, category, index, collision)
    if suffix == ".html":
        preview_html(met.scene, output, met.walk, met.phone)
    elif category is not None:
        preview_around(met.scene, met.walk, met.targets[0], output)
    else:
        preview_scene(met.scene, output, met.walk if has_walk(name) else None, next(iter(met.targets), None))
    click.echo(output)


def _shown(name: str, seed: int, category: str | None, index: int, collision: bool) -> Encounter:
    """The approach, the file's own walk, or a straight one."""
    from scenes import Encounter, load_encounter, make_approach
    from scenes.files.encounter import has_walk

    if category is not None:
        found = make_approach(name, category, index, seed=seed, collision=collision)
        return Encounter(found.scene, found.walk, found.phone, (found.target,))
    return load_encounter(name, seed) if has_walk(name) else _walked_straight(name, seed)
