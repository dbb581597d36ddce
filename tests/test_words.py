"""The field's words: what the project writes for people to read keeps to them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("benchmarks", "scenes", "simulator", "obstaclewatch", "docs/studies")
PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")
SUFFIXES = (".py", ".md", ".yaml", ".j2", ".html")
EVERYWHERE = {
    r"in peace": "no alert, true negative (TN)",
    r"turned away": "rejected",
    r"\byardstick": "reference",
    r"\bwall ends\b": "passed walls",
    r"\bways of (the )?(sound|echo)|\bway left\b|of way before": "paths, distance to contact",
    r"twice diffracted": "higher-order diffraction",
    r"reads a walker": "range-Doppler bias",
    r"half its breadth|target's breadth": "width",
    r"heard whole": "detected",
    r"whole walks": "walks, clusters",
    r"\bsilences\b": "rejects, mutes, true negatives; TPR at TNR",
    r"\bthe (swing|surge)\b|\bsurges\b": "pitch oscillation, fore-aft oscillation",
    r"cannot be told|can be told": "not significant, inconclusive",
    r"by way of": "via, through",
    r"\blifts?\b": "pitch, given or estimated; clearance, offset",
    r"\bheard\b|\bhears?\b|\blisten(s|ed|ing|er)?\b": "detected, received, recorded, audible",
    r"\bways\b": "paths, pairs of images, segments",
}
"""What is not written, and what is instead."""
IN_THE_SIMULATOR = {
    r"\bturned\b": "rotated, rejected",
    r"\blegs?\b": "segments of a path",
    r"\bas a whole\b|\bheard_whole\b": "name the sum or the set",
}
"""The same, of `simulator` and the pages about it: obstacles have legs and persons are turned to."""


def written(folders: Sequence[str]) -> Iterator[Path]:
    """The pages, and every file of some folders with words for people."""
    yield from (ROOT / page for page in PAGES)
    for folder in folders:
        yield from (path for path in (ROOT / folder).rglob("*") if path.suffix in SUFFIXES)


def lines_with(pattern: str, paths: Iterable[Path]) -> list[str]:
    """Where a pattern stands, "file:line: text"."""
    return [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in paths
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if re.search(pattern, line, re.IGNORECASE)
    ]


def test_there_are_files_to_read():
    assert len(list(written(PACKAGES))) > 300


@pytest.mark.parametrize("pattern", EVERYWHERE)
def test_the_project_speaks_the_field_s_words(pattern):
    found = lines_with(pattern, written([*PACKAGES, "docs"]))
    assert not found, f"write: {EVERYWHERE[pattern]}\n" + "\n".join(found)


@pytest.mark.parametrize("pattern", IN_THE_SIMULATOR)
def test_the_simulator_speaks_them_more_strictly(pattern):
    found = lines_with(pattern, [*(ROOT / "simulator").rglob("*.py"), ROOT / "docs" / "physics.md"])
    assert not found, f"write: {IN_THE_SIMULATOR[pattern]}\n" + "\n".join(found)
