"""Commands whose output nobody reads."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def unread(*words: str, stderr_too: bool = False) -> tuple[int, str]:
    """Exit code and standard error of a command whose output nobody reads."""
    reader, writer = os.pipe()
    os.close(reader)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "benchmarks.cli", *words],
            cwd=ROOT, stdout=writer, stderr=writer if stderr_too else subprocess.PIPE, text=True,
        )  # fmt: skip
    finally:
        os.close(writer)
    return done.returncode, done.stderr or ""
