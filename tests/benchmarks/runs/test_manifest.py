"""What a run says of how it was asked for."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from benchmarks import run
from benchmarks.bench import prepared, setting_texts
from benchmarks.commands.run import run as command
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.report.provenance import reproduction_command
from benchmarks.runs.manifest import options_in
from benchmarks.runs.results import load_run, read_manifest


def test_a_run_from_python_says_the_command_that_repeats_it(tmp_path: Path) -> None:
    """Cause: it stored a line that is no command, so that reports told to run what the program refuses."""
    settings = {"standing.detectors": ["PaperDetector"], "knowledge.air": False}
    frame = run("ranging", "smoke", limit=1, seed=3, settings=settings, out=tmp_path)
    words = shlex.split(reproduction_command(load_run(frame.attrs["folder"]).manifest))
    assert words[:3] == ["obstaclewatch", "run", "ranging"]
    given = command.make_context("run", words[2:]).params
    assert (given["tier"], given["seed"], given["limit"]) == ("smoke", 3, 1)
    again = load_suite(given["suite"], given["settings"], given["seed"])
    assert again == load_suite("ranging", ["standing.detectors=[PaperDetector]", "knowledge.air=false"], 3)


def test_other_figures_of_the_same_walks_are_those_asked_for_last(tmp_path: Path) -> None:
    """Cause: the manifest of an existing folder was kept, and with it the figures of an earlier command."""
    for figures in ("[fig16]", "[fig3, fig16]"):
        suite = load_suite("paper", [f"figures={figures}"])
        folder = prepared(tmp_path, suite, "smoke", plan_cells(suite, "smoke")[:2], ["run", "paper"])
        assert read_manifest(folder / "manifest.json")["figures"] == list(suite.figures)
    assert len(list((tmp_path / "paper").glob("smoke*"))) == 1


@pytest.mark.parametrize(
    ("argv", "found"),
    [
        (["run", "paper", "--limit", "5", "-j", "2"], ["--limit", "5"]),
        (
            ["run", "paper", "--set=a=1", "--set", "b=2", "-k", "a and b"],
            ["--set", "a=1", "--set", "b=2", "-k", "a and b"],
        ),
        (["run", "paper", "-ka and b", "--limit=5"], ["-k", "a and b", "--limit", "5"]),
        (["run", "paper"], []),
    ],
)
def test_options_of_a_command_line(argv: list[str], found: list[str]) -> None:
    assert options_in(argv, "--limit", "-k", "--set") == found


def test_numbers_given_in_python_stay_numbers() -> None:
    """Cause: json writes 1e-05, which YAML 1.1 reads as a text; and numpy's numbers ended in a TypeError."""
    settings = {"settings.a": 1e-5, "settings.b": np.int64(3), "settings.c": np.array([1e-7, 2.0])}
    texts = setting_texts(settings)
    assert load_suite("ranging", texts).settings == {"a": 1e-5, "b": 3, "c": [1e-7, 2.0]}
    for wrong, said in [(object(), "settings must hold numbers, texts"), ({1, 2}, "got {1, 2}")]:
        with pytest.raises(ValueError, match=said):
            setting_texts({"settings.a": wrong})
    with pytest.raises(ValueError, match=r"settings must be of type .*Mapping.*, got \['a=1'\]"):
        setting_texts(["a=1"])


def test_a_damaged_manifest_says_what_to_do(tmp_path: Path) -> None:
    """Cause: a run could not go on, and nothing said that its manifest can be written anew without losing a cell."""
    suite = load_suite("paper")
    cells = plan_cells(suite, "smoke")[:2]
    path = prepared(tmp_path, suite, "smoke", cells, ["run", "paper"]) / "manifest.json"
    whole = path.read_text()
    path.write_text(whole[:100])
    with pytest.raises(ValueError, match=r"manifest.json' must be JSON: .*; without that file the same command writes"):
        prepared(tmp_path, suite, "smoke", cells, ["run", "paper"])
    path.unlink()
    path.mkdir()
    with pytest.raises(ValueError, match=r"manifest.json' must be a file, got a folder; without"):
        prepared(tmp_path, suite, "smoke", cells, ["run", "paper"])
    path.rmdir()
    prepared(tmp_path, suite, "smoke", cells, ["run", "paper"])
    assert read_manifest(path)["plan"] == json.loads(whole)["plan"]


def test_results_below_a_file_are_refused_by_its_name(tmp_path: Path) -> None:
    """Cause: the error was "[Errno 20] Not a directory" and named a hidden file that nobody had asked for."""
    suite = load_suite("paper")
    cells = plan_cells(suite, "smoke")[:1]
    file = tmp_path / "notes.txt"
    file.write_text("mine")
    for out in (file, file / "deeper"):
        with pytest.raises(ValueError, match=r"must be a folder, got the file '.*notes.txt'$"):
            prepared(out, suite, "smoke", cells, ["run", "paper"])
    assert file.read_text() == "mine"
