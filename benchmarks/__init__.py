"""Suites, runs, scores, figures and the command line: detectors on simulated recordings against ground truth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from benchmarks.bench import run as run

__all__ = ["run"]


def __getattr__(name: str) -> Any:
    """`run` is imported when it is asked for, so that the command line answers at once."""
    if name == "run":
        from benchmarks.bench import run

        return run
    raise AttributeError(f"module 'benchmarks' has no attribute '{name}'")
