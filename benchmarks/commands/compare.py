"""`obstaclewatch compare`: two runs on the same walks."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from benchmarks.gates.comparison import Comparison


@click.command()
@click.argument("first_run", type=click.Path(path_type=Path))
@click.argument("second_run", type=click.Path(path_type=Path))
@click.option("--detector", "pairs", multiple=True, metavar="NAME[=OTHER]", help="NAME of the first run against OTHER")
@click.option("--json", "as_json", is_flag=True, help="for machines")
def compare(first_run: Path, second_run: Path, pairs: tuple[str, ...], as_json: bool) -> None:
    """Say what SECOND_RUN does differently from FIRST_RUN on the walks that both have.

    Rates: walks gained and lost, with McNemar's exact p. Quantities: the median (of shares and counts the mean) of the
    paired differences, of five walks or more with its 90 % bootstrap interval, and a star where that leaves out zero.
    One in ten is starred by chance. What the runs do not share is left out; the last lines say how much.
    """
    from benchmarks.gates.comparison import compare_runs, comparison_lines, left_out, left_out_line
    from benchmarks.runs.results import load_run

    asked = [_pair(text) for text in pairs] or None
    first, second = load_run(first_run), load_run(second_run)
    found = compare_runs(first, second, asked)
    apart = {
        "first": left_out(first, second, [one.first for one in found]),
        "second": left_out(second, first, [one.second for one in found]),
    }
    if as_json:
        said = {which: asdict(each) for which, each in apart.items()}
        click.echo(json.dumps([_as_data(one) | {"left_out": said} for one in found]))
        return
    lines = [line for one in found for line in comparison_lines(one)]
    click.echo("\n".join([*lines, *filter(None, (left_out_line(which, each) for which, each in apart.items()))]))


def _pair(text: str) -> tuple[str, str]:
    """A name may itself hold "=", within brackets: the one that parts two names comes outside of them."""
    depth = 0
    for place, character in enumerate(text):
        depth += (character == "(") - (character == ")")
        if character == "=" and depth == 0:
            return text[:place], text[place + 1 :]
    return text, text


def _as_data(found: Comparison) -> dict[str, object]:
    return {
        "first": found.first,
        "second": found.second,
        "outcome_differs": found.outcome_differs,
        "rates": {rate: asdict(change) | {"points": 0.0 - change.loss_points} for rate, change in found.rates.items()},
        "shifts": [
            {"kind": kind, "quantity": quantity, "unit": unit} | asdict(shift)
            for (kind, quantity, unit), shift in found.shifts.items()
        ],
    }
