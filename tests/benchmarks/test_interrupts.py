"""Ctrl-C is never lost."""

from __future__ import annotations

import signal
import time
from functools import partial
from typing import Any

import pytest

from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.interrupts import Terminated, interruptible, raise_swallowed
from benchmarks.runs.executors.work import done_by
from tests.benchmarks.fake_cells import fake_plan

SWALLOWS = """
import signal
try:
    signal.raise_signal(signal.SIGINT)
except BaseException as error:
    swallowed = error
"""


def test_ctrl_c_within_the_import_of_trimesh_comes_right_after():
    """trimesh takes any exception within an optional import for a missing package: Ctrl-C 0.7 s after the start of a
    command was lost, and the command ran to its end. It must wake a command that waits, too: it came as the wait ended.
    """
    module: dict[str, Any] = {"__name__": "trimesh.creation"}
    before_s = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        _import_and_go_on(module)
    assert time.monotonic() - before_s < 5.0
    assert "swallowed" not in module


@interruptible()
def _import_and_go_on(module: dict[str, Any]) -> None:
    exec(compile(SWALLOWS, "creation.py", "exec"), module)
    time.sleep(10.0)


def test_ctrl_c_elsewhere_comes_at_once():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), interruptible():
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


def _hands_back_a_result(_: object, number: int, lost: bool = False) -> dict[str, Any]:
    """As a compiled function does at which a signal comes as it hands back its result."""
    try:
        signal.raise_signal(number)
    except KeyboardInterrupt as error:
        if not lost:
            raise SystemError("CPUDispatcher(...) returned a result with an exception set") from error
    return {}


@pytest.mark.parametrize(("number", "raised"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)])
def test_what_a_compiled_function_makes_of_a_signal_is_that_signal(number, raised):
    """12 in 100 came so. A run took it for a cell that failed, tried it again and went on to its report. 1 in 100 was
    lost, and comes once the cell is done."""
    with pytest.raises(raised), interruptible():
        _hands_back_a_result(None, number)
    (cell,) = fake_plan(1)
    for lost in (False, True):
        with pytest.raises(raised), interruptible():
            done_by(cell, source_fingerprint(), partial(_hands_back_a_result, number=number, lost=lost))


def test_any_other_system_error_stays():
    with pytest.raises(SystemError), interruptible():
        raise SystemError


def test_a_signal_is_over_with_the_command_that_it_ended():
    with pytest.raises(KeyboardInterrupt), interruptible():
        signal.raise_signal(signal.SIGINT)
    raise_swallowed()
