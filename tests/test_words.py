"""The field's words: what the project writes for people to read keeps to them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("benchmarks",)
SUFFIXES = (".py", ".md", ".yaml", ".j2")
INSTEAD = {
    r"left in peace|leaves? .{0,40}in peace|in peace": "no alert, true negative (TN)",
    r"turned away": "rejected",
    r"\bsilences\b": "rejects, mutes, true negatives",
    r"\byardstick": "reference",
    r"\blift\b|\blifts\b": "pitch, given or estimated",
    r"\bthe (swing|surge)\b|\bsurges\b": "pitch oscillation, fore-aft oscillation",
    r"\bwall ends\b": "passed walls",
    r"\bheard\b|\bhears?\b|\blisten(s|ed|ing)?\b": "detected, received, recorded, audible",
    r"\bways of (the )?(sound|echo)|\bway left\b|of way before": "paths, distance to contact",
    r"twice diffracted": "higher-order diffraction",
    r"at \d+ % of true silences": "TPR at TNR",
    r"reads a walker": "range-Doppler bias",
    r"\bthe breadth\b|half its breadth|target's breadth": "width",
    r"cannot be told|can be told": "not significant, inconclusive",
    r"whole walks": "walks, clusters",
}
"""What is not written, and what is instead."""


def written() -> list[Path]:
    """Every file for people, or with words for them."""
    found = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.suffix in SUFFIXES]
    assert len(found) > 100
    return found


@pytest.mark.parametrize("pattern", INSTEAD)
def test_the_project_speaks_the_field_s_words(pattern):
    lines = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in written()
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if re.search(pattern, line, re.IGNORECASE)
    ]
    assert not lines, f"write: {INSTEAD[pattern]}\n" + "\n".join(lines)
