"""What all tests share: threads, compiled modules, and the order of the folders.

A process has one thread of linear algebra: tests run beside each other, and threads that wait for each other burn CPU.
On two busy cores products of small matrices on two threads cost six times the CPU of one. The libraries read these
settings when numpy is first imported, which is after this file.

Where Python is told to keep no compiled modules beside the sources, as in many containers, they are kept in pytest's
own cache. Else each worker, and each process that a test starts, compiles all libraries anew: 5 s instead of 1.6.
"""

import gc
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    sys.dont_write_bytecode = False
    sys.pycache_prefix = str(Path(__file__).parents[1] / ".pytest_cache" / "modules")
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix


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
