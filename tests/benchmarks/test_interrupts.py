"""Ctrl-C is never lost."""

from __future__ import annotations

import signal
import time
from typing import Any

import pytest

from benchmarks.interrupts import interruptible

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
