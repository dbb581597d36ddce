"""Stored compiled functions go by all their sources: an update of a file that others compile into theirs is heard."""

from __future__ import annotations

import ast
import importlib
import os
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

import obstaclewatch
from obstaclewatch.support.compile_cache import PACKAGES, SourcesLocator, sources, sources_stamp

ROOT = Path(obstaclewatch.__file__).parents[1]
CALLER = (
    "import numba\nfrom scenes import callee\n\n@numba.njit(cache=True)\ndef doubled():\n    return 2 * callee.one()\n"
)
CALLEE = "import numba\n\n@numba.njit(cache=True)\ndef one():\n    return {}\n"
OF_A_CLASS = CALLER.replace("doubled()", "doubled(pair)").replace("callee.one()", "pair.one")
A_CLASS = "from typing import NamedTuple\n\nclass {0}(NamedTuple):\n    one: int\n\ndef made():\n    return {0}(5)\n"
SCRIPT = (
    "import obstaclewatch.support.compile_cache\nfrom scenes.caller import doubled\n"
    "print(doubled(), sum(doubled.stats.cache_hits.values()))"
)


def test_an_update_of_what_is_called_from_another_file_is_heard(tmp_path):
    """numba alone answers 2 after the update: it compares the caller's file, and that one is the same."""
    (tmp_path / "scenes").mkdir()
    for name, text in {"__init__": "", "caller": CALLER, "callee": CALLEE.format(1)}.items():
        (tmp_path / "scenes" / f"{name}.py").write_text(text)
    assert [_printed(tmp_path), _printed(tmp_path)] == ["2 0", "2 1"]
    (tmp_path / "scenes" / "callee.py").write_text(CALLEE.format(5))
    assert [_printed(tmp_path), _printed(tmp_path)] == ["10 0", "10 1"]


def test_an_update_that_renames_a_class_of_the_arguments_is_survived(tmp_path):
    """numba unpickled the classes of stored signatures before it looked at the stamp: AttributeError."""
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "__init__.py").write_text("")
    (tmp_path / "scenes" / "caller.py").write_text(OF_A_CLASS)
    script = SCRIPT.replace("doubled()", "doubled(callee.made())").replace("doubled\n", "callee, doubled\n")
    for name in ("Old", "New"):
        (tmp_path / "scenes" / "callee.py").write_text(A_CLASS.format(name))
        assert [_printed(tmp_path, script), _printed(tmp_path, script)] == ["10 0", "10 1"]


def test_no_place_to_store_is_one_error_that_says_what_to_do(monkeypatch):
    """Cause: installed for all, with a home that cannot be written, numba said "no locator available"."""
    monkeypatch.setattr("obstaclewatch.support.compile_cache.PLACES", ())
    with pytest.raises(OSError, match=r"beside '.*test_compile_cache\.py' .* name a folder in NUMBA_CACHE_DIR"):
        SourcesLocator.from_function(_of_the_packages, __file__)


def _of_the_packages():
    pass


_of_the_packages.__module__ = "scenes.somewhere"


def _printed(folder, script=SCRIPT):
    """Result of the caller, and how often it came from the store, in a fresh process that finds `scenes` there."""
    path = os.pathsep.join([str(folder), str(ROOT)])
    environment = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")} | {"PYTHONPATH": path}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"  # else Python takes an update of the same second and size for the old
    done = subprocess.run([sys.executable, "-c", script], cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("package", ["obstaclewatch", "simulator"])
def test_sources_are_what_modules_import(package):
    """By Python's own parser; every import that a file has is among the files that its stamp covers."""
    checked = 0
    for file in sorted((ROOT / package).rglob("*.py")):
        covered = sources(ROOT, file)
        assert file in covered
        for module in _modules_imported(file):
            checked += 1
            assert module in covered, f"{file.name} imports {module}"
            assert sources(ROOT, module) <= covered
    assert checked > 50


def _modules_imported(file):
    """Files of these packages, without their `__init__`, that a file names in any import."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.ImportFrom):
            names = [node.module, *(f"{node.module}.{name.name}" for name in node.names)]
        elif isinstance(node, ast.Import):
            names = [name.name for name in node.names]
        for name in names:
            path = ROOT.joinpath(*name.split(".")).with_suffix(".py")
            if name.partition(".")[0] in PACKAGES and path.is_file():
                yield path


def test_every_compiled_function_of_the_detector_has_such_a_stamp():
    found = 0
    for info in pkgutil.walk_packages(obstaclewatch.__path__, "obstaclewatch."):
        module = importlib.import_module(info.name)
        for value in vars(module).values():
            if isinstance(value, Dispatcher) and value.py_func.__module__ == module.__name__:
                stamp = value._cache._impl.locator.get_source_stamp()
                assert stamp == sources_stamp(ROOT, Path(module.__file__))
                found += 1
    assert found > 50


def test_functions_of_others_are_left_to_numba():
    assert SourcesLocator.from_function(ast.parse, ast.__file__) is None
