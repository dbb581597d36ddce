"""Whether an installation works: each part is tried on something with a known answer.

Nothing that may be broken is imported at the top, so that the doctor itself always runs.
"""

from __future__ import annotations

import importlib
import math
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from typing import Any

INSTALL = "install again: python -m pip install --constraint constraints.txt --editable ."
MODULES = {"PyYAML": "yaml"}  # where the package is not called as its module
LEAST_FREE_GB = 1.0
CONSTRAINTS = Path(__file__).resolve().parents[1] / "constraints.txt"


@dataclass(frozen=True)
class Finding:
    """One check.

    Attributes:
        name: what was tried.
        ok: whether it works; None for what is optional and missing, or merely unusual.
        message: what was found.
        advice: what to do, empty if nothing.
    """

    name: str
    ok: bool | None
    message: str
    advice: str = ""


def examine(folder: Path) -> Iterator[Finding]:
    """Every check in turn; `folder` is where results would go."""
    yield _python()
    yield from _dependencies()
    for name, attempt, advice in ATTEMPTS:
        yield _attempted(name, attempt, advice)
    yield _disk(folder)
    yield _optional("dask cluster", "distributed", "for --executor dask: pip install 'obstaclewatch[cluster]'")
    yield _browser()


def _python() -> Finding:
    return Finding("python", True, ".".join(map(str, sys.version_info[:3])))


def _dependencies() -> Iterator[Finding]:
    """Every package named as a dependency: there, importable, and of the version that the project is tested with."""
    pinned = _pinned()
    try:
        named = [_name(line) for line in requires("obstaclewatch") or [] if "extra ==" not in line]
    except PackageNotFoundError:
        yield Finding("obstaclewatch", False, "not installed", INSTALL)
        return
    for name in named:
        yield _dependency(name, pinned.get(name.lower()))


def _dependency(name: str, pinned: str | None) -> Finding:
    try:
        found = version(name)
        importlib.import_module(MODULES.get(name, name))
    except Exception as error:  # a broken package may raise anything
        return Finding(name, False, f"cannot be imported: {type(error).__name__}: {error}", INSTALL)
    if pinned is not None and found != pinned:
        return Finding(name, None, f"{found}, tested with {pinned}", "if something fails, " + INSTALL)
    return Finding(name, True, found)


def _pinned() -> dict[str, str]:
    """Lower-case name -> version of the constraints, empty outside of a source tree."""
    if not CONSTRAINTS.is_file():
        return {}
    lines = CONSTRAINTS.read_text(encoding="utf-8").splitlines()
    return {name.lower(): pin for name, found, pin in (line.partition("==") for line in lines) if found}


def _name(requirement: str) -> str:
    match = re.match(r"[A-Za-z0-9._-]+", requirement)
    return match.group() if match else requirement


def _attempted(name: str, attempt: Callable[[], str], advice: str) -> Finding:
    try:
        return Finding(name, True, attempt())
    except Exception as error:  # whatever is broken is the finding
        return Finding(name, False, f"{type(error).__name__}: {error}", advice)


def _embree_hits() -> str:
    """A ray through a triangle hits at its known distance, and one beside it misses."""
    import numpy as np
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    scene = EmbreeScene(robust=True)
    corners = np.array([[0, 0, 2], [1, 0, 2], [0, 1, 2]], dtype=np.float32)
    TriangleMesh(scene, corners, np.array([[0, 1, 2]], dtype=np.int32))
    starts = np.array([[0.2, 0.2, 0.0], [0.9, 0.9, 0.0]], dtype=np.float32)
    hit = scene.run(starts, np.array([[0, 0, 1]] * 2, dtype=np.float32), query="INTERSECT", output=True)
    if hit["primID"].tolist() != [0, -1] or not math.isclose(hit["tfar"][0], 2.0, rel_tol=1e-5):
        raise RuntimeError(f"one hit at 2 m expected, got triangles {hit['primID'].tolist()} at {hit['tfar'].tolist()}")
    return "hits a triangle at 2 m, misses beside it"


def _numba_compiles() -> str:
    import numba
    import numpy as np

    @numba.njit
    def total(values: Any) -> float:
        found = 0.0
        for value in values:
            found += value
        return found

    result = total(np.arange(101.0))
    if result != 5050.0:
        raise RuntimeError(f"the sum of 0..100 must be 5050, got {result}")
    return "compiles, and adds up"


def _audio_comes_back() -> str:
    import numpy as np
    import soundfile

    samples = np.random.default_rng(0).uniform(-0.5, 0.5, (960, 2))
    with tempfile.TemporaryDirectory() as folder:
        for suffix in ("wav", "flac"):
            path = Path(folder) / f"probe.{suffix}"
            soundfile.write(path, samples, 192_000, subtype="PCM_24")
            back, rate = soundfile.read(path)
            if rate != 192_000 or np.abs(back - samples).max() > 2**-23:
                raise RuntimeError(f"{suffix} at 192 kHz does not come back as written")
    return "WAV and FLAC, 24 bit at 192 kHz, come back"


def _echo_is_right() -> str:
    """The whole simulator on a wall 2 m away: one echo, 3.9 m of path to a microphone 10 cm ahead."""
    import numpy as np
    import trimesh

    from simulator import Air, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

    wall = trimesh.creation.box((0.2, 9.0, 9.0), trimesh.transformations.translation_matrix((2.1, 0.0, 0.0)))
    scene = Scene([Obstacle(wall, Material.rigid(), "wall")], Air.lossless(343.0))
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.1, 0.0], [0.0, -0.1, 0.0]])
    paths = trace_paths(scene, phone, Pose(np.zeros(3), held_rotation(0.0, 0.0)))
    echo = paths[(paths.kind == "specular") & (paths.mic == 0)]
    if len(echo) != 1 or not math.isclose(echo.delay_s[0], 3.9 / 343.0, rel_tol=1e-9):
        raise RuntimeError(f"one echo after 3.9 m expected, got delays {(343.0 * echo.delay_s).tolist()} m")
    return "a wall at 2 m echoes after a path of 3.9 m"


ATTEMPTS: tuple[tuple[str, Callable[[], str], str], ...] = (
    ("ray casting", _embree_hits, "embreex has no build for this machine or is damaged; " + INSTALL),
    ("compiled kernels", _numba_compiles, "numba and numpy do not fit each other; " + INSTALL),
    ("audio files", _audio_comes_back, "soundfile needs libsndfile 1.0.29 or newer; " + INSTALL),
    ("simulator", _echo_is_right, "the parts above work and the simulator does not: its source is changed or damaged"),
)


def _disk(folder: Path) -> Finding:
    there = next(path for path in (folder.resolve(), *folder.resolve().parents) if path.exists())
    free_gb = shutil.disk_usage(there).free / 1e9
    if free_gb < LEAST_FREE_GB:
        return Finding("disk", False, f"{free_gb:.2f} GB free at {there}", "free some space, or run with -o elsewhere")
    try:
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        return Finding("disk", False, f"cannot write at {there}: {error}", "run with -o elsewhere")
    return Finding("disk", True, f"{free_gb:.0f} GB free")


def _optional(name: str, module: str, advice: str) -> Finding:
    try:
        importlib.import_module(module)
    except Exception as error:  # optional: whatever is wrong, it is merely missing
        return Finding(name, None, f"not there ({type(error).__name__})", advice)
    return Finding(name, True, version(module))


def _browser() -> Finding:
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if shutil.which(name):
            return Finding("browser", True, name)
    return Finding("browser", None, "no chromium", "only the test that opens the report needs one")
