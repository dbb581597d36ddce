"""Places on the page shared by all figures: panels, title, legend, small print."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from benchmarks.figures.draw.style import MUTED

PANEL_HEIGHT, TITLE_ROOM, LEFT_ROOM, LEAST_WIDTH = 2.7, 0.75, 0.65, 6.5
LINE_ROOM, ROW_ROOM = 0.16, 0.85
WIDEST = 9.6
"""Inches of a row of panels: in a report of 900 pixels its text is as large as the report's small print."""


def panel_axes(
    widths_in: Sequence[float], wspace: float = 0.12, height_in: float = PANEL_HEIGHT, names_in: float = 0.0
) -> tuple[Canvas, list[Axes]]:
    """A page with panels of these widths, inches, side by side, in as many rows as fit on it.

    `wspace` is in widths of a panel, `names_in` what names take to the left of each row.
    """
    gap = max(0.35, wspace * sum(widths_in) / len(widths_in))
    rows = _rows(widths_in, gap, WIDEST - LEFT_ROOM - names_in)
    widest = max(sum(row) + gap * (len(row) - 1) for row in rows)
    height = len(rows) * (height_in + ROW_ROOM) - ROW_ROOM
    canvas = Canvas(figsize=(max(LEAST_WIDTH, LEFT_ROOM + widest + 0.15), TITLE_ROOM + height + 0.6), layout=None)
    outer = canvas.add_gridspec(len(rows), 1, hspace=ROW_ROOM / height_in)
    axes = []
    for number, row in enumerate(rows):
        spare = widest - sum(row) - gap * (len(row) - 1)
        ratios = [*row, spare - gap] if spare > gap else row
        inner = outer[number].subgridspec(1, len(ratios), width_ratios=ratios, wspace=wspace)
        axes += [canvas.add_subplot(inner[0, k]) for k in range(len(row))]
    return canvas, axes


def leads_row(ax: Axes) -> bool:
    """Whether it is the first of a row of panels, which shows the names of what they share."""
    place = ax.get_subplotspec()
    return place is not None and bool(place.is_first_col())


def _rows(widths_in: Sequence[float], gap_in: float, most_in: float) -> list[list[float]]:
    rows: list[list[float]] = [[]]
    for width in widths_in:
        if rows[-1] and sum(rows[-1]) + width + gap_in * len(rows[-1]) > most_in:
            rows.append([])
        rows[-1].append(width)
    return rows


def finish(
    canvas: Canvas,
    title: str,
    note: str,
    handles: Sequence[Artist] = (),
    labels: Sequence[str] | None = None,
    extra_left: float = 0.0,
    extra_right: float = 0.0,
) -> Canvas:
    """Title on top, legend under it, small print at the bottom; inches more for names and scales at the sides."""
    width, height = canvas.get_size_inches()
    width += extra_left + extra_right
    lines = textwrap.wrap(note, int(width * 17.5))
    bottom = 0.66 + LINE_ROOM * len(lines)
    height += LINE_ROOM * len(lines)
    columns = _columns(handles, labels, width)
    rows = -(-len(handles) // columns)
    height += 0.19 * max(0, rows - 1)
    canvas.set_size_inches(width, height)
    top = TITLE_ROOM + 0.19 * max(0, rows - 1) if handles else 0.55
    if any(ax.get_title(loc="left") for ax in canvas.axes):
        top += 0.12
    canvas.subplots_adjust(
        left=(LEFT_ROOM + extra_left) / width,
        right=1.0 - (0.12 + extra_right) / width,
        top=1.0 - (top + 0.1) / height,
        bottom=bottom / height,
    )
    canvas.text(0.12 / width, 1.0 - 0.12 / height, title, ha="left", va="top", fontsize=11.0, fontweight="bold")
    if handles:
        canvas.legend(
            list(handles), [str(h.get_label()) for h in handles] if labels is None else list(labels),
            loc="upper left", ncols=columns, borderpad=0.0, borderaxespad=0.0, columnspacing=1.4,
            bbox_to_anchor=(0.12 / width, 1.0 - 0.42 / height), handlelength=1.4,
        )  # fmt: skip
    canvas.text(0.12 / width, 0.08 / height, "\n".join(lines), ha="left", va="bottom", fontsize=7.5, color=MUTED)
    return canvas


def _columns(handles: Sequence[Artist], labels: Sequence[str] | None, width_in: float) -> int:
    """How many legend entries fit side by side."""
    names = [str(handle.get_label()) for handle in handles] if labels is None else list(labels)
    longest = max((len(name) for name in names), default=1)
    return max(1, min(4, int((width_in - 0.3) / (0.062 * longest + 0.45))))
