"""The README's Python and its commands run as they stand."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from tests.benchmarks.simulated_file import assert_detected

pytestmark = pytest.mark.usefixtures("suites_once")
README = Path(__file__).resolve().parents[2] / "README.md"

CUT = {
    "run": ("--limit", "1", "-k", "wall", "--walks", "1", "-j", "1", "--set", "figures=[fig16]"),
    "export": ("--walks", "1", "--set", "groups=[]"),
}


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


def _commands() -> list[str]:
    return [line for line in "\n".join(_blocks("")).splitlines() if line.startswith("obstaclewatch ")]


def _run(line: str, *more: str) -> None:
    done = CliRunner().invoke(cli, [*shlex.split(line)[1:], *more])
    assert done.exit_code == 0, f"{line}: {done.output} {done.exception!r}"


def test_the_five_minutes_run(tmp_path, monkeypatch):
    """Every command in turn, in one folder, as it stands; suites are cut to a walk, the slow one is below."""
    monkeypatch.chdir(tmp_path)
    lines = [line for line in _commands() if " scene check " not in line]
    assert len(lines) >= 5
    for line in lines:
        _run(line, *CUT.get(line.split()[1], ()))
    assert {"street.html", "walk.flac", "paths.json", "echogram.png", "walks", "results"} <= set(os.listdir())
    assert '<section id="walks">' in (tmp_path / "results/paper/latest/report.html").read_text(encoding="utf-8")
    assert_detected(tmp_path / "walk.flac", tmp_path / "paths.json")


@pytest.mark.slow
def test_the_whole_street_is_checked():
    (line,) = [line for line in _commands() if " scene check " in line]
    _run(line)


@pytest.mark.parametrize("target", ["bench", "test"])
def test_the_two_commands_are_targets_of_the_makefile(target):
    assert f"make {target}" in README.read_text(encoding="utf-8")
    assert f"\n{target}:" in (README.parent / "Makefile").read_text(encoding="utf-8")


def test_pictures_are_there():
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", README.read_text(encoding="utf-8"))
    assert pictures
    assert all((README.parent / picture).is_file() for picture in pictures)
