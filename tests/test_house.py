"""The plan of the house: small folders, short modules, no circle, few levels; and doors that stay where they were."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("obstaclewatch", "simulator", "scenes", "benchmarks")
MOST_MODULES, MOST_LINES, MOST_LEVELS = 16, 400, 10


@pytest.mark.parametrize("package", PACKAGES)
def test_no_folder_is_crowded(package):
    folders = [ROOT / package, *(path for path in (ROOT / package).rglob("*") if path.is_dir())]
    counts = {f: len([m for m in f.glob("*.py") if m.name != "__init__.py"]) for f in folders}
    assert sum(counts.values()) > 30
    assert {f.relative_to(ROOT).as_posix(): n for f, n in counts.items() if n > MOST_MODULES} == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_no_module_is_long(package):
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in (ROOT / package).rglob("*.py")}
    assert {path.relative_to(ROOT).as_posix(): n for path, n in lines.items() if n > MOST_LINES} == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_rooms_stand_on_few_levels_without_a_circle(package):
    """The order itself is held by the import contracts in pyproject.toml (`lint-imports`)."""
    graph = grimp.build_graph(package)
    for room in graph.find_children(package):
        graph.squash_module(room)
    below = {
        room: graph.find_modules_directly_imported_by(room) - {package, room} for room in graph.find_children(package)
    }
    level: dict[str, int] = {}
    while len(level) < len(below):
        ready = [room for room in below if room not in level and below[room] <= level.keys()]
        assert ready, f"a circle among {sorted(below.keys() - level.keys())}"
        level |= {room: 1 + max((level[other] for other in below[room]), default=0) for room in ready}
    assert 3 <= max(level.values()) <= MOST_LEVELS


@pytest.mark.parametrize("package", PACKAGES)
def test_no_module_asks_its_own_package_for_names(package):
    """A package loads its public names when it is asked for one, and so would load the module that asks once more: it
    fails where that module is the first to be imported. `import scenes.obstacles as obstacles` asks for a module."""
    asking = [
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / package).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.module == package and node.level == 0
    ]
    assert asking == []


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("simulator.air", "Air"), ("simulator.fidelity", "Fidelity"), ("simulator.materials", "Material"),
        ("simulator.paths", "Paths"), ("simulator.phone", "Phone"), ("simulator.pose", "Pose"),
        ("simulator.render", "render_walk"), ("simulator.scene", "Obstacle"), ("simulator.trace", "trace_paths"),
        ("obstaclewatch.collision", "Decision"),
        ("obstaclewatch.detectors", "PaperDetector"), ("obstaclewatch.recording_health", "inspect_recording"),
        ("obstaclewatch.settings", "PaperSettings"), ("obstaclewatch.tracking", "TrackingDetector"),
        ("scenes.approaches", "make_approach"), ("scenes.layouts", "load_scene"), ("scenes.routes", "RouteWalk"),
        ("scenes.truth", "ground_truth"), ("scenes.walks", "GaitWalk"),
    ],
)  # fmt: skip
def test_public_names_stay_importable_from_where_they_stood(module, name):
    package = importlib.import_module(module.partition(".")[0])
    assert getattr(importlib.import_module(module), name) is getattr(package, name)
