"""What a run cost, where it ran, and how to run it again. What is not known is said to be unknown."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.cells.spec import BeepSetting
from benchmarks.figures.measured import significant
from benchmarks.figures.paper.energies import cpu_per_beep_s
from benchmarks.report.cases import UNKNOWN
from benchmarks.runs.results import RunData

Lines = list[tuple[str, str]]


def cost_lines(run: RunData) -> Lines:
    """Times and memory summed over the cells whose cost is known."""
    known = [(record, cost) for record, cost in zip(run.cells, run.costs, strict=False) if cost]
    if not known:
        return [("cost", UNKNOWN)]
    recorded = sum(cost["recording_s"] for _, cost in known)
    total = sum(cost["total_s"] for _, cost in known)
    beeps = sum(cost["recording_s"] / BeepSetting(**record["cell"]["beep"]).period_s for record, cost in known)
    lines = [
        ("cells with a known cost", f"{len(known)} of {len(run.cells)}"),
        ("sound simulated", f"{recorded:.0f} s, {beeps:.0f} beeps"),
        ("computing time", f"{total:.0f} s over all processes, {recorded / total:.2f} times real time"),
        ("simulation", f"{_per_cell([cost['simulate_s'] for _, cost in known])}"),
    ]
    for name in sorted({name for _, cost in known for name in cost["detect_s"]}):
        spent = 1e3 * cpu_per_beep_s(run, name)
        text = f"{significant(float(np.median(spent)))} ms a beep, median over walks" if len(spent) else UNKNOWN
        lines.append((f"processor time of detection, {name}", text))
    memory = [cost["peak_rss_mb"] for _, cost in known if "peak_rss_mb" in cost]
    return [*lines, ("memory of a process, at most", f"{max(memory):.0f} MB" if memory else UNKNOWN)]


def environment_lines(manifest: Mapping[str, Any]) -> Lines:
    """Source, machine and versions."""
    versions = manifest.get("versions") or {}
    return [
        ("suite", _shown(manifest, "suite")),
        ("tier, split, seed", ", ".join(_shown(manifest, key) for key in ("tier", "split", "seed"))),
        ("started", _shown(manifest, "started")),
        ("git revision", _revision(manifest)),
        ("source fingerprint", _shown(manifest, "source_sha256")),
        ("platform", _shown(manifest, "platform")),
        ("processor", _shown(manifest, "cpu")),
        ("packages", ", ".join(f"{k} {UNKNOWN if v is None else v}" for k, v in sorted(versions.items())) or UNKNOWN),
    ]


def reproduction_command(manifest: Mapping[str, Any]) -> str:
    """The run's own command line."""
    argv = manifest.get("argv")
    return shlex.join(["obstaclewatch", *argv]) if argv else UNKNOWN


def _shown(manifest: Mapping[str, Any], key: str) -> str:
    value = manifest.get(key)
    return UNKNOWN if value is None else str(value)


def _revision(manifest: Mapping[str, Any]) -> str:
    dirty = manifest.get("git_dirty")
    if dirty is None:
        return f"{_shown(manifest, 'git_revision')}, changes unknown"
    return _shown(manifest, "git_revision") + (", with uncommitted changes" if dirty else "")


def _per_cell(seconds: list[float]) -> str:
    middle, upper = np.quantile(seconds, [0.5, 0.95])
    return f"median {middle:.2f} s a cell, 95 % within {upper:.2f} s"
