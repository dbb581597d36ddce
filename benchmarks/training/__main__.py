"""Learn anew: `python -m benchmarks.training decision -j 2`, and `bearing` likewise."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click
import numpy as np

from benchmarks.cells.spec import Cell
from benchmarks.runs.store import write_atomically
from benchmarks.training.bearings import BearingExamples, bearings_of, errors
from benchmarks.training.examples import APART, Examples, examples_of
from benchmarks.training.fit import (
    FALSE_COST,
    IN_TIME_M,
    MISS_COST,
    alerts_by,
    calibration,
    distances_left,
    rates,
    stated,
    with_thresholds,
)
from benchmarks.training.walks import FEWER, RECEPTIONS, development_cells, with_fewer_echoes, with_people_drawn
from obstaclewatch.support.whole_file import whole_file
from obstaclewatch.tracking.bearing_model import WEIGHTS as BEARING_WEIGHTS
from obstaclewatch.tracking.bearing_model import BearingModel
from obstaclewatch.tracking.collision_model import WEIGHTS, CollisionModel

SEEDS = {"learned": {"paper": 2018, "mixed": 2019}, "held out": {"paper": 7001, "mixed": 7001}}
"""Of the development split; more than 1299 walks of a recipe take the seeds that follow."""
WALKS, HELD_OUT = 10_000, 169
GIVEN = RECEPTIONS.index("walk ratio given")
MIXED_SHARE = 0.3
"""Of the walks; the others have the recipe `paper`."""
Found = TypeVar("Found", Examples, BearingExamples)
Command = TypeVar("Command", bound=Callable[..., None])
SHOWN_BEEPS = 40
"""Of held-out walks, whose pictures are kept to show that the weights are those of the card."""


@click.group()
def main() -> None:
    """Simulate walks of the development split, learn from them what `TrackingDetector` knows, and write it down."""


def _of_walks(walks: int, whole: int, receptions: int, output: Path) -> Callable[[Command], Command]:
    """The options of both commands, which share the walks' files, with what stands on the cards as the defaults."""

    def with_options(command: Command) -> Command:
        for option in (
            click.option(
                "-o", "--output", default=output, show_default=True, type=click.Path(path_type=Path),
                help="weights; card beside",
            ),
            click.option("--table", type=click.Path(path_type=Path), help="to keep what is known of held-out walks in"),
            click.option("--examples", "folder", default=Path("build/examples"), type=click.Path(path_type=Path)),
            click.option("-j", "--jobs", default=1, show_default=True),
            click.option(
                "--receptions", default=receptions, show_default=True, type=click.IntRange(1, len(RECEPTIONS)),
                help="of every walk: " + ", ".join(RECEPTIONS),
            ),
            click.option("--held-out", default=HELD_OUT, show_default=True, help="to measure with, of each recipe"),
            click.option(
                "--whole", default=whole, show_default=True, help="of these with all echoes; the rest have fewer"
            ),
            click.option("--walks", default=walks, show_default=True, help="to learn from"),
        ):  # fmt: skip
            command = option(command)
        return command

    return with_options


@main.command()
@_of_walks(walks=WALKS, whole=2490, receptions=2, output=WEIGHTS)
def decision(
    walks: int, whole: int, held_out: int, receptions: int, jobs: int, folder: Path, table: Path | None, output: Path
) -> None:
    """The probability of a collision, and the thresholds for an alert."""
    learned = examples_of(learned_walks(walks, whole), receptions, jobs, folder / "learned")
    model = model_of(learned, jobs)
    model.write(output)
    unseen = of_unseen(examples_of, held_out, receptions, jobs, folder)
    write_card(output, card(model, learned_from(walks, whole, receptions), unseen))
    if table is not None:
        write_table(table, unseen["paper"], model)


@main.command()
@_of_walks(walks=1660, whole=0, receptions=3, output=BEARING_WEIGHTS)
def bearing(
    walks: int, whole: int, held_out: int, receptions: int, jobs: int, folder: Path, table: Path | None, output: Path
) -> None:
    """The bearing of what a track follows."""
    from benchmarks.training.bearing_network import learned_bearings  # PyTorch is an extra

    model = learned_bearings(bearings_of(learned_walks(walks, whole), receptions, jobs, folder / "learned"))
    model.write(output)
    unseen = of_unseen(bearings_of, held_out, receptions, jobs, folder)
    write_card(output, bearing_card(model, learned_from(walks, whole, receptions), unseen))
    if table is not None:
        unseen["paper"].write(table)


def learned_walks(walks: int, whole: int) -> list[list[Cell]]:
    """So many walks to learn from, recipe by recipe: so many whole ones, then others with fewer echoes.

    Every second one has the reflection of people drawn.
    """
    parts = []
    for recipe, count in shared(walks).items():
        cells = with_people_drawn(development_cells(recipe, SEEDS["learned"][recipe], count))
        parts.append(with_fewer_echoes(cells, shared(whole).get(recipe, 0)))
    return parts


def learned_from(walks: int, whole: int, receptions: int) -> dict[str, Any]:
    """Of what a card says: walks of each recipe, how many of them have which fewer echoes, and receptions of each."""
    found: dict[str, Any] = {"walks": shared(walks)}
    if walks > whole:
        fewer = {recipe: count - shared(whole).get(recipe, 0) for recipe, count in shared(walks).items()}
        found["with fewer echoes"] = {"walks": fewer, "fidelity": FEWER}
    return found | {"receptions": receptions}


def of_unseen(
    examples_of_walks: Callable[..., Found], held_out: int, receptions: int, jobs: int, folder: Path
) -> dict[str, Found]:
    """Examples of so many walks of each recipe to measure with."""
    return {
        recipe: examples_of_walks(
            [development_cells(recipe, seed, held_out)], receptions, jobs, folder / "held-out" / recipe
        )
        for recipe, seed in SEEDS["held out"].items()
    }


def write_card(weights: Path, card: dict[str, Any]) -> None:
    """Beside the weights, and on the terminal."""
    text = json.dumps(card, indent=1) + "\n"
    write_atomically(weights.with_suffix(".json"), text)
    click.echo(text, nl=False)


def shared(walks: int) -> dict[str, int]:
    """How many walks of each recipe that has any."""
    mixed = round(MIXED_SHARE * walks)
    return {recipe: count for recipe, count in (("paper", walks - mixed), ("mixed", mixed)) if count}


def model_of(examples: Examples, jobs: int) -> CollisionModel:
    """The model learned from examples; thresholds are chosen on the first recipe, whose walks clearly hit or miss."""
    from benchmarks.training.network import learned  # PyTorch is an extra

    model, probability = learned(examples, jobs)
    first = examples.walk < APART
    return with_thresholds(model, examples.without_pictures[first], probability[first])


def write_table(path: Path, found: Examples, model: CollisionModel) -> None:
    """What is stated at the beeps of the first reception, and the pictures of some of them."""
    first = found[found.reception == 0]
    evidence, probability = first.evidence.astype(np.float32), stated(model, first).astype(np.float32)
    shown = np.arange(0, len(first), max(len(first) // SHOWN_BEEPS, 1))
    told: dict[str, Any] = {
        "walk": first.walk,
        "collides": first.collides,
        "left_m": first.left_m,
        "evidence": evidence,
    }
    with whole_file(path) as partial, partial.open("wb") as file:
        np.savez_compressed(file, **told, probability=probability, shown=shown, pictures=first.pictures[shown])


def card(model: CollisionModel, learned: dict[str, Any], unseen: dict[str, Examples]) -> dict[str, Any]:
    """What the model was learned from (`learned_from`), and what it does on walks that it has not seen."""
    return {
        "data": {"split": "dev", "seeds": SEEDS, **learned},
        "cost": {"collision without an alert": MISS_COST, "false alert": FALSE_COST, "in time, m left": IN_TIME_M},
        "held out": {recipe: measured(model, found) for recipe, found in unseen.items()},
    }


def bearing_card(model: BearingModel, learned: dict[str, Any], unseen: dict[str, BearingExamples]) -> dict[str, Any]:
    """What the model was learned from, and its errors on walks that it has not seen."""
    return {
        "data": {"split": "dev", "seeds": SEEDS, **learned},
        "held out": {recipe: errors(model, found) for recipe, found in unseen.items()},
        "held out, walk ratio given": {recipe: errors(model, found, GIVEN) for recipe, found in unseen.items()},
    }


def measured(model: CollisionModel, found: Examples) -> dict[str, Any]:
    """Rates of alerts by what is left, at the levels assumed and at levels drawn, and calibration."""
    probability = stated(model, found)
    alerts = alerts_by(model, probability, distances_left(found))
    entry: dict[str, Any] = {
        "walks": len(np.unique(found.walk)),
        "collisions": len(np.unique(found.walk[found.collides])),
    }
    for number, name in enumerate(RECEPTIONS):
        rows = found.reception == number
        if rows.any():
            each = {f"TP, {m:g} m left": rates(found[rows], alerts[rows], m)[0] for m in (0.0, 0.5, 1.0)}
            each["TN"] = rates(found[rows], alerts[rows], 0.0)[1]
            entry[name] = {key: None if np.isnan(rate) else round(rate, 3) for key, rate in each.items()}
    return entry | {"calibration": calibration(found, probability)}


if __name__ == "__main__":
    main()
