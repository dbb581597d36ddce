"""The doctor finds what is broken, says what to do, and is quiet about what works."""

from __future__ import annotations

import json
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks import doctor
from benchmarks.cli import COMMANDS, cli

NAMES = ("python", "numpy", "embreex", "ray casting", "compiled kernels", "audio files", "simulator", "disk")


def call():
    return CliRunner().invoke(cli, ["doctor"], catch_exceptions=False)


def test_a_good_installation_is_healthy(tmp_path):
    done = CliRunner().invoke(cli, ["doctor", "--json", "-o", str(tmp_path)], catch_exceptions=False)
    findings = {found["name"]: found for found in json.loads(done.output)}
    assert done.exit_code == 0
    assert set(NAMES) <= set(findings)
    assert all(findings[name]["ok"] for name in NAMES)


@pytest.mark.parametrize("module", ["embreex", "soundfile", "numba", "scipy"])
def test_a_package_that_cannot_be_imported_is_named(monkeypatch, module):
    monkeypatch.setitem(sys.modules, module, None)  # Python's own way to make an import fail
    monkeypatch.setattr(doctor, "ATTEMPTS", tuple(entry for entry in doctor.ATTEMPTS if entry[0] != "simulator"))
    done = call()
    assert done.exit_code == 2
    (line,) = [line for line in done.output.splitlines() if line.startswith(f"BROKEN  {module} ")]
    assert f"import of {module} halted" in line
    assert f"broken: {module}" in done.stderr
    assert "pip install --constraint constraints.txt" in done.output


def test_every_dependency_of_the_project_file_is_found_by_its_module():
    """Read from pyproject.toml: what an earlier installation recorded may name fewer packages than a fresh one."""
    project = tomllib.loads((doctor.CONSTRAINTS.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    findings = [doctor._dependency(doctor._name(line), None) for line in project["dependencies"]]
    assert len(findings) > 10
    assert [finding for finding in findings if not finding.ok] == []


def test_rays_that_miss_are_found(monkeypatch):
    from embreex.rtcore_scene import EmbreeScene

    class Blind:
        def __init__(self, **_):
            self.real = EmbreeScene(robust=True)

        def run(self, starts, *_, **__):
            return {"primID": -starts[:, 0].astype(int) - 1, "tfar": starts[:, 0]}

    monkeypatch.setattr("embreex.rtcore_scene.EmbreeScene", Blind)
    monkeypatch.setattr("embreex.mesh_construction.TriangleMesh", lambda *_: None)
    (finding,) = [doctor._attempted(*entry) for entry in doctor.ATTEMPTS if entry[0] == "ray casting"]
    assert finding.ok is False
    assert "one hit at 2 m expected, got triangles [-1, -1]" in finding.message


def test_another_version_is_a_note(monkeypatch):
    monkeypatch.setattr(doctor, "_pinned", lambda: {"numpy": "0.1"})
    done = call()
    assert done.exit_code == 0
    assert "tested with 0.1" in done.output


def test_a_full_disk_is_found(monkeypatch, tmp_path):
    usage = doctor.shutil.disk_usage(tmp_path)
    monkeypatch.setattr(doctor.shutil, "disk_usage", lambda _: usage._replace(free=5_000_000))
    finding = doctor._disk(tmp_path / "not" / "there")
    assert finding.ok is False
    assert "0.01 GB" in finding.message or "0.00 GB" in finding.message


def test_help_costs_little_more_than_click():
    """Commands are imported when called: 0.3 s of help on any machine is twice what click alone takes to import."""

    def seconds(*arguments: str) -> float:
        begin = time.perf_counter()
        subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
        return time.perf_counter() - begin

    def best(*arguments: str) -> float:
        return min(seconds(*arguments) for _ in range(5))

    assert best("-m", "benchmarks.cli", "--help") < 2.5 * best("-c", "import click")


def test_help_loads_no_library():
    show = "c.cli(['--help'], standalone_mode=False)"
    code = f"import sys, benchmarks.cli as c; {show}; print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    loaded = set(done.stderr.split())
    assert all(name in done.stdout for name in COMMANDS)
    assert "click" in loaded
    assert not loaded & {"numpy", "scipy", "pydantic", "yaml", "matplotlib", "numba", "trimesh", "distributed"}


def test_every_command_exists_and_has_help():
    for name in COMMANDS:
        done = CliRunner().invoke(cli, [name, "--help"], catch_exceptions=False)
        assert done.exit_code == 0
        assert done.output.startswith("Usage:")
    assert Path(doctor.CONSTRAINTS).is_file()
