"""What all tests share: threads, kept walks, and the order of the folders.

A process has one thread of linear algebra: tests run beside each other, and threads that wait for each other burn CPU.
On two busy cores products of small matrices on two threads cost six times the CPU of one. The libraries read these
settings when numpy is first imported, which is after this file.
"""

import gc
import os
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import pytest

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

KEPT_WALKS = 16


@pytest.fixture(scope="session")
def kept_walks() -> Callable[[str], Any]:
    """What simulates a walk, and keeps the last ones instead of the very last."""
    from benchmarks.cells import compute

    return lru_cache(maxsize=KEPT_WALKS)(compute._simulated.__wrapped__)


@pytest.fixture
def walks_once(kept_walks: Callable[[str], Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """For pages that run the same walks of the paper's suite, and their reports, which play them once more."""
    monkeypatch.setattr("benchmarks.cells.compute._simulated", kept_walks)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Without a search for garbage among millions of new objects, of which all stay: a sixth of collection's time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


FIRST = ("benchmarks", "fuzz", "obstaclewatch", "scenes", "docs")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Folders in this order, the rest after them.

    Two workers begin at the first and in the middle, and share what is left near either's end. Single tests of pages
    take half a minute: they come after others have compiled what they need, and before many that are short.
    """
    place = {Path(__file__).parent / name: number for number, name in enumerate(FIRST)}
    items.sort(key=lambda item: min((place[up] for up in item.path.parents if up in place), default=len(place)))
