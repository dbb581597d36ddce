"""What made a run: command, source, versions, machine."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = ("numpy", "scipy", "numba", "trimesh", "embreex", "joblib", "matplotlib", "pydantic", "soundfile")
ROOT = Path(__file__).resolve().parents[1]


def manifest(plan_digest: str, fingerprint: str, seed: int, cells: int, jobs: int, executor: str) -> dict[str, Any]:
    """Provenance of a run, ready for JSON. Versions not installed and an unknown revision are null."""
    return {
        "argv": ["obstaclewatch", *sys.argv[1:]],
        "plan": plan_digest,
        "source": fingerprint,
        "seed": seed,
        "cells": cells,
        "executor": executor,
        "jobs": jobs,
        "git": git_state(),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cpu": _cpu_model(),
        "cpus": os.cpu_count(),
        "versions": {name: _version(name) for name in PACKAGES},
    }


def git_state() -> dict[str, Any]:
    """Revision of the source and whether it was changed since; nulls outside a repository."""
    revision = _git("rev-parse", "HEAD")
    status = _git("status", "--porcelain")
    return {"revision": revision, "dirty": None if status is None else bool(status)}


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


def _cpu_model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())
