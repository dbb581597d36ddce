"""Help answers at once: a command imports what it works with when it runs."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from benchmarks.cli import COMMANDS, EXAMPLES, cli

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


def test_the_package_is_a_command() -> None:
    """Cause: `python -m benchmarks` said that the package cannot be executed."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "ls", "suites"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "paper" in done.stdout
    wrong = subprocess.run([sys.executable, "-m", "benchmarks", "run"], cwd=ROOT, capture_output=True, text=True)
    assert wrong.returncode == 2


@pytest.mark.parametrize("example", [example for name in COMMANDS for example in EXAMPLES[name]])
def test_examples_at_the_end_of_help_are_commands(example: str) -> None:
    command, words, context = cli, shlex.split(example), click.Context(cli)
    while isinstance(command, click.Group):
        _, command, words = command.resolve_command(context, words)
    assert command is not None
    command.make_context("obstaclewatch", list(words))


def test_help_ends_with_examples() -> None:
    for name in COMMANDS:
        text = cli.get_command(click.Context(cli), name).get_help(click.Context(cli))
        assert text.endswith(f"  obstaclewatch {EXAMPLES[name][-1]}")


def test_validate_says_which_command_checks_scenes(tmp_path: Path) -> None:
    path = tmp_path / "yard.yaml"
    path.write_text("name: yard\nobstacles: []\n")
    done = CliRunner().invoke(cli, ["validate", str(path)])
    assert done.exit_code == 2
    assert f"is a scene file: obstaclewatch scene check {path}" in " ".join(done.output.split())
