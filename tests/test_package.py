"""Wheel and source archive hold everything, and the wheel works in an environment of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("obstaclewatch", "simulator", "scenes", "benchmarks")
ALONE = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
"""The environment without a path to the sources."""


def run(*arguments: object, cwd: Path) -> str:
    done = subprocess.run([*map(str, arguments)], cwd=cwd, env=ALONE, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_wheel_and_source_archive_work(tmp_path: Path):
    """Built from a copy of the sources; installed without their folder in sight; every file of data is there."""
    tracked = run("git", "ls-files", *PACKAGES, "pyproject.toml", "README.md", "LICENSE", cwd=ROOT).split()
    for name in tracked:
        (tmp_path / "source" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "source" / name).write_bytes((ROOT / name).read_bytes())
    run(sys.executable, "-m", "build", "--no-isolation", "-o", tmp_path / "dist", cwd=tmp_path / "source")
    (wheel,), (archive,) = ([*(tmp_path / "dist").glob(kind)] for kind in ("*.whl", "*.tar.gz"))
    packed = set(zipfile.ZipFile(wheel).namelist())
    wanted = {name for name in tracked if name.split("/")[0] in PACKAGES}
    assert wanted - packed == set()
    with tarfile.open(archive) as tar:
        in_archive = {name.partition("/")[2] for name in tar.getnames()}
    assert wanted - in_archive == set()
    run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", tmp_path / "venv", cwd=tmp_path)
    python = tmp_path / "venv" / "bin" / "python"
    site = Path(run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=tmp_path).strip())
    zipfile.ZipFile(wheel).extractall(site)
    above = [path for path in sys.path if path.endswith("site-packages")]
    (site / "above.pth").write_text("\n".join(above), encoding="utf-8")
    told = run(python, "-c", "import benchmarks; print(benchmarks.__file__)", cwd=tmp_path)
    assert told.startswith(str(site))
    assert "paper" in run(python, "-m", "benchmarks.cli", "ls", "suites", cwd=tmp_path)
    small = ["--limit", "1", "--set", "groups=[]", "--walks", "0"]
    assert "report: " in run(python, "-m", "benchmarks.cli", "run", "paper", "--tier", "smoke", *small, cwd=tmp_path)
    run(python, "-m", "benchmarks.cli", "export", "paper", "set", "--walks", "1", "--set", "groups=[]", cwd=tmp_path)
    assert (tmp_path / "set" / "LICENSE").is_file()


INSIDE = """
import sys
for name in ("networkx", "pytest", "hypothesis", "pyroomacoustics", "acoustic_spaces", "nbclient", "sphinx"):
    sys.modules[name] = None  # imports of it fail
import trimesh
from simulator import Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
scene = Scene([Obstacle(trimesh.creation.icosphere(radius=1.0), Material.named("concrete"), "ball")])
try:
    trace_paths(scene, Phone.named("galaxy-s8-plus"), Pose([0.5, 0.0, 0.0], held_rotation(0.0, 0.0)))
except ValueError as error:
    print(error)
"""


def test_what_only_tests_install_is_not_needed(tmp_path: Path):
    """What tells a phone within an obstacle asked for rtree, which only the tests' extra installed."""
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    assert any(name.startswith("rtree") for name in wanted)
    assert "inside" in run(sys.executable, "-c", INSIDE, cwd=ROOT)
