"""Draw panels of lines, points and images."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import ticker
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure as Canvas

from benchmarks.figures.draw.page import finish, leads_row, panel_axes
from benchmarks.figures.draw.style import MUTED, series_colour
from benchmarks.figures.plots import Guide, Image, Line, Panel, PlotFigure

_STYLES: dict[str, dict[str, Any]] = {
    "line": {"linestyle": "-"},
    "dashed": {"linestyle": (0, (4, 1.6))},
    "dotted": {"linestyle": (0, (1, 1.4))},
    "steps": {"linestyle": "-", "drawstyle": "steps-post"},
    "points": {"linestyle": "none", "marker": "o", "markersize": 4.0},
    "ring": {"linestyle": "none", "marker": "D", "markersize": 5.5, "markerfacecolor": "white"},
    "faint": {"linestyle": "none", "marker": "o", "markersize": 3.5, "alpha": 0.35},
}
_BEHIND_WORDS = {"facecolor": "white", "alpha": 0.8, "linewidth": 0.0, "pad": 0.6}
LEAST_NAMED = 3.5
"""Width of a part of a bar, in the axis's unit, below which its number has no room."""
FEW_DECADES = 2.5
"""Below which powers of ten are too few to read a scale by."""


def draw_plots(figure: PlotFigure) -> Canvas:
    """The whole figure; one legend on top for all panels."""
    panels = figure.panels or (Panel("", "", "", ()),)
    wide = max(panel.width_in for panel in panels)
    shared = all(not panel.y_label for panel in panels[1:])
    gap = 0.07 if shared else 0.24
    left = max(_tick_room(panel) for panel in panels)
    between = gap * 3.4 + (0.0 if shared else left)
    canvas, axes = panel_axes([panel.width_in for panel in panels], between / wide, figure.height_in, left)
    handles: dict[str, Artist] = {}
    for ax, panel in zip(axes, panels, strict=True):
        _draw_panel(ax, panel)
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    for ax in axes if shared else ():
        if not leads_row(ax):
            ax.tick_params(axis="y", labelleft=False)
        elif panels[0].y_label:
            ax.set_ylabel(panels[0].y_label)
    last = panels[-1].image
    if last is not None:
        _add_scale(canvas, axes[-1], last)
    right = 0.75 if last is not None else 0.0
    return finish(canvas, figure.title, figure.note, list(handles.values()), list(handles), left, right)


def _tick_room(panel: Panel) -> float:
    """Inches that the names on a flat panel's axis take beyond those of numbers."""
    return 0.062 * max(map(len, panel.ticks)) - 0.3 if panel.flat and panel.ticks else 0.0


def _draw_panel(ax: Axes, panel: Panel) -> None:
    if "x" in panel.log:
        ax.set_xscale("log")
    if "y" in panel.log:
        ax.set_yscale("log")
    if panel.image is not None:
        _draw_image(ax, panel.image)
    for line in panel.lines:
        if line.style != "parts":
            _draw_line(ax, line, panel.flat)
    _draw_parts(ax, [line for line in panel.lines if line.style == "parts"])
    ax.set(xlabel=panel.x_label, ylabel=panel.y_label)
    ax.grid(True, axis="both")
    if panel.x_range is not None:
        ax.set_xlim(*panel.x_range)
    if panel.y_range is not None:
        ax.set_ylim(*panel.y_range)
    for axis in (ax.xaxis, ax.yaxis):
        _number_few_decades(axis)
    _name_ticks(ax, panel)
    for guide in panel.guides:
        _draw_guide(ax, guide)
    if panel.title:
        ax.set_title(panel.title)
    if panel.image is None and not any(np.isfinite(line.y).any() for line in panel.lines):
        ax.text(0.5, 0.5, "no data", transform=ax.transAxes, ha="center", color=MUTED, fontsize=14)


def _number_few_decades(axis: Axis) -> None:
    """On a logarithmic axis of few decades, numbers at 1, 2 and 5 of each."""
    low, high = axis.get_view_interval()
    if axis.get_scale() != "log" or np.log10(high / low) > FEW_DECADES:
        return
    axis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    axis.set_minor_formatter(ticker.NullFormatter())


def _name_ticks(ax: Axes, panel: Panel) -> None:
    if panel.places:
        at, names = zip(*panel.places, strict=True)
        ax.set_xticks(at, names)
        ax.set_yticks(at, names)
    if not panel.ticks:
        return
    places = np.arange(len(panel.ticks))
    if panel.flat:
        ax.set_yticks(places, panel.ticks)
        ax.set_ylim(len(places) - 0.5, -0.5)
    else:
        ax.set_xticks(places, panel.ticks)
        ax.set_xlim(-0.5, len(places) - 0.5)


def _draw_line(ax: Axes, line: Line, flat: bool) -> None:
    shade = series_colour(line.key)
    label = line.label or "_"
    if len(line.low):
        spread = np.abs(np.stack([line.low, line.high]) - (line.x if flat else line.y))
        error: dict[str, Any] = {"xerr": spread} if flat else {"yerr": spread}
        ax.errorbar(line.x, line.y, **error, fmt="none", ecolor=shade, elinewidth=1.0, capsize=2.0)
    ax.plot(line.x, line.y, color=shade, markeredgecolor=shade, linewidth=1.5, label=label, **_STYLES[line.style])


def _draw_parts(ax: Axes, lines: Sequence[Line]) -> None:
    """Bars across, one a place, made of the lines' parts; each with its number where there is room."""
    begin = np.zeros(len(lines[0].x)) if lines else np.zeros(0)
    for line in lines:
        bars = ax.barh(line.y, line.x, 0.62, left=begin, color=series_colour(line.key), label=line.label, linewidth=0)
        numbers = [f"{part:.0f}" if part >= LEAST_NAMED else "" for part in line.x]
        ax.bar_label(bars, numbers, label_type="center", color="white", fontsize=8, fontweight="bold")
        begin = begin + np.nan_to_num(line.x)


def _draw_guide(ax: Axes, guide: Guide) -> None:
    shade = series_colour(guide.key)
    if guide.axis == "x":
        ax.axvline(guide.at, color=shade, linewidth=0.9, linestyle=(0, (2, 2)))
        ax.annotate(
            guide.text,
            (guide.at, 0.985),
            (3, 0),
            xycoords=ax.get_xaxis_transform(),
            rotation=90,
            textcoords="offset points",
            ha="left",
            va="top",
            color=shade,
            fontsize=7.5,
            bbox=_BEHIND_WORDS,
        )
    else:
        ax.axhline(guide.at, color=shade, linewidth=0.9, linestyle=(0, (2, 2)))
        ax.annotate(
            guide.text,
            (0.99, guide.at),
            (0, 2),
            xycoords=ax.get_yaxis_transform(),
            textcoords="offset points",
            ha="right",
            va="bottom",
            color=shade,
            fontsize=7.5,
        )


def _draw_image(ax: Axes, image: Image) -> None:
    ax.pcolormesh(image.x, image.y, image.values, cmap="cividis", vmin=image.low, vmax=image.high, rasterized=True)


def _add_scale(canvas: Canvas, ax: Axes, image: Image) -> None:
    inside = ax.inset_axes((1.02, 0.0, 0.03, 1.0))
    canvas.colorbar(ax.collections[0], cax=inside, label=image.label)
