"""What a suite of someone else may not do unasked: run code of its choice, and read files from anywhere."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from benchmarks.cells.detectors import parse_detector
from benchmarks.plan.suite import Suite, is_own
from benchmarks.plan.sweep import Range


def check_trust(suite: Suite, name_or_path: str, allow_code: bool) -> None:
    """Refuse what a suite file asks for beyond its folder; suites of the project, changed by `--set`, may do anything.

    Args:
        suite: as loaded.
        name_or_path: from where.
        allow_code: whether modules named as detectors may be imported.

    Raises:
        ValueError: a detector by dotted path, or a scene file neither below the suite's folder nor below the working
            directory.
    """
    if is_own(name_or_path):
        return
    if not allow_code:
        check_detectors(_detectors(suite), f"suite file '{name_or_path}'")
    roots = [Path.cwd(), Path(name_or_path).resolve().parent]
    for own in suite.scenes:
        if not any(Path(own.file).resolve().is_relative_to(root) for root in roots):
            raise ValueError(
                f"suite file '{name_or_path}' must name scene files below its folder or the working directory, "
                f"got '{own.file}'"
            )


def check_detectors(names: Iterable[str], source: str) -> None:
    """Raise ValueError where a detector lies in a module of its own: importing one runs it."""
    foreign = sorted({name for name in names if parse_detector(name).module})
    if foreign:
        raise ValueError(f"{source} has detectors that run code of their own, {foreign}: --allow-code lets them")


def _detectors(suite: Suite) -> Iterator[str]:
    yield from suite.detectors
    if suite.standing is not None:
        yield from suite.standing.detectors
    if suite.sweep is not None:
        swept = suite.sweep.over.get("detector.name", [])
        values: list[Any] = [] if isinstance(swept, Range) else [*swept]
        values += [point["detector.name"] for point in suite.sweep.points if "detector.name" in point]
        yield from map(str, values)
