"""The points of a sweep as runs of their own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from benchmarks.cells.spec import counts_as, label_of_walk, variant_text
from benchmarks.runs.results import RunData
from obstaclewatch.support.words import counted


def variants(run: RunData) -> dict[str, RunData]:
    """The run cut by the points of its sweep, in the order of the plan; one entry for a run without a sweep."""
    names = [variant_name(record["cell"].get("variant") or {}) for record in run.cells]
    parts = {}
    for name in dict.fromkeys(names):
        kept = [k for k, each in enumerate(names) if each == name]
        parts[name] = run.part(kept)
    return parts


def variant_name(variant: Mapping[str, Any]) -> str:
    """A point of a sweep for people: its name, or "start_hz=16000"; the unchanged suite is "as it is"."""
    return variant_text(dict(variant)).removeprefix("[").removesuffix("]") or "as it is"


def same_walks(parts: Mapping[str, RunData]) -> str:
    """Whether every point has measured the same walks, in words: cells may have failed at some, or be missing."""
    walks = [{_walk(record) for record in part.ok if counts_as(record["cell"], "approach")} for part in parts.values()]
    some = set().union(*walks)
    every = some.intersection(*walks)
    if every == some:
        return f"The same walks ({len(some)}) at every point."
    return f"{len(every)} of {counted(len(some), 'walk')} at every point, the others failed or are missing at some."


def _walk(record: Mapping[str, Any]) -> tuple[str, int]:
    """Label without the point, and seed."""
    cell = record["cell"]
    return label_of_walk(record["label"], cell.get("variant") or {}), cell["seed"]


def first_point(run: RunData) -> tuple[RunData, str]:
    """The first point of a run's sweep and a remark that says so; without a sweep the run itself and no remark.

    What is judged is judged of it alone: all points together would count each walk as often as there are points.
    """
    parts = variants(run)
    if len(parts) < 2:
        return run, ""
    name, first = next(iter(parts.items()))
    return first, f"Of the sweep, the point '{name}' alone."


def band_name(cell: Mapping[str, Any]) -> str:
    """ "16-23 kHz", of whatever else is swept."""
    return f"{cell['beep']['start_hz'] / 1e3:g}-{cell['beep']['stop_hz'] / 1e3:g} kHz"


def holding_name(cell: Mapping[str, Any]) -> str:
    """How the phone is held."""
    return str((cell.get("walk") or {}).get("holding") or "vertical")
