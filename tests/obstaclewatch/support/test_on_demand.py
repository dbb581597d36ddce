"""Packages load their public names at the first use of one, and nothing before."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PACKAGES = ("obstaclewatch", "scenes")


OLD_FIRST = """
from obstaclewatch.settings import PaperSettings
from scenes.routes import RouteWalk
import obstaclewatch, scenes
assert (PaperSettings, RouteWalk) == (obstaclewatch.PaperSettings, scenes.RouteWalk)
assert obstaclewatch.signal.echoes and scenes.truth.swept
"""


@pytest.mark.parametrize("package", PACKAGES)
def test_names_are_those_of_its_public_module(package):
    whole, public = importlib.import_module(package), importlib.import_module(f"{package}.public")
    assert whole.__all__ == public.__all__
    assert set(public.__all__) <= set(dir(whole))
    assert all(getattr(whole, name) is getattr(public, name) for name in public.__all__)
    for unknown in ("nonsense", "_nonsense", "__nonsense__"):
        with pytest.raises(AttributeError, match=f"module '{package}' has no attribute '{unknown}'"):
            getattr(whole, unknown)


def test_rooms_and_former_places_are_found_in_a_new_process():
    subprocess.run([sys.executable, "-c", OLD_FIRST], cwd=ROOT, check=True)
