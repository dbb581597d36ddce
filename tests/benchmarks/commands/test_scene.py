"""`scene` on what is hardly one, and options of commands that would do nothing."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks.cli import cli


def test_a_scene_without_obstacles_can_be_checked(tmp_path: Path) -> None:
    """Cause: the widest of no names was asked for."""
    path = tmp_path / "empty.yaml"
    path.write_text("name: empty\nground: null\nobstacles: []\n", encoding="utf-8")
    done = CliRunner().invoke(cli, ["scene", "check", str(path), "--no-cost"], catch_exceptions=False)
    assert done.exit_code == 0
    assert "mechanisms needed: none" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["scene", "preview", "supermarket", "-o", "a.png", "--index", "2"], "--index"),
        (["scene", "preview", "supermarket", "-o", "a.png", "--no-collision"], "--collision"),
        (["figures", "run", "--tier", "ci", "-j", "2"], "--tier, --jobs"),
        (["figures", "run", "-o", "elsewhere"], "--out"),
    ],
)
def test_options_that_would_do_nothing_are_refused(arguments: list[str], named: str) -> None:
    """Cause: only `simulate` looked for options that the others given leave without a use."""
    assert f"so {named} must not be given" in str(CliRunner().invoke(cli, arguments).exception)


def test_a_live_recording_has_no_channels_to_swap() -> None:
    """Cause: --swap was applied to files alone, and taken beside --live."""
    done = CliRunner().invoke(cli, ["detect", "--live", "1", "--swap"])
    assert done.exit_code == 2
    assert "--swap is for the channels of a RECORDING" in done.output
