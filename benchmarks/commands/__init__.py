"""Subcommands of `obstaclewatch`, one module each.

They import what they work with when they run: `obstaclewatch run --help` answers at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

ALLOW_CODE = "allow the modules that a suite file, not one of this project, names as detectors to be imported"
"""Help of the option `--allow-code`."""
OF_APPROACH: tuple[str, ...] = ("index", "collision")
"""Options that say which approach of a category."""
SOUNDS = (".wav", ".flac")
"""Suffixes of the recordings that are written."""


class Real(click.types.FloatParamType):
    """A number; NaN and infinity are refused with the option's name."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number."""
        return _finite(self, super().convert(value, param, ctx), param, ctx)


class RealRange(click.FloatRange):
    """A number within a range; so is NaN of `click.FloatRange`, as it compares with nothing."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number."""
        return _finite(self, super().convert(value, param, ctx), param, ctx)


def _finite(kind: click.ParamType, number: float, param: click.Parameter | None, ctx: click.Context | None) -> float:
    if not math.isfinite(number):
        kind.fail(f"must be a finite number, got {number}", param, ctx)
    return number


def check_output(path: Path, option: str, suffixes: Sequence[str], others: Iterable[Path] = ()) -> None:
    """Refuse, before anything is computed, a file that cannot be written or read again, or that the command uses.

    Args:
        path: the file to be written.
        option: that names it, for the message.
        suffixes: of its name, one of these.
        others: what the command reads, or writes as well.

    Raises:
        ValueError: another suffix, no such folder, a folder in its place, or one of the others, by whichever name.

    >>> check_output(Path("paths.json"), "--paths", (".json",), [Path("walk.flac")])
    """
    if path.suffix.lower() not in suffixes:
        raise ValueError(f"{option} must end in {' or '.join(suffixes)}, got '{path}'")
    if not path.parent.is_dir():
        raise ValueError(f"the folder of '{path}' must exist")
    if path.is_dir():
        raise ValueError(f"{option} must be a file, got the folder '{path}'")
    for other in others:
        if path == other or (path.exists() and other.exists() and path.samefile(other)):
            raise ValueError(f"{option} must be another file than '{other}', got '{path}'")


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


def check_pitch(degrees: float) -> None:
    """Refuse a phone that is pitched beyond upright, or in other units.

    Raises:
        click.UsageError: it is; the message gives rule and value.
    """
    if not abs(degrees) < 90.0:
        raise click.UsageError(f"--pitch must lie between -90 and 90 degrees, got {degrees:g}")
