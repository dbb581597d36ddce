"""One cell, whatever happens: its numbers, or the traceback of what went wrong."""

from __future__ import annotations

import math
import resource
import traceback
from typing import Any

from benchmarks.cells.spec import Cell


def attempt(cell: Cell, digest: str) -> dict[str, Any]:
    """The record of one cell, ready for JSON: NaN becomes null.

    Only `cost` may differ between two computations of the same cell.
    """
    record: dict[str, Any] = {"digest": digest, "cell": cell.model_dump(mode="json")}
    try:
        from benchmarks.cells.compute import compute

        numbers = compute(cell)
    except Exception as error:  # recorded, counted and shown; the other cells go on
        record |= {"status": "failed", "error": f"{type(error).__name__}: {error}", "traceback": traceback.format_exc()}
        return record
    cost = numbers.pop("cost") | {"peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0}
    return record | {"status": "ok", "numbers": nulled(numbers), "cost": nulled(cost)}


def nulled(value: Any) -> Any:
    """The same nested value with None for floats that are not finite; JSON has no NaN."""
    if isinstance(value, dict):
        return {key: nulled(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [nulled(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
