"""Draw shapes on a common scale."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.patches import FancyBboxPatch, Polygon

from benchmarks.figures.draw.page import finish, panel_axes
from benchmarks.figures.draw.style import INK, PAPER_INK, lighter
from benchmarks.figures.plots import Drawing, DrawingFigure, Shape

_ROLES = {
    "thing": "#8a7a5c",
    "phone": "#1d2430",
    "person": "#6a7280",
    "sound": "#2c5f8a",
    "walk": "#1f8a70",
    "axis": "#6a7280",
    "angle": "#7a5195",
    "hit": PAPER_INK,
    "safe": "#1f8a70",
    "text": INK,
}
BOX = (0.86, 0.62)
_BEHIND_WORDS = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8}


def draw_drawing(figure: DrawingFigure) -> Canvas:
    """The whole figure."""
    panels = figure.panels or (Drawing("no data", (), axes=False),)
    canvas, axes = panel_axes([panel.width_in for panel in panels], 0.22, figure.height_in)
    for ax, panel in zip(axes, panels, strict=True):
        _draw_panel(ax, panel)
    return finish(canvas, figure.title, figure.note)


def _draw_panel(ax: Axes, panel: Drawing) -> None:
    if panel.axes:
        ax.set_aspect("equal", adjustable="box")
    for shape in panel.shapes:
        _draw_shape(ax, shape)
    ax.set(xlim=panel.x_range, ylim=panel.y_range)
    if panel.axes:
        ax.set(xlabel="m", ylabel="m")
        ax.grid(True, axis="both")
    else:
        ax.set_axis_off()
    if panel.title:
        ax.set_title(panel.title)


def _draw_shape(ax: Axes, shape: Shape) -> None:
    shade, (x, y) = _ROLES[shape.role], shape.points[0]
    if shape.kind == "polygon":
        ax.add_patch(Polygon(shape.points, facecolor=lighter(shade, 0.6), edgecolor=shade, linewidth=0.8))
    elif shape.kind == "line":
        dashes = (0, (3, 2)) if shape.role in ("axis", "walk") else "-"
        ax.plot(shape.points[:, 0], shape.points[:, 1], color=shade, linewidth=1.2, linestyle=dashes)
    elif shape.kind == "arrow":
        for start, end in zip(shape.points[:-1], shape.points[1:], strict=True):
            ax.annotate(
                "",
                end,
                start,
                arrowprops={"arrowstyle": "-|>", "color": shade, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0},
            )
    elif shape.kind == "dot":
        ax.plot(x, y, "o", color=shade, markersize=4.5)
    elif shape.kind == "box":
        width, height = BOX
        ax.add_patch(
            FancyBboxPatch(
                (x - width / 2, y - height / 2),
                width,
                height,
                boxstyle="round,pad=0,rounding_size=.06",
                facecolor=lighter(shade, 0.88),
                edgecolor=shade,
                linewidth=1.0,
            )
        )
    if shape.kind == "box":
        ax.text(x, y, shape.text, ha="center", va="center", fontsize=7.5, color=INK)
    elif shape.kind == "text":
        ax.text(x, y, shape.text, ha="center", va="center", fontsize=8.0, color=INK, bbox=_BEHIND_WORDS, zorder=5)
    elif shape.text:
        ax.annotate(shape.text, (x, y), (4, 4), textcoords="offset points", fontsize=8.0, color=shade)
