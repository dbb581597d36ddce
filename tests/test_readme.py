"""The README's Python runs as it stands, and its commands exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from benchmarks.cli import COMMANDS

README = Path(__file__).resolve().parents[1] / "README.md"


def _blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)


def test_python_blocks_run(capsys):
    blocks = _blocks("python")
    assert blocks
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, "README.md", "exec"), names)
    assert "curved" in capsys.readouterr().out
    assert len(names["decisions"]) == 20


def test_commands_exist():
    called = re.findall(r"^obstaclewatch (\w+)", "\n".join(_blocks("")), re.MULTILINE)
    assert len(called) >= 4
    assert set(called) <= set(COMMANDS)


@pytest.mark.parametrize("target", ["bench", "test"])
def test_the_two_commands_are_targets_of_the_makefile(target):
    assert f"make {target}" in README.read_text(encoding="utf-8")
    assert f"\n{target}:" in (README.parent / "Makefile").read_text(encoding="utf-8")


def test_pictures_are_there():
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", README.read_text(encoding="utf-8"))
    assert pictures
    assert all((README.parent / picture).is_file() for picture in pictures)
