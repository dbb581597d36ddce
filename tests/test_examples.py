"""Every public name of a package has an example in its docstring, and every example prints what it says."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("obstaclewatch", "simulator", "scenes", "benchmarks")
WITH_EXAMPLES = ("obstaclewatch", "simulator", "scenes", "benchmarks")


def modules_with_examples() -> list[str]:
    """Names of all modules whose source has an example."""
    files = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]
    found = [path.relative_to(ROOT).with_suffix("") for path in files if ">>> " in path.read_text(encoding="utf-8")]
    return [".".join(path.parts).removesuffix(".__init__") for path in found]


@pytest.mark.parametrize("package", WITH_EXAMPLES)
def test_every_public_name_has_an_example(package):
    module = importlib.import_module(package)
    assert module.__all__
    names = [name for name in module.__all__ if callable(getattr(module, name))]  # a table has no docstring of its own
    assert [name for name in names if ">>> " not in (getattr(module, name).__doc__ or "")] == []


def test_there_are_examples():
    """Else the next test would pass with nothing in it."""
    assert len(modules_with_examples()) > 10


@pytest.mark.parametrize("name", modules_with_examples())
def test_examples_print_what_they_say(name):
    outcome = doctest.testmod(importlib.import_module(name), optionflags=doctest.IGNORE_EXCEPTION_DETAIL)
    assert outcome.attempted > 0
    assert outcome.failed == 0
