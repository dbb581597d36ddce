"""What made a run: command, plan, source, versions, machine."""

from __future__ import annotations

import os
import platform
import subprocess
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.cells.spec import Cell
from benchmarks.suite import Suite

PACKAGES = ("numpy", "scipy", "numba", "trimesh", "embreex", "joblib", "matplotlib", "pydantic", "soundfile")
ROOT = Path(__file__).resolve().parents[1]


def manifest(suite: Suite, tier: str, cells: Sequence[Cell], argv: Sequence[str]) -> dict[str, Any]:
    """Provenance of a run, ready for JSON. A revision or version that cannot be told is null.

    `plan` lists the digests of the run's cells in order.
    """
    source = source_fingerprint()
    revision, status = _git("rev-parse", "HEAD"), _git("status", "--porcelain")
    return {
        "argv": ["obstaclewatch", *argv],
        "suite": suite.name,
        "title": suite.title,
        "tier": tier,
        "split": suite.split,
        "seed": suite.seed,
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "source": source,
        "git_revision": revision,
        "git_dirty": None if status is None else bool(status),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cpu": _cpu(),
        "cpus": os.cpu_count(),
        "versions": {name: _version(name) for name in PACKAGES},
        "plan": [cell.digest(source) for cell in cells],
    }


def _git(*arguments: str) -> str | None:
    try:
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, timeout=10, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _cpu() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.is_file() else []
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())
