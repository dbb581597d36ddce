"""The field's words: what the project writes for people to read keeps to them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("benchmarks", "scenes", "simulator", "obstaclewatch")
SUFFIXES = (".py", ".md", ".yaml", ".j2")
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
}
"""What is not written, and what is instead."""
IN_BENCH_AND_SCENES = {
    r"\bsilences\b": "rejects, mutes, true negatives; TPR at TNR",
    r"\blifts?\b": "pitch, given or estimated",
    r"\bthe (swing|surge)\b|\bsurges\b": "pitch oscillation, fore-aft oscillation",
    r"\bheard\b|\bhears?\b|\blisten(s|ed|ing)?\b": "detected, received, recorded, audible",
    r"cannot be told|can be told": "not significant, inconclusive",
}
"""The same, of `benchmarks` and `scenes` alone: the other packages and the pages still have them."""


def written(folders: Sequence[str]) -> Iterator[Path]:
    """Every file of some folders with words for people."""
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
    found = lines_with(pattern, [ROOT / "README.md", *written([*PACKAGES, "docs"])])
    assert not found, f"write: {EVERYWHERE[pattern]}\n" + "\n".join(found)


@pytest.mark.parametrize("pattern", IN_BENCH_AND_SCENES)
def test_bench_and_scenes_speak_them_more_strictly(pattern):
    found = lines_with(pattern, written(["benchmarks", "scenes"]))
    assert not found, f"write: {IN_BENCH_AND_SCENES[pattern]}\n" + "\n".join(found)
