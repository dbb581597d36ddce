"""Help answers at once: a command imports what it works with when it runs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
SLOW = ("numba", "scipy", "pandas", "pydantic", "trimesh", "shapely", "matplotlib", "joblib")
ASK_ALL = f"""
import sys
from click.testing import CliRunner
from benchmarks.cli import COMMANDS, cli
for name in COMMANDS:
    done = CliRunner().invoke(cli, [name, "--help"])
    assert done.exit_code == 0, name
    assert "Options:" in done.output, name
    print(name, *(module for module in {SLOW} if module in sys.modules))
"""


def test_no_command_s_help_waits_for_a_slow_import() -> None:
    """Each help but those of `ls` and `history` took two seconds of imports."""
    done = subprocess.run([sys.executable, "-c", ASK_ALL], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 17
    assert [line for line in lines if " " in line] == []
