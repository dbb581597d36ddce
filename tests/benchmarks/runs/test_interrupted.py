"""`kill -9` of a running sweep at random moments, then on with another executor: the same bytes as without."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.runs.runner import run_cells
from tests.benchmarks.fake_cells import fake_plan, fake_work

ROOT = Path(__file__).resolve().parents[3]
EXECUTORS = [("local", 2), ("serial", 1), ("local", 3), ("dask", 2)]
BYTES_ALIKE = ("results.csv", "summary.json", "cells/*/*.json", "figures/*.csv", "figures/*.svg", "figures/*.png")


def start(arguments: list[str]) -> subprocess.Popen[bytes]:
    """A sweep in a session of its own, so that whatever it leaves behind can be ended with it."""
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    return subprocess.Popen([sys.executable, *arguments], cwd=ROOT, env=environment, start_new_session=True, **quiet)


def killed_after(arguments: list[str], seconds: float) -> bool:
    """Start a sweep, kill its main process with signal 9 after so long, and say whether it was still at work."""
    process = start(arguments)
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        end_session(process)
        return True
    return False


def end_session(process: subprocess.Popen[bytes]) -> None:
    """Workers notice by themselves that their sweep is gone; tests do not wait for it."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        return


def files(folder: Path, patterns: tuple[str, ...]) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for pattern in patterns for p in folder.glob(pattern)}


def test_fake_cells_survive_three_kills(tmp_path):
    calm, torn, cells = tmp_path / "calm", tmp_path / "torn", fake_plan(300)
    assert run_cells(calm, cells, work=fake_work()).complete
    moments = random.Random(5)
    done = [0]
    for name, jobs in EXECUTORS[:3]:
        script = ["-m", "tests.benchmarks.sweep_process", str(torn), "300", name, str(jobs), "0.02"]
        process = start(script)
        begin = time.monotonic()
        while len(list(torn.glob("cells/*/*.json"))) <= done[-1] + 1 and time.monotonic() < begin + 30.0:
            time.sleep(0.05)
        time.sleep(moments.uniform(0.0, 0.2))
        assert process.poll() is None
        process.kill()
        process.wait()
        end_session(process)
        done.append(len(list(torn.glob("cells/*/*.json"))))
    assert done == sorted(set(done))  # every round got further, none had finished
    assert done[-1] < 300
    assert run_cells(torn, cells, work=fake_work()).complete
    assert files(calm, BYTES_ALIKE) == files(torn, BYTES_ALIKE)
    assert len(files(calm, BYTES_ALIKE)) == 300
    assert not list(torn.rglob("*.partial"))


@pytest.mark.slow
def test_a_real_sweep_survives_ten_kills(tmp_path):
    common = ["-m", "benchmarks.cli", "run", "paper", "--tier", "smoke", "--limit", "10", "--walks", "0"]
    assert start([*common, "-o", str(tmp_path / "calm")]).wait() == 0
    moments, killed = random.Random(9), 0
    for k in range(10):
        name, jobs = EXECUTORS[k % len(EXECUTORS)]
        arguments = [*common, "--executor", name, "-j", str(jobs), "-o", str(tmp_path / "torn")]
        killed += killed_after(arguments, moments.uniform(2.0, 9.0))
    assert killed == 10
    assert start([*common, "-j", "2", "-o", str(tmp_path / "torn")]).wait() == 0
    calm, torn = ((tmp_path / name / "paper" / "latest").resolve() for name in ("calm", "torn"))
    expected = files(calm, BYTES_ALIKE)
    assert len([name for name in expected if name.startswith("cells")]) == 10
    assert len([name for name in expected if name.startswith("figures")]) > 10
    assert files(torn, BYTES_ALIKE) == expected
