"""How far a run is: a bar in a terminal, and a plain line now and then where a log is written."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from time import monotonic
from typing import Any, Protocol, Self

from tqdm import tqdm

from benchmarks.interrupts import tell

EVERY_S = 60.0
"""Between two lines at most, as long as something gets done."""
APART_S = 1.0
"""Between two lines at least."""
TENTHS = 10


class Progress(AbstractContextManager[Any], Protocol):
    """Counts what is done."""

    def update(self, count: int) -> object:
        """So many more are done; 0 where something was tried in vain."""


def progress(total: int, done: int, unit: str, shown: bool = True) -> Progress:
    """Of so many in all, of which some were done before: on stderr, or nothing at all unless `shown`.

    >>> with progress(3, done=1, unit="cell", shown=False) as bar:
    ...     bar.update(1)
    """
    if shown and not sys.stderr.isatty():
        return PlainLines(total, done, unit)
    bar: Progress = tqdm(total=total, initial=done, unit=unit, disable=not shown)
    return bar


class PlainLines:
    """A line at each tenth of the whole, and each minute.

    Args:
        total: how many there are.
        done: how many were done before.
        unit: what they are, one of them.
        say: takes the lines.
        clock: seconds, from anywhere.

    >>> at_s = iter([0.0, 60.0, 90.0])
    >>> lines = PlainLines(20, 10, "cell", say=print, clock=lambda: next(at_s))
    >>> lines.update(1)
    11 of 20 cells, 01:00 elapsed
    >>> lines.update(2)
    13 of 20 cells, 01:30 elapsed, about 01:45 left
    """

    def __init__(
        self,
        total: int,
        done: int,
        unit: str,
        say: Callable[[str], object] | None = None,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self._total, self._before, self._done, self._unit = total, done, done, unit
        self._say, self._clock = _to_stderr if say is None else say, clock
        self._begin_s = self._last_s = clock()
        self._first, self._first_s = 0, self._begin_s

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def update(self, count: int) -> None:
        """So many more are done; 0 where something was tried in vain."""
        tenth, now_s = TENTHS * self._done // self._total, self._clock()
        if count and self._done == self._before:
            self._first, self._first_s = count, now_s
        self._done += count
        since_s = now_s - self._last_s
        if since_s >= EVERY_S or (since_s >= APART_S and TENTHS * self._done // self._total > tenth):
            self._say(self._line(now_s))
            self._last_s = now_s

    def _line(self, now_s: float) -> str:
        elapsed = tqdm.format_interval(now_s - self._begin_s)
        return f"{self._done} of {self._total} {self._unit}s, {elapsed} elapsed{self._guess(now_s)}"

    def _guess(self, now_s: float) -> str:
        """From the pace since the first were done: until then code may have been compiled, which happens once."""
        new, left = self._done - self._before - self._first, self._total - self._done
        if not (new and left):
            return ""
        return f", about {tqdm.format_interval((now_s - self._first_s) * left / new)} left"


def _to_stderr(line: str) -> None:
    tell(line, sys.stderr)
