"""Verdicts as exit codes and files, and the commands from a baseline to red."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree

from click.testing import CliRunner

from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.cli import cli
from benchmarks.gates.output import junit_xml, markdown
from benchmarks.gates.verdict import Verdict, exit_code
from benchmarks.runs.results import RunData
from benchmarks.runs.store import to_json
from tests.benchmarks.gated_runs import changed, good_run, one_channel_late, run_of
from tests.benchmarks.gates.verdicts import REGRESSION, stored


def test_nothing_is_not_green():
    assert exit_code([]) == 4
    good, bad = Verdict.of("g", "n", True, "", 1), Verdict.of("g", "n", False, "", 1)
    none = Verdict.unmeasured("g", "n", "")
    assert [exit_code(found) for found in ([good], [good, none], [none, bad], [bad])] == [0, 4, 1, 1]
    assert [exit_code(found, complete=False) for found in ([good], [none], [none, bad], [])] == [3, 3, 1, 3]


def test_outputs_say_the_same(tmp_path):
    verdicts = [
        Verdict.of("regression", "D <TN>", False, 'lost "half" & more', 40),
        Verdict.of("claim", "D TP", True, "fine", 9),
        Verdict.unmeasured("physics", "wall", "no echo"),
    ]
    root = ElementTree.fromstring(junit_xml("title", verdicts).partition("\n")[2])
    assert (root.get("tests"), root.get("failures"), root.get("errors")) == ("3", "1", "1")
    assert root.findall("testcase")[0].find("failure").get("message") == 'lost "half" & more'
    text = markdown("title", verdicts, 1)
    assert text.index("**RED**") < text.index("| green |")
    assert text.count("\n| ") == 5 - 1


def test_the_command_line_from_baseline_to_red(tmp_path):
    gates = tmp_path / "gates.yaml"
    gates.write_text(to_json(REGRESSION.model_dump(mode="json") | {"baseline": "kept/b.json"}))
    run = good_run(tmp_path)
    good, bad = stored(run, tmp_path / "good"), stored(changed(run, one_channel_late), tmp_path / "bad")
    empty = stored(run_of(tmp_path, []), tmp_path / "empty")
    (empty / "manifest.json").write_text(to_json(run.manifest))

    def call(*arguments: str):
        return CliRunner().invoke(cli, [*arguments, "--gates", str(gates)], catch_exceptions=False)

    assert call("baseline", "update", str(good), "--reason", "first").exit_code == 0
    assert "first" in call("baseline", "history").output
    assert call("gate", str(good)).exit_code == 0
    failed = call("gate", str(bad))
    assert failed.exit_code == 1
    assert "RED" in failed.output
    assert "path_difference_bias" in failed.output
    assert json.loads((bad / "gate.json").read_text())["exit_code"] == 1
    assert "path_difference_bias" in (bad / "junit.xml").read_text()
    assert "path_difference_bias" in (bad / "gate.md").read_text()
    nothing = call("gate", str(empty))
    assert nothing.exit_code == 3
    assert "the run holds no measured cell" in nothing.stderr
    (tmp_path / "kept" / "b.json").write_text('{"format": 0}')
    old = call("gate", str(good))
    assert old.exit_code == 4
    assert "must have format 1, got 0" in old.stderr


def test_a_run_of_another_source_is_named(tmp_path):
    """What an older source measured was judged, and became a baseline, without a word; later only the terminal told."""
    run = good_run(tmp_path)
    today = run.manifest | {"source_sha256": source_fingerprint()}
    old = stored(
        RunData(run.folder, today | {"source_sha256": "0" * 64, "git_revision": None}, run.cells), tmp_path / "old"
    )
    same = stored(RunData(run.folder, today, run.cells), tmp_path / "same")
    ends = ["--reason", "first", "--baseline", str(tmp_path / "b.json")]
    said = CliRunner().invoke(cli, ["baseline", "update", str(old), *ends], catch_exceptions=False).stderr
    assert f"{old}: the run was measured by revision unknown (source 0000000000); today's is revision" in said
    assert source_fingerprint()[:10] in said
    assert "measured by" not in CliRunner().invoke(cli, ["baseline", "update", str(same), *ends]).stderr
    gates = tmp_path / "gates.yaml"
    gates.write_text(to_json({"title": "one", "physics": {"air_absorption": 0.001}}))
    assert "measured by" in CliRunner().invoke(cli, ["gate", str(old), "--gates", str(gates)]).stderr
    assert "measured by" not in CliRunner().invoke(cli, ["gate", str(same), "--gates", str(gates)]).stderr
    told = [json.loads((folder / "gate.json").read_text())["other_source"] for folder in (old, same)]
    assert told == [said.removeprefix(f"{old}: ").splitlines()[0], None]
    assert ["measured by" in (folder / "gate.md").read_text() for folder in (old, same)] == [True, False]


def test_an_incomplete_run_is_neither_green_nor_red(tmp_path):
    gates = tmp_path / "gates.yaml"
    gates.write_text(to_json({"title": "one", "physics": {"air_absorption": 0.001}}))
    run = good_run(tmp_path)
    part = stored(RunData(run.folder, run.manifest, run.cells[:40]), tmp_path / "part")
    done = CliRunner().invoke(cli, ["gate", str(part), "--gates", str(gates)])
    assert done.exit_code == 3
    assert "incomplete: 40 good cells of 86" in done.stderr


def test_status_counts_and_says_how_to_go_on(tmp_path):
    run = good_run(tmp_path)
    whole = stored(run, tmp_path / "whole")
    part = stored(RunData(run.folder, run.manifest, run.cells[:40]), tmp_path / "part")
    done = CliRunner().invoke(cli, ["status", str(whole)], catch_exceptions=False)
    assert (done.exit_code, done.output) == (0, "86 planned, 86 ok, 0 failed, 0 missing\n")
    half = CliRunner().invoke(cli, ["status", str(part), "--json"], catch_exceptions=False)
    assert half.exit_code == 3
    assert json.loads(half.output)["missing"] == 46
    text = CliRunner().invoke(cli, ["status", str(part)], catch_exceptions=False).output
    assert "run paper --tier smoke --set scoring.gate_m=0.4" in text
