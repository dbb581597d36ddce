"""What a command writes is never what it reads."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks.cli import cli

SCENE = "name: yard\nobstacles:\n  - {kind: wall, name: wall, at_m: [3, 0], parameters: {length_m: 4, height_m: 3}}\n"


@pytest.mark.parametrize(
    ("output", "paths", "rule"),
    [
        ("w.wav", "yard.yaml", "--paths must end in .json, got 'yard.yaml'"),
        ("a.flac", "a.flac", "--paths must end in .json, got 'a.flac'"),
        ("w.wav", "paths", "--paths must end in .json, got 'paths'"),
        ("w.wav", "same.json", "--paths must be another file than 'yard.yaml', got 'same.json'"),
        ("old.wav", "old.json", "--paths must be another file than 'old.wav', got 'old.json'"),
    ],
)
def test_simulate_refuses_paths_that_would_replace_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, output: str, paths: str, rule: str
) -> None:
    """Cause: --paths took any name, and replaced the scene, or the recording that had just been rendered."""
    monkeypatch.chdir(tmp_path)
    Path("yard.yaml").write_text(SCENE)
    Path("old.wav").write_bytes(b"old")
    Path("same.json").symlink_to("yard.yaml")
    Path("old.json").hardlink_to("old.wav")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    done = CliRunner().invoke(cli, ["simulate", "yard.yaml", "-o", output, "--paths", paths])
    assert isinstance(done.exception, ValueError)
    assert str(done.exception) == rule
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
