"""Runs a tutorial: its files are written, its Python and its commands executed, its outputs compared, in order."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from benchmarks.cli import cli

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)


def run_tutorial(page: Path) -> list[str]:
    """Run all blocks in the current folder.

    A block of Python is executed, in one namespace; one of YAML that begins with "# name.yaml" is written to that
    file; one without a language holds commands, which must succeed or end with the code that a comment at the end of
    the line says, "# exit code 1". A block of text is what the command before it prints: each of its
    lines but "..." has to begin a line of the output, up to "..." if it ends so, in the same order.

    Returns:
        What was run, a line each.
    """
    names: dict[str, Any] = {}
    done: list[str] = []
    output = ""
    for language, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language == "python":
            exec(compile(text, page.name, "exec"), names)
            done.append("python")
        elif language == "yaml":
            found = re.match(r"# (\S+\.yaml)\n", text)
            assert found is not None, f"a YAML block must begin with its file's name: {text[:40]!r}"
            Path(found.group(1)).write_text(text, encoding="utf-8")
            done.append(f"write {found.group(1)}")
        elif language == "":
            output = "".join(_run(line) for line in text.splitlines())
            done += text.splitlines()
        elif language == "text":
            _compare(text, output)
        else:
            raise AssertionError(f"a block must be python, yaml, text or commands, got '{language}'")
    return done


def _run(line: str) -> str:
    program, *arguments = shlex.split(line, comments=True)
    code = int(line.rpartition("# exit code ")[2]) if "# exit code " in line else 0
    assert program == "obstaclewatch", f"commands must be the project's own, got {line!r}"
    alone = ("-j", "1") if "-j" in arguments else ()  # the last one counts: walks are kept in this process
    result = CliRunner().invoke(cli, [*arguments, *alone])
    assert result.exit_code == code, f"{line}: {result.output} {result.exception!r}"
    return result.output


def _compare(expected: str, output: str) -> None:
    lines = iter(output.splitlines())
    for wanted in expected.splitlines():
        start = wanted.removesuffix("...").rstrip()
        assert not start or any(line.startswith(start) for line in lines), f"{wanted!r} must be in {output!r}"
