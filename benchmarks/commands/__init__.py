"""Subcommands of `obstaclewatch`, one module each.

They import what they work with when they run: `obstaclewatch run --help` answers at once.
"""

from __future__ import annotations

from collections.abc import Iterable

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


def check_pitch(degrees: float) -> None:
    """Refuse a phone that is pitched beyond upright, or in other units.

    Raises:
        click.UsageError: it is; the message gives rule and value.
    """
    if not abs(degrees) < 90.0:
        raise click.UsageError(f"--pitch must lie between -90 and 90 degrees, got {degrees:g}")
