"""What is compiled at first use is little: each function once, for one kind of arrays, with the same options."""

import ast
import gc
import json
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numba.core import event

import obstaclewatch
from obstaclewatch.support.compile_cache import PACKAGES
from obstaclewatch.support.compiled import GARBAGE
from obstaclewatch.support.order_statistic import median, order_statistic

ROOT = Path(obstaclewatch.__file__).parents[1]
SCRIPT = """
import importlib, json, pkgutil
import numpy as np
import obstaclewatch
from numba.core.dispatcher import Dispatcher
from obstaclewatch import *
from tests.obstaclewatch.synthetic import BEEP, PHONE, Point, noise_for, recording

ground = Point(0.0, 1.35, gain=0.3, carried=True, bob_m=0.02)
walk = recording([Point(4.0, 0.05), ground], beeps=30, speed_m_s=1.3, noise=noise_for(20.0, 0.1))
for detector in (PaperDetector, DistanceOnlyDetector, TrackingDetector):
    assert any(decision.alert for decision in detector(BEEP, PHONE).run(walk))
found = {}
for info in pkgutil.walk_packages(obstaclewatch.__path__, "obstaclewatch."):
    for name, value in vars(importlib.import_module(info.name)).items():
        if isinstance(value, Dispatcher) and value.py_func.__module__ == info.name:
            found[name] = len(value.signatures), value.targetoptions
print(json.dumps(found))
"""
OF_DOUBLES = {"_about_zero": 2, "_rotated_sums": 2}
"""The replica is transformed in double precision, recordings in single."""


def _compiled(**environment):
    """By name, how many kinds of arguments each compiled function of the detectors met, and its options."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=os.environ | {"PYTHONPATH": str(ROOT)} | environment, capture_output=True
    )
    assert done.returncode == 0, done.stderr.decode()
    return json.loads(done.stdout)


def test_detectors_hand_over_one_kind_of_arrays_and_share_their_options():
    """np.concatenate made columns of single peaks, and rows of a cut envelope are not contiguous: each compiled twice.

    numba also compiles its own parts once for each set of options: half the functions took divisions that raise.
    """
    found = _compiled()
    met = {name: kinds for name, (kinds, _) in found.items() if kinds > 1}
    assert met.items() <= OF_DOUBLES.items()
    assert len({json.dumps(options | {"inline": None}, sort_keys=True) for _, options in found.values()}) == 1


@pytest.mark.slow
def test_what_is_compiled_at_first_use_is_counted(tmp_path):
    """105 kinds of arguments before helpers were compiled within their callers."""
    found = _compiled(NUMBA_CACHE_DIR=str(tmp_path))
    assert sum(kinds for kinds, _ in found.values()) <= 58


def test_garbage_is_collected_rarely_while_functions_compile_and_as_before_afterwards():
    """6 of 48 s went into looking for garbage among numba's own objects."""
    met, usual = [], gc.get_threshold()
    seen = event.RecordingListener()
    seen.on_start = lambda _event: met.append(gc.get_threshold()[0])
    with event.install_listener("numba:compile", seen):
        assert numba.njit(lambda x: x + 1)(1) == 2
    assert met == [GARBAGE]
    assert gc.get_threshold() == usual


def _statements(function):
    return sum(isinstance(node, ast.stmt) for node in ast.walk(function)) - 1


def test_what_is_inlined_is_short_or_called_at_one_place():
    """Else callers would compile it over and over."""
    sources = {
        path: path.read_text(encoding="utf-8") for name in PACKAGES for path in sorted((ROOT / name).rglob("*.py"))
    }
    functions = [
        (path, node, {getattr(mark, "id", None) for mark in node.decorator_list})
        for path, source in sources.items()
        if any(f"@{mark}" in source for mark in ("compiled", "inlined"))
        for node in ast.parse(source).body
        if isinstance(node, ast.FunctionDef)
    ]
    called = Counter(
        (path, getattr(call.func, "id", getattr(call.func, "attr", None)))
        for path, node, marks in functions
        if marks & {"compiled", "inlined"}
        for call in ast.walk(node)
        if isinstance(call, ast.Call)
    )
    inlined = [(path, node) for path, node, marks in functions if "inlined" in marks]
    assert len(inlined) > 50
    long = [(path, node.name) for path, node in inlined if _statements(node) > 10]
    assert [place for place in long if called[place] > 1] == []


@settings(deadline=None)
@given(arrays(np.float64, st.integers(1, 40), elements=st.integers(0, 9).map(float)), st.data())
def test_order_statistics_are_those_of_sorted_numbers(values, data):
    rank = data.draw(st.integers(0, len(values) - 1))
    given_values = values.copy()
    assert order_statistic(values, rank) == np.sort(values)[rank]
    assert median(values) == np.median(values)
    np.testing.assert_array_equal(values, given_values)
