"""Which walks of a run are worth watching: the worst of each kind, and one of every category."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from benchmarks.cells.spec import counts_as
from benchmarks.report.cases import worst_cases
from benchmarks.report.replays import MOST_WALKS
from benchmarks.runs.results import RunData


@dataclass(frozen=True)
class ChosenWalk:
    """A walk to watch.

    Attributes:
        record: the stored cell.
        why: what it is an example of, a phrase.
    """

    record: dict[str, Any]
    why: str


def chosen_walks(run: RunData, most: int = MOST_WALKS) -> list[ChosenWalk]:
    """At most so many walks: the worst miss and false alert of every judged detector, then one of every category.

    Of a category that the worst cases leave out the first collision that a detector alerted to in time is taken,
    else its first collision, else its first walk.
    """
    if most < 0:
        raise ValueError(f"the number of walks to show must be at least 0, got {most}")
    walks = [record for record in run.ok if counts_as(record["cell"], "approach")]
    labelled = {record["label"]: record for record in walks}
    found: dict[str, ChosenWalk] = {}
    for kind in worst_cases(run, most=1):
        for case in kind.cases:
            why = f"{kind.title.lower().removesuffix('s')} of {kind.detector}: {case.what}"
            found.setdefault(case.label, ChosenWalk(labelled[case.label], why))
    covered = {chosen.record["cell"]["category"] for chosen in found.values()}
    for category in dict.fromkeys(record["cell"]["category"] for record in walks):
        if category not in covered:
            example = _example([record for record in walks if record["cell"]["category"] == category])
            found.setdefault(example.record["label"], example)
    return list(found.values())[:most]


def _example(walks: list[dict[str, Any]]) -> ChosenWalk:
    category = walks[0]["cell"]["category"]
    for record in walks:
        for name, entry in record["result"]["detectors"].items():
            if entry["outcome"] == "TP":
                return ChosenWalk(record, f"example of a {category}: {name} alerts in time")
    collisions = [record for record in walks if record["result"]["truth"]["collides"]]
    return ChosenWalk([*collisions, *walks][0], f"example of a {category}")
