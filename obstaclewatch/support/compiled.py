"""How loops are compiled: in one way, so that what numba itself adds to them is compiled once for all.

numba compiles its own parts, such as `np.empty` and `max`, anew for callers with other options.
"""

from __future__ import annotations

import gc
from typing import Any

import numba
from numba.core import event

GARBAGE = 100_000
"""New objects after which Python looks for garbage while numba compiles; its own 700 cost an eighth of that time."""

compiled = numba.njit(cache=True, error_model="numpy")
"""Decorator for a function of arrays and numbers; it is kept for the next start (`compile_cache`).

Divisions are those of numpy, which do not raise: a check before each would keep loops from being vectorised.
"""

inlined = numba.njit(cache=True, error_model="numpy", forceinline=True)
"""The same for what compiled functions alone call, and is to be put into these whatever its length."""


class _RareCollections(event.TimingListener):
    """Asks Python to collect garbage rarely while something is compiled, and as before afterwards."""

    def __init__(self) -> None:
        super().__init__()
        self._running = 0
        self._usual = gc.get_threshold()

    def on_start(self, _event: Any) -> None:
        if self._running == 0:
            self._usual = gc.get_threshold()
            if 0 < self._usual[0] < GARBAGE:
                gc.set_threshold(GARBAGE, *self._usual[1:])
        self._running += 1

    def on_end(self, _event: Any) -> None:
        self._running -= 1
        if self._running == 0:
            gc.set_threshold(*self._usual)


event.register("numba:compile", _RareCollections())
