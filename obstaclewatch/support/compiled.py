"""How loops are compiled: in one way, and to machine code only where Python calls them.

numba gives each function machine code, two wrappers and a place in its store, and then compiles its body once more into
every caller. Most functions here are called by others alone: these hand their intermediate code to their callers, which
is a quarter less work. numba also compiles its own parts, such as `np.empty` and `max`, anew for callers with other
options: there is one set.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

from numba.core import event, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import AnalysisPass, register_pass
from numba.core.dispatcher import Dispatcher
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import AnnotateTypes

GARBAGE = 100_000
"""New objects after which Python looks for garbage while numba compiles; its own 700 cost an eighth of that time."""
OPTIONS = {"nopython": True, "error_model": "numpy", "no_cfunc_wrapper": True}
"""Divisions are those of numpy, which do not raise: a check before each would keep loops from being vectorised."""

Function = TypeVar("Function", bound=Callable[..., Any])


class _ForCallers(JITCodeLibrary):
    """Intermediate code to be linked into callers, which optimise it with their own."""

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, _name: str) -> int:
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> _ForCallers:
        """Who is asked to place what only wrappers read."""
        return self

    def set_env(self, _name: str, _environment: Any) -> None:
        """There are no wrappers."""


@register_pass(mutates_CFG=False, analysis_only=True)
class _WithoutMachineCode(AnalysisPass):
    _name = "without_machine_code"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        state.flags.no_cpython_wrapper = True
        state.library = _ForCallers(state.targetctx.codegen(), state.func_id.func_qualname)
        return False


class _CompilerForCallers(CompilerBase):
    def define_pipelines(self) -> list[Any]:
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(_WithoutMachineCode, AnnotateTypes)
        passes.finalize()
        return [passes]


class _Called(CPUDispatcher):
    """A function as other compiled functions call it; constants are numbers like any, not types of their own."""

    def get_call_template(self, args: Any, kws: Any) -> Any:
        plain = {name: types.unliteral(value) for name, value in dict(kws).items()}
        return super().get_call_template(tuple(types.unliteral(value) for value in args), plain)


class _Kernel(CPUDispatcher):
    """A function as Python calls it."""

    @cached_property
    def called(self) -> _Called:
        return _Called(self.py_func, targetoptions=self.targetoptions, pipeline_class=_CompilerForCallers)

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.called)


def compiled(function: Function) -> Dispatcher[Function]:
    """Decorator for a function of arrays and numbers; what Python calls is stored, see `compile_cache`."""
    kernel: Any = _Kernel(function, targetoptions=dict(OPTIONS))
    kernel.enable_caching()
    return kernel  # type: ignore[no-any-return]


def inlined(function: Function) -> Dispatcher[Function]:
    """The same for what compiled functions alone call, and is to be put into these whatever its length."""
    kernel: Any = _Kernel(function, targetoptions=OPTIONS | {"forceinline": True})
    return kernel  # type: ignore[no-any-return]


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
