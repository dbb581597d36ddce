"""SIGTERM ends a run as Ctrl-C does: no worker stays, and the same command goes on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks import cli
from benchmarks.runs.runner import run_cells
from tests.benchmarks.fake_cells import fake_plan, fake_work

psutil = pytest.importorskip("psutil", reason="looks for the processes that are left")

ROOT = Path(__file__).resolve().parents[3]
QUICK, CELLS, ENDS_S = 2, 6, 20.0
SWEEP = f"""
import sys, time
from pathlib import Path
import click
from benchmarks import cli
from benchmarks.runs.executors import choose_executor
from benchmarks.runs.runner import run_cells
from tests.benchmarks.fake_cells import fake_plan, fake_work

def work(cell):
    time.sleep(0.0 if cell.index < {QUICK} else 300.0)
    return fake_work()(cell)

@click.command()
def sweep():
    run_cells(Path(sys.argv[1]), fake_plan({CELLS}), choose_executor("local", 2), work=work)

cli.cli = lambda **how: sweep.main(args=[], **how)
cli.main()
"""


def alive(processes: list[psutil.Process]) -> list[psutil.Process]:
    """Without those that are dead and only not yet collected."""
    return [each for each in processes if each.is_running() and each.status() != psutil.STATUS_ZOMBIE]


@pytest.mark.parametrize(
    ("sent", "code", "said"),
    [(signal.SIGTERM, 143, "terminated; the same"), (signal.SIGINT, 130, "interrupted; the same")],
)
def test_no_worker_is_left_and_the_rest_is_computed_later(
    tmp_path: Path, sent: signal.Signals, code: int, said: str
) -> None:
    """Cause: SIGTERM ended the main process alone. Workers went on for minutes and held standard output, so that
    `| tee` and CI waited for them."""
    process = subprocess.Popen(
        [sys.executable, "-c", SWEEP, str(tmp_path)], cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
    )  # fmt: skip
    try:
        begin = time.monotonic()
        while len(list(tmp_path.glob("cells/*/*.json"))) < QUICK and time.monotonic() < begin + 30.0:
            time.sleep(0.02)
        below = psutil.Process(process.pid).children(recursive=True)
        assert len(below) >= 2
        process.send_signal(sent)
        output, _ = process.communicate(timeout=ENDS_S)  # until nobody holds the pipe
        assert (process.returncode, said in output.decode()) == (code, True), output
        psutil.wait_procs(below, timeout=ENDS_S)
        assert alive(below) == []
    finally:
        os.killpg(process.pid, signal.SIGKILL) if process.poll() is None else None
    assert len(list(tmp_path.glob("cells/*/*.json"))) == QUICK
    assert run_cells(tmp_path, fake_plan(CELLS), work=fake_work()).complete
    assert not list(tmp_path.rglob("*.partial"))


def test_a_caller_s_own_handler_of_the_signal_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []

    def own(number: int, _: object) -> None:
        seen.append(number)

    monkeypatch.setattr(cli, "cli", lambda **_: os.kill(os.getpid(), signal.SIGTERM))
    before = signal.signal(signal.SIGTERM, own)
    try:
        cli.main()
        assert signal.getsignal(signal.SIGTERM) is own
    finally:
        signal.signal(signal.SIGTERM, before)
    assert seen == [signal.SIGTERM]
