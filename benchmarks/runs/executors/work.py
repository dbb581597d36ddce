"""What a worker does with one cell: compute it, and hand back the text of its record and of its cost."""

from __future__ import annotations

import json
import resource
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.cells.spec import Cell
from benchmarks.interrupts import raise_swallowed
from benchmarks.runs.store import to_json
from benchmarks.runs.stored import StoredCell, check_stored

Work = Callable[[Cell], dict[str, Any]]
"""From a cell to its numbers; `benchmarks.cells.compute.compute` outside of tests."""


@dataclass(frozen=True)
class Done:
    """One cell, computed.

    Attributes:
        digest: the cell's name.
        ok: whether it was computed without an error.
        record: JSON text of its record; the same bytes whoever computed it.
        cost: JSON text of what it cost; None for a failed one.
    """

    digest: str
    ok: bool
    record: str
    cost: str | None


Task = Callable[[Cell], Done]


class WorkersLost(RuntimeError):
    """Worker processes died, killed or out of memory, before their cells were done."""


def done_by(cell: Cell, version: str, work: Work) -> Done:
    """Compute one cell. What goes wrong inside becomes part of its record, with the traceback.

    Raises:
        ValueError: this process has another version of the source than the plan.
        KeyboardInterrupt: it came while the cell was computed, whatever became of it there.
    """
    if source_fingerprint() != version:
        raise ValueError(
            f"workers must have the plan's source {version[:12]}, but one has {source_fingerprint()[:12]}: "
            "install the same version everywhere and restart the workers"
        )
    digest = cell.digest(version)
    record: dict[str, Any] = {"digest": digest, "label": cell.label, "cell": cell.model_dump(mode="json")}
    try:
        result = work(cell)
        raise_swallowed()
        cost = result.pop("cost") | {"peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0}
        text = to_json(record | {"status": "ok", "result": result, "error": None})
        check_stored(json.loads(text), StoredCell, "a detector's result must be such as a run stores")
    except (Exception, SystemExit):  # whatever went wrong belongs in the record, and the other cells go on
        raise_swallowed()
        record |= {"status": "failed", "result": None, "error": traceback.format_exc()}
        return Done(digest, False, to_json(record), None)
    return Done(digest, True, text, to_json(cost))
