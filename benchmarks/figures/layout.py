"""Places on the page shared by all figures: panels, title, legend, small print."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas

from benchmarks.figures.style import MUTED

PANEL_HEIGHT, TITLE_ROOM, LEFT_ROOM, LEAST_WIDTH = 2.7, 0.75, 0.65, 6.5
LINE_ROOM = 0.16


def panel_axes(widths_in: Sequence[float], wspace: float = 0.12) -> tuple[Canvas, list[Axes]]:
    """A page with panels of these widths, inches, side by side; `wspace` in widths of a panel."""
    total = max(LEAST_WIDTH, LEFT_ROOM + sum(widths_in) + 0.35 * (len(widths_in) - 1) + 0.15)
    canvas = Canvas(figsize=(total, TITLE_ROOM + PANEL_HEIGHT + 0.6), layout=None)
    grid = canvas.add_gridspec(1, len(widths_in), width_ratios=list(widths_in), wspace=wspace)
    return canvas, [canvas.add_subplot(grid[0, k]) for k in range(len(widths_in))]


def finish(canvas: Canvas, title: str, note: str, handles: Sequence[Artist] = ()) -> Canvas:
    """Title on top, legend under it, small print at the bottom."""
    width, height = canvas.get_size_inches()
    lines = textwrap.wrap(note, int(width * 17.5))
    bottom = 0.66 + LINE_ROOM * len(lines)
    height += LINE_ROOM * len(lines)
    canvas.set_size_inches(width, height)
    top = TITLE_ROOM if handles else 0.55
    canvas.subplots_adjust(
        left=LEFT_ROOM / width, right=1.0 - 0.12 / width, top=1.0 - (top + 0.1) / height, bottom=bottom / height
    )
    canvas.text(0.12 / width, 1.0 - 0.12 / height, title, ha="left", va="top", fontsize=11.0, fontweight="bold")
    if handles:
        canvas.legend(
            handles=list(handles), loc="upper left", ncols=4, borderpad=0.0, borderaxespad=0.0, columnspacing=1.4,
            bbox_to_anchor=(0.12 / width, 1.0 - 0.42 / height), handlelength=1.4,
        )  # fmt: skip
    canvas.text(0.12 / width, 0.08 / height, "\n".join(lines), ha="left", va="bottom", fontsize=7.5, color=MUTED)
    return canvas
