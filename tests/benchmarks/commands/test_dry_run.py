"""A dry run refuses what the run itself would refuse."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks.cli import cli


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--scheduler", "tcp://x:1"], "a scheduler needs the executor 'dask', got 'serial'"),
        (["--executor", "serial", "-j", "2"], "the executor 'serial' has one job, got 2"),
    ],
)
def test_a_dry_run_judges_where_cells_would_be_computed(tmp_path: Path, options: list[str], said: str) -> None:
    """Cause: the executor was chosen after the plan was printed, so `-n` was content with what `run` refuses."""
    done = CliRunner().invoke(cli, ["run", "paper", "--tier", "smoke", "-n", "-o", str(tmp_path), *options])
    assert said in str(done.exception)
    assert "paper" not in done.output
