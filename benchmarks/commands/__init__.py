"""Subcommands of `obstaclewatch`, one module each.

They import what they work with when they run: `obstaclewatch run --help` answers at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import click
from click.core import ParameterSource

ALLOW_CODE = "allow the modules that a suite file, not one of this project, names as detectors to be imported"
"""Help of the option `--allow-code`."""
OF_APPROACH: tuple[str, ...] = ("index", "collision")
"""Options that say which approach of a category."""


def given() -> set[str]:
    """Names of the options that are on the command line."""
    context = click.get_current_context()
    return {name for name in context.params if context.get_parameter_source(name) is ParameterSource.COMMANDLINE}


def refuse_given(useless: Iterable[str], reason: str) -> None:
    """No option may be given that does nothing.

    Raises:
        ValueError: it is; the message names the options and the reason.
    """
    clash = [name for name in useless if name in given()]
    if clash:
        raise ValueError(f"{reason}, so --{', --'.join(clash)} must not be given")


def check_written(option: str, path: Path, endings: Sequence[str], others: Iterable[Path]) -> None:
    """Refuse, before anything is computed, a file that nothing would read, or that the command itself reads or writes.

    Args:
        option: that names the file, for the message.
        path: the file to be written.
        endings: of its name, one of these.
        others: what the command reads, or writes as well.

    Raises:
        ValueError: another ending, or one of the others, by whichever name.

    >>> check_written("--paths", Path("paths.json"), (".json",), [Path("walk.flac")])
    """
    if path.suffix not in endings:
        raise ValueError(f"{option} must end in {' or '.join(endings)}, got '{path}'")
    for other in others:
        if path == other or (path.exists() and other.exists() and path.samefile(other)):
            raise ValueError(f"{option} must be another file than '{other}', got '{path}'")


def check_pitch(degrees: float) -> None:
    """Refuse a phone that is pitched beyond upright, or in other units.

    Raises:
        click.UsageError: it is; the message gives rule and value.
    """
    if not abs(degrees) < 90.0:
        raise click.UsageError(f"--pitch must lie between -90 and 90 degrees, got {degrees:g}")
