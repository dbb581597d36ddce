"""Ctrl-C, SIGTERM and closed output while a command runs."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TextIO

AGAIN_S = 0.05
DEAF = "trimesh"
"""Takes whatever ends the import of an optional package for the package's absence, Ctrl-C as well."""


class Terminated(KeyboardInterrupt):
    """SIGTERM, as `timeout`, a CI that gives up or a batch system sends it: the end is that of Ctrl-C."""


_raised: list[type[KeyboardInterrupt]] = []
"""What came within `interruptible`."""


@contextmanager
def interruptible() -> Iterator[None]:
    """Ctrl-C raises KeyboardInterrupt, also where the import of trimesh swallows it, and SIGTERM raises `Terminated`.

    What a caller does at SIGTERM remains; a second SIGTERM ends the process at once. Where either comes as a compiled
    function hands back its result, Python makes a SystemError of it, which is taken for what it was, or nothing at all:
    1 in 100 is lost so, and `raise_swallowed` finds it.

    >>> with interruptible():
    ...     import trimesh
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    at_interrupt, at_end = signal.signal(signal.SIGINT, _interrupt), signal.getsignal(signal.SIGTERM)
    if at_end == signal.SIG_DFL:
        signal.signal(signal.SIGTERM, _terminate)
    try:
        yield
    except SystemError:
        raise_swallowed()
        raise
    finally:
        signal.signal(signal.SIGINT, at_interrupt)
        if at_end == signal.SIG_DFL:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
        _raised.clear()


def tell(text: str, stream: TextIO | None = None) -> None:
    """Print where what is done must go on though nobody reads it any more, as after `| head`: then it is lost.

    Args:
        stream: standard output unless given.

    >>> tell("3 cells")
    3 cells
    """
    chosen = sys.stdout if stream is None else stream
    try:
        print(text, file=chosen, flush=True)
    except BrokenPipeError:
        mute(chosen)


def mute(stream: TextIO) -> None:
    """Have a stream go nowhere whose reader has closed it: what is buffered would fail once more at the end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def raise_swallowed() -> None:
    """Raise the Ctrl-C or SIGTERM that came: for those who are still at work, and have not seen it.

    >>> raise_swallowed()
    """
    if _raised:
        raise _raised[-1]


def _terminate(_number: int, _frame: FrameType | None) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _raised.append(Terminated)
    raise Terminated


def _interrupt(_number: int, frame: FrameType | None) -> None:
    if not _within_import(frame):
        _raised.append(KeyboardInterrupt)
        raise KeyboardInterrupt
    # To the main thread: a signal that another one raises does not wake it where it waits.
    again = threading.Timer(AGAIN_S, signal.pthread_kill, [threading.main_thread().ident, signal.SIGINT])
    again.daemon = True
    again.start()


def _within_import(frame: FrameType | None) -> bool:
    """Whether a module of trimesh is being executed as a whole."""
    while frame is not None:
        if frame.f_code.co_name == "<module>" and str(frame.f_globals.get("__name__")).partition(".")[0] == DEAF:
            return True
        frame = frame.f_back
    return False
