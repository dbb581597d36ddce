"""A reader that goes away, as `| head` does, ends what is printed and not what is stored."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.benchmarks.closed_output import unread


@pytest.mark.parametrize("stderr_too", [False, True])
def test_a_run_goes_on_and_stores_its_results(tmp_path: Path, stderr_too: bool) -> None:
    """Cause: it ended before the first cell, or with "cannot store results: Broken pipe"."""
    chosen = ["extremes", "-k", "slivers", "--limit", "2", "--walks", "0", "--set", "figures=[extremes_table]"]
    assert unread("run", *chosen, "-o", str(tmp_path), stderr_too=stderr_too)[0] == 0
    assert (tmp_path / "extremes" / "latest" / "report.html").exists()


def test_other_commands_end_without_a_word() -> None:
    """Cause: click's 1, which here says that a gate is red."""
    assert unread("ls", "suites") == (141, "")
