"""Words for people: how many there are of something."""

from __future__ import annotations


def counted(count: int, one: str, many: str = "") -> str:
    """A number and what it counts, one of them or several.

    Args:
        one: what one of them is called.
        many: what several are called; `one` and an s unless given.

    >>> counted(1, "cell"), counted(0, "cell"), counted(2, "cell is missing", "cells are missing")
    ('1 cell', '0 cells', '2 cells are missing')
    """
    return f"{count} {one if count == 1 else many or f'{one}s'}"
