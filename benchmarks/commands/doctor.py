"""`obstaclewatch doctor`: whether this installation works."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path

import click

from benchmarks.doctor import Finding, examine

BROKEN = 2
MARKS = {True: "ok", None: "note", False: "BROKEN"}


@click.command()
@click.option("-o", "--out", type=click.Path(path_type=Path), default=Path("results"), show_default=True)
@click.option("--json", "as_json", is_flag=True, help="for machines")
def doctor(out: Path, as_json: bool) -> None:
    """Try every part of the installation on something with a known answer. Exit code 2 if one is broken."""
    findings = []
    for finding in examine(out):
        findings.append(finding)
        if not as_json:
            click.echo(_line(finding))
    if as_json:
        click.echo(json.dumps([asdict(finding) for finding in findings]))
    broken = [finding.name for finding in findings if finding.ok is False]
    if broken:
        click.echo(f"broken: {', '.join(broken)}", err=True)
        sys.exit(BROKEN)


def _line(finding: Finding) -> str:
    line = f"{MARKS[finding.ok]:<7} {finding.name:<18} {finding.message}"
    return f"{line}\n{'':<7} -> {finding.advice}" if finding.advice else line
