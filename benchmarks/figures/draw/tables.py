"""Draw tables: one wider than the page in parts, one below the other."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from benchmarks.figures.draw.page import WIDEST, finish, panel_axes
from benchmarks.figures.draw.style import HAIR, MUTED
from benchmarks.figures.plots import TableFigure

LINE_IN, AROUND_ROW_IN, BETWEEN_PARTS_IN = 0.145, 0.125, 0.25
CHARACTERS_PER_INCH, HEAD_CHARACTERS_PER_INCH = 15.0, 11.5

Part = tuple[list[int], list[list[str]], list[int]]
"""Columns, then head and rows with their text wrapped, then how many lines each of these takes."""


def draw_table(figure: TableFigure) -> Canvas:
    """A table as a picture: heads, a rule, rows; long text wraps.

    Where its columns are wider than the page, those that do not fit follow below, after the first column once more.
    """
    parts = [_part(figure, columns) for columns in columns_by_part(figure.widths, WIDEST)]
    height = sum(map(_height_in, parts)) + BETWEEN_PARTS_IN * (len(parts) - 1)
    total = max(sum(figure.widths[k] for k in columns) for columns, _, _ in parts)
    canvas, (ax,) = panel_axes([total], 0.0, height)
    ax.set_axis_off()
    ax.set(xlim=(0.0, total), ylim=(height, 0.0))
    here = 0.0
    for part in parts:
        _draw_part(ax, figure, part, here)
        here += _height_in(part) + BETWEEN_PARTS_IN
    return finish(canvas, figure.title, figure.note, extra_left=-0.5)


def columns_by_part(widths: Sequence[float], most: float) -> list[list[int]]:
    """Columns side by side within a width; every part begins with the first column.

    >>> columns_by_part([2.0, 3.0, 3.0, 4.0], most=9.0)
    [[0, 1, 2], [0, 3]]
    """
    parts = [[0]]
    for column in range(1, len(widths)):
        if len(parts[-1]) > 1 and sum(widths[k] for k in [*parts[-1], column]) > most:
            parts.append([0])
        parts[-1].append(column)
    return parts


def _part(figure: TableFigure, columns: list[int]) -> Part:
    per_inch = [HEAD_CHARACTERS_PER_INCH, *(CHARACTERS_PER_INCH for _ in figure.cells)]
    rows = [
        [_wrapped(row[k], figure.widths[k] * characters) for k in columns]
        for row, characters in zip([figure.columns, *figure.cells], per_inch, strict=True)
    ]
    return columns, rows, [max(text.count("\n") + 1 for text in row) for row in rows]


def _height_in(part: Part) -> float:
    return LINE_IN * sum(part[2]) + AROUND_ROW_IN * len(part[2])


def _draw_part(ax: Axes, figure: TableFigure, part: Part, top: float) -> None:
    columns, rows, lines = part
    total, here = sum(figure.widths[k] for k in columns), top
    for number, (row, count) in enumerate(zip(rows, lines, strict=True)):
        head, x = number == 0, 0.0
        size, weight = (8.5, "bold") if head else (8.0, "normal")
        for column, text in zip(columns, row, strict=True):
            ax.text(x, here + 0.35 * AROUND_ROW_IN, text, va="top", fontsize=size, fontweight=weight, linespacing=1.25)
            x += figure.widths[column]
        here += LINE_IN * count + AROUND_ROW_IN
        ax.plot([0.0, total], [here, here], color=MUTED if head else HAIR, linewidth=0.8 if head else 0.6)


def _wrapped(text: str, characters: float) -> str:
    return "\n".join(textwrap.wrap(text, max(4, int(characters)))) or " "
