"""One line says why a cell failed: the type and the first line of the message."""

from __future__ import annotations

import traceback
from collections.abc import Callable

import pytest

from benchmarks.runs.reasons import reason


class OddError(Exception):
    """Of a module of one's own."""


def plain() -> None:
    raise RuntimeError("boom\nsecond line")


def indented() -> None:
    raise ValueError("must be one of\n  this\n  that")


def silent() -> None:
    raise OddError


def later() -> None:
    raise ValueError("\nlevel must be below 0")


def caused() -> None:
    try:
        plain()
    except RuntimeError as error:
        raise TypeError("cannot go on\nat all") from error


def during() -> None:
    try:
        plain()
    except RuntimeError:
        {}["missing"]


def quoting() -> None:
    raise RuntimeError(f"a worker failed\n{text_of(plain)}")


def unreadable() -> None:
    compile("def (\n", "mine.py", "exec")


def leaving() -> None:
    raise SystemExit(0)


def noted() -> None:
    error = RuntimeError("boom")
    error.add_note("a note\nof two lines")
    raise error


def text_of(failing: Callable[[], None]) -> str:
    try:
        failing()
    except (Exception, SystemExit):
        return traceback.format_exc()
    raise AssertionError(failing)


@pytest.mark.parametrize(
    ("failing", "expected"),
    [
        (plain, "RuntimeError: boom"),
        (indented, "ValueError: must be one of"),
        (silent, f"{__name__}.OddError"),
        (later, "ValueError: level must be below 0"),
        (caused, "TypeError: cannot go on"),
        (during, "KeyError: 'missing'"),
        (quoting, "RuntimeError: a worker failed"),
        (unreadable, "SyntaxError: invalid syntax"),
        (leaving, "SystemExit: 0"),
        (noted, "RuntimeError: boom"),
    ],
)
def test_type_and_first_line_are_named(failing: Callable[[], None], expected: str) -> None:
    """Cause: the last line of the traceback was shown, which of "boom, second line" is the second line alone."""
    assert reason(text_of(failing)) == expected


@pytest.mark.parametrize("text", ["", "  ", "no traceback", "ValueError: no <mesh>"])
def test_any_text_has_a_reason(text: str) -> None:
    assert reason(text) == text.strip()
