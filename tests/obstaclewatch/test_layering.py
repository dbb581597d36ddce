"""The detector stands alone: numpy, scipy and numba only, and nothing of simulator, scenes or benchmarks."""

from __future__ import annotations

import importlib
import json
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

import obstaclewatch


def test_import_pulls_in_nothing_else():
    """Nor scipy.signal, half of the time that the import took: only `inspect_recording` needs it."""
    script = "import sys, json; from obstaclewatch import *; print(json.dumps(sorted(sys.modules)))"
    root = Path(obstaclewatch.__file__).parents[1]
    loaded = json.loads(
        subprocess.run([sys.executable, "-c", script], cwd=root, capture_output=True, check=True).stdout
    )
    assert {"scipy", "scipy.fft"} <= set(loaded)
    unwanted = {
        "simulator",
        "scenes",
        "benchmarks",
        "soundfile",
        "trimesh",
        "matplotlib",
        "scipy.signal",
        "scipy.stats",
    }
    assert not unwanted & set(loaded)


def test_audio_is_reached_on_demand():
    from obstaclewatch.recordings.audio import read_recording

    assert obstaclewatch.read_recording is read_recording
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = obstaclewatch.nonsense


def test_everything_exported_exists():
    assert all(getattr(obstaclewatch, name) is not None for name in obstaclewatch.__all__)


def test_no_compiled_function_has_default_arguments():
    """A call that left one out took 30 us instead of 2: half of what a beep may cost, in a handful of calls."""
    found = 0
    for info in pkgutil.walk_packages(obstaclewatch.__path__, "obstaclewatch."):
        module = importlib.import_module(info.name)
        compiled = [value for value in vars(module).values() if isinstance(value, Dispatcher)]
        assert all(not value.py_func.__defaults__ for value in compiled), module.__name__
        found += len(compiled)
    assert found > 20
