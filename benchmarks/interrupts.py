"""Ctrl-C while libraries are imported."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

AGAIN_S = 0.05
DEAF = "trimesh"
"""Takes whatever ends the import of an optional package for the package's absence, Ctrl-C as well."""


@contextmanager
def kept_interrupts() -> Iterator[None]:
    """Ctrl-C raises KeyboardInterrupt, but during the import of trimesh, which swallows it: then right after.

    >>> with kept_interrupts():
    ...     import trimesh
    """
    before = signal.signal(signal.SIGINT, _interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _interrupt(_number: int, frame: FrameType | None) -> None:
    if not _within_import(frame):
        raise KeyboardInterrupt
    again = threading.Timer(AGAIN_S, signal.raise_signal, [signal.SIGINT])
    again.daemon = True
    again.start()


def _within_import(frame: FrameType | None) -> bool:
    """Whether a module of trimesh is being executed as a whole."""
    while frame is not None:
        if frame.f_code.co_name == "<module>" and str(frame.f_globals.get("__name__")).partition(".")[0] == DEAF:
            return True
        frame = frame.f_back
    return False
