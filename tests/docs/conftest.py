"""What pages share that run the same suites: a walk is simulated once, and a figure drawn once."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from typing import Any

import pytest

KEPT_WALKS = 16


@pytest.fixture(scope="session")
def kept_walks() -> Callable[[str], Any]:
    """What simulates a walk, and keeps the last ones instead of the very last."""
    from benchmarks.cells import compute

    return lru_cache(maxsize=KEPT_WALKS)(compute._simulated.__wrapped__)


@pytest.fixture(scope="session")
def kept_pictures() -> tuple[Callable[[Any], Any], Callable[[Any, str], bytes]]:
    """What draws a figure and makes a file of it, once for each name: the first run's stands for those after it."""
    from benchmarks import figures
    from benchmarks.figures.draw import style

    draw, drawn = figures.picture, {}

    def picture(figure: Any) -> Any:
        return drawn.get(figure.name) or drawn.setdefault(figure.name, draw(figure))

    return picture, cache(style.picture_bytes)


@pytest.fixture
def suites_once(
    kept_walks: Callable[[str], Any],
    kept_pictures: tuple[Callable[[Any], Any], Callable[[Any, str], bytes]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """For pages that run the same walks of the paper's suite, their figures, and reports, which play them once more.

    Tables beside the figures, csv, are of each run.
    """
    monkeypatch.setattr("benchmarks.cells.compute._simulated", kept_walks)
    monkeypatch.setattr("benchmarks.figures.picture", kept_pictures[0])
    monkeypatch.setattr("benchmarks.figures.draw.style.picture_bytes", kept_pictures[1])
