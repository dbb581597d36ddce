"""Verdicts for people and machines: a table, gate.json, junit.xml and a Markdown summary."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path

from benchmarks.gates.verdict import State, Verdict
from benchmarks.runs.markdown import plain
from benchmarks.runs.store import to_json, write_atomically
from obstaclewatch.support.words import counted

MARKS = {State.PASSED: "green", State.FAILED: "RED", State.UNMEASURED: "NOTHING MEASURED"}


def table_lines(verdicts: Sequence[Verdict]) -> list[str]:
    """One line a gate, the bad ones last, and a closing count."""
    order = [State.PASSED, State.UNMEASURED, State.FAILED]
    ranked = sorted(verdicts, key=lambda verdict: order.index(verdict.state))
    width = max((len(MARKS[verdict.state]) for verdict in verdicts), default=0)
    lines = [f"{MARKS[v.state]:<{width}}  {v.group:<10}  {v.message}" for v in ranked]
    return [*lines, counts_line(verdicts)]


def counts_line(verdicts: Sequence[Verdict]) -> str:
    """How many ended how."""
    count = {state: sum(verdict.state is state for verdict in verdicts) for state in State}
    green = counted(count[State.PASSED], "gate")
    return f"{green} green, {count[State.FAILED]} red, {count[State.UNMEASURED]} measured nothing"


def write_gate_files(
    folder: Path, title: str, verdicts: Sequence[Verdict], code: int, other_source: str | None = None
) -> None:
    """gate.json, junit.xml and gate.md in a run's folder.

    Args:
        other_source: what to say of a run that another version of the source measured, in gate.json and gate.md.
    """
    write_atomically(folder / "gate.json", to_json(_as_data(title, verdicts, code) | {"other_source": other_source}))
    write_atomically(folder / "junit.xml", junit_xml(title, verdicts))
    write_atomically(folder / "gate.md", markdown(title, verdicts, code, other_source))


def junit_xml(title: str, verdicts: Sequence[Verdict]) -> str:
    """JUnit's format, which CI servers show: red is a failure, nothing measured an error."""
    suite = ElementTree.Element(
        "testsuite",
        name=title,
        tests=str(len(verdicts)),
        failures=str(sum(verdict.state is State.FAILED for verdict in verdicts)),
        errors=str(sum(verdict.state is State.UNMEASURED for verdict in verdicts)),
    )
    for verdict in verdicts:
        case = ElementTree.SubElement(suite, "testcase", classname=f"gates.{verdict.group}", name=verdict.name)
        if verdict.state is State.PASSED:
            ElementTree.SubElement(case, "system-out").text = verdict.message
        else:
            tag = "failure" if verdict.state is State.FAILED else "error"
            ElementTree.SubElement(case, tag, message=verdict.message)
    ElementTree.indent(suite)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(suite, encoding="unicode") + "\n"


def markdown(title: str, verdicts: Sequence[Verdict], code: int, other_source: str | None = None) -> str:
    """A summary for a pull request: what is not green first, then a table of all."""
    bad = [verdict for verdict in verdicts if verdict.state is not State.PASSED]
    lines = [f"# {plain(title)}", "", f"Exit code {code}: {counts_line(verdicts)}.", ""]
    lines += [] if other_source is None else [f"Note: {plain(other_source)}.", ""]
    lines += [f"- **{MARKS[verdict.state]}** {plain(verdict.message)}" for verdict in bad] + ([""] if bad else [])
    lines += ["| | gate | n | measured |", "|---|---|---|---|"]
    lines += [f"| {MARKS[v.state]} | {v.group}: {plain(v.name)} | {v.n or ''} | {plain(v.message)} |" for v in verdicts]
    return "\n".join(lines) + "\n"


def _as_data(title: str, verdicts: Sequence[Verdict], code: int) -> dict[str, object]:
    return {
        "title": title,
        "exit_code": code,
        "gates": [
            {"group": v.group, "name": v.name, "state": v.state.value, "message": v.message, "n": v.n} for v in verdicts
        ],
    }
