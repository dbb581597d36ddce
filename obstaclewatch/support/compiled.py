"""How loops are compiled: in one way, so that what numba itself adds to them is compiled once for all.

numba compiles its own parts, such as `np.empty` and `max`, anew for callers with other options.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any, Protocol, TypeVar

import numba
from numba.core import event
from numba.core.dispatcher import Dispatcher

import obstaclewatch.support.compile_cache  # noqa: F401  before any function is compiled

GARBAGE = 100_000
"""New objects after which Python looks for garbage while numba compiles; its own 700 cost an eighth of that time."""

Function = TypeVar("Function", bound=Callable[..., object])


class _Decorator(Protocol):
    def __call__(self, function: Function, /) -> Dispatcher[Function]: ...


WITHOUT_C: dict[str, Any] = {"no_cfunc_wrapper": True}
"""Nobody calls these from C: a tenth of the time. numba's types do not know this option."""

compiled: _Decorator = numba.njit(cache=True, error_model="numpy", **WITHOUT_C)
"""Decorator for a function of arrays and numbers; it is kept for the next start (`compile_cache`).

Divisions are those of numpy, which do not raise: a check before each would keep loops from being vectorised.
"""

inlined: _Decorator = numba.njit(cache=True, error_model="numpy", inline="always", **WITHOUT_C)
"""The same for what compiled functions alone call, at one place or with few lines: it is compiled as part of these.

A function of its own is typed, optimised and stored before its callers, and optimised once more within each.
"""

fused: _Decorator = numba.njit(cache=True, error_model="numpy", fastmath={"contract"}, **WITHOUT_C)
"""`compiled`, but a product and a sum may be one instruction, rounded once: a third of the time of long formulas."""

fused_inline: _Decorator = numba.njit(
    cache=True, error_model="numpy", fastmath={"contract"}, inline="always", **WITHOUT_C
)
"""`inlined` into `fused` functions."""


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
