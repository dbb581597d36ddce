"""How a run came about: what was asked, with which source, on which machine."""

from __future__ import annotations

import os
import platform
import subprocess
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from benchmarks.cells.fingerprint import ROOT, source_fingerprint
from benchmarks.cells.spec import Cell
from benchmarks.plan.cells import plan_digest
from benchmarks.plan.suite import Suite

PACKAGES = ("numpy", "scipy", "trimesh", "embreex", "numba", "soundfile", "joblib", "pydantic", "matplotlib")


def manifest(suite: Suite, tier: str, cells: Sequence[Cell], argv: Sequence[str]) -> dict[str, Any]:
    """Everything needed to say what a run measured and to repeat it; null where it cannot be known."""
    fingerprint = source_fingerprint()
    status = _git("status", "--porcelain", "--untracked-files=no")
    return {
        "argv": [os.fsencode(word).decode("utf-8", "replace") for word in argv],  # as in a locale without UTF-8
        "suite": suite.name,
        "title": suite.title,
        "tier": tier,
        "seed": suite.seed,
        "split": suite.split,
        "detectors": list(suite.detectors),
        "fidelity": suite.fidelity,
        "figures": list(suite.figures),
        "plan_sha256": plan_digest(cells, fingerprint),
        "source_sha256": fingerprint,
        "plan": [cell.digest(fingerprint) for cell in cells],
        "git_revision": _git("rev-parse", "HEAD"),
        "git_dirty": None if status is None else bool(status),
        "versions": {"python": platform.python_version()} | {name: _version(name) for name in PACKAGES},
        "platform": f"{platform.system()} {platform.machine()}",
        "cpu": _cpu(),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def other_source(run: Mapping[str, Any]) -> str | None:
    """What to say of a run that another version of the source measured, by its manifest; None of today's."""
    here = source_fingerprint()
    if run["source_sha256"] == here:
        return None
    measured = _version_text(run["git_revision"], run["source_sha256"])
    return f"the run was measured by {measured}; today's is {_version_text(_git('rev-parse', 'HEAD'), here)}"


def _version_text(revision: str | None, fingerprint: str) -> str:
    """ "revision 50e8da1 (source 0f3a9c1b2d)"."""
    return f"revision {revision[:7] if revision else 'unknown'} (source {fingerprint[:10]})"


def options_in(argv: Sequence[str], *names: str) -> list[str]:
    """The options of these names on a command line, each with its value: "--name=value" and "-nvalue" as two words."""
    kept: list[str] = []
    words = iter(argv)
    for word in words:
        for name in names:
            long = name.startswith("--")
            if word == name:
                kept += [name, next(words, "")]
            elif word.startswith(f"{name}=" if long else name):
                kept += [name, word[len(name) + long :]]
    return kept


def _git(*arguments: str) -> str | None:
    try:
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return done.stdout.strip()


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{len(models)} x {models[0]}" if models else platform.machine()
