"""Figures of bars, curves, lines and images as Plotly draws them: to hover over, to zoom, to switch series off."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.figures.data import Bar, BarFigure, BarPanel, CurveFigure
from benchmarks.figures.draw.bars import shade
from benchmarks.figures.draw.curves import axis_end
from benchmarks.figures.draw.style import HAIR, INK, MUTED, PAPER_INK, colour, series_colour
from benchmarks.figures.plots import Figure, Floats, Guide, Line, Panel, PlotFigure
from scenes.preview.plotly_page import packed_array

Parts = dict[str, Any]

PAGE_IN, ROW_PX, HEAD_PX, GAP = 9.0, 300, 140, 0.09
CLEAR = "rgba(0,0,0,0)"
_DASHES = {"dashed": "dash", "dotted": "dot"}


def interactive(figure: Figure) -> Parts | None:
    """Data and layout, ready for JSON; None for drawings and tables, which have nothing to switch."""
    if figure.empty:
        return None
    if isinstance(figure, BarFigure):
        wide = [0.9 * len(panel.bars) for panel in figure.panels]
        traces = [_bar_traces(panel, figure.unit) for panel in figure.panels]
        axes: list[tuple[Parts, Parts]] = [
            ({}, _titled(figure.y_label) | {"rangemode": "tozero", "matches": "y"}) for _ in figure.panels
        ]
        return _page(figure.title, [panel.title for panel in figure.panels], wide, traces, axes, [()] * len(axes))
    if isinstance(figure, CurveFigure):
        axis = _titled(figure.x_label) | {"range": [0.0, axis_end(figure)]}
        share = _titled("share of the estimates (%)") | {"range": [0.0, 103.0]}
        return _page(figure.title, [""], [PAGE_IN], [_curve_traces(figure)], [(axis, share)], [()])
    if not isinstance(figure, PlotFigure):
        return None
    shared = all(not panel.y_label for panel in figure.panels[1:])
    drawn = [panel for panel in figure.panels if panel.lines or panel.image]
    page = _page(
        figure.title,
        [panel.title.replace("\n", "<br>") for panel in drawn],
        [panel.width_in for panel in drawn],
        [_line_traces(panel) for panel in drawn],
        [_plot_axes(panel, figure.panels[0].y_label if shared else panel.y_label) for panel in drawn],
        [panel.guides for panel in drawn],
    )
    if any(line.style == "parts" for panel in drawn for line in panel.lines):
        page["layout"]["barmode"] = "stack"
    return page


def _titled(words: str) -> Parts:
    return {"title": {"text": words}}


def _page(
    heading: str,
    titles: list[str],
    widths_in: list[float],
    traces: list[list[Parts]],
    axes: list[tuple[Parts, Parts]],
    guides: list[Any],
) -> Parts:
    """Panels in a grid; one legend, in which series of one name are switched together."""
    columns = max(1, min(len(titles), int(PAGE_IN / max(widths_in))))
    rows = -(-len(titles) // columns)
    inside = rows * ROW_PX
    layout: Parts = {
        "height": HEAD_PX + inside, "barmode": "group", "paper_bgcolor": CLEAR, "plot_bgcolor": CLEAR,
        "title": {"text": f"<b>{heading}</b>", "x": 0, "y": 1, "yanchor": "top", "pad": {"t": 10}},
        "font": {"color": INK},
        "margin": {"l": 60, "r": 20, "t": 60, "b": HEAD_PX - 60}, "modebar": {"bgcolor": CLEAR, "color": MUTED},
        "grid": {"rows": rows, "columns": columns, "pattern": "independent", "xgap": GAP * columns, "ygap": 0.3},
        "legend": {"orientation": "h", "x": 0, "y": -55.0 / inside, "yanchor": "top"}, "shapes": [],
        "annotations": [],
    }  # fmt: skip
    data, named = [], set()
    for k, (title, lines, (x_axis, y_axis)) in enumerate(zip(titles, traces, axes, strict=True)):
        mark = str(k + 1) if k else ""
        plain = {"gridcolor": HAIR, "zeroline": False, "automargin": True}
        layout["xaxis" + mark], layout["yaxis" + mark] = plain | x_axis, plain | y_axis
        for line in lines:
            name = line.get("name", "")
            shown = {"legendgroup": name, "showlegend": bool(name) and name not in named}
            data.append(line | shown | {"xaxis": f"x{mark}", "yaxis": f"y{mark}"})
            named.add(name)
        head = {"text": f"<b>{title}</b>", "x": 0, "xanchor": "left", "y": 1, "yanchor": "bottom"}
        layout["annotations"].append(head | {"xref": f"x{mark} domain", "yref": f"y{mark} domain", "showarrow": False})
        for guide in guides[k]:
            layout["shapes"].append(_guide(guide, mark))
    return {"data": data, "layout": layout}


def _guide(guide: Guide, mark: str) -> Parts:
    across = "y" if guide.axis == "x" else "x"
    line = {"color": series_colour(guide.key), "width": 1, "dash": "dot"}
    words = {"label": {"text": guide.text, "textposition": "end", "font": {"size": 10}}} if guide.text else {}
    ends = {f"{guide.axis}0": guide.at, f"{guide.axis}1": guide.at, f"{across}0": 0, f"{across}1": 1}
    refs = {f"{guide.axis}ref": f"{guide.axis}{mark}", f"{across}ref": f"{across}{mark} domain"}
    return {"type": "line", "line": line} | ends | refs | words


def _bar_traces(panel: BarPanel, unit: str) -> list[Parts]:
    traces = []
    for name in panel.series:
        mine = [bar for bar in panel.bars if bar.series == name]
        traces.append(_bars(mine, name, [shade(panel, bar) for bar in mine], unit))
        held = [bar for bar in mine if bar.paper is not None]
        if held:
            traces.append(_paper_bars(held, name, unit))
    return traces


def _bars(bars: list[Bar], name: str, shades: list[str], unit: str) -> Parts:
    value, low, high = (np.array([getattr(bar, end) for bar in bars]) for end in ("value", "low", "high"))
    return {
        "type": "bar", "name": name, "x": [_flat(bar.group) for bar in bars], "y": packed_array(value),
        "offsetgroup": name, "marker": {"color": shades}, "error_y": _whiskers(value, low, high),
        "hovertext": [f"{bar.value:.1f} {unit} ({bar.low:.1f} to {bar.high:.1f}), {bar.count}" for bar in bars],
        "text": [bar.count for bar in bars], "textposition": "inside", "insidetextanchor": "start",
    }  # fmt: skip


def _paper_bars(bars: list[Bar], series: str, unit: str) -> Parts:
    papers = [bar.paper for bar in bars if bar.paper is not None]
    return {
        "type": "bar", "name": "the paper", "x": [_flat(bar.group) for bar in bars],
        "y": packed_array([paper.display for paper in papers]), "offsetgroup": f"paper, {series}",
        "marker": {"color": "white", "line": {"color": PAPER_INK, "width": 1},
                   "pattern": {"shape": "/", "fgcolor": PAPER_INK}},
        "hovertext": [f"{series}: {paper.short} {unit}, {paper.source}" for paper in papers],
    }  # fmt: skip


def _curve_traces(figure: CurveFigure) -> list[Parts]:
    traces: list[Parts] = [
        {
            "type": "scatter", "mode": "lines", "name": curve.label, "hovertext": curve.summary,
            "x": packed_array([0.0, *curve.value]), "y": packed_array([0.0, *(100.0 * curve.share)]),
            "line": {"shape": "hv", "color": colour(curve.key), "width": 1 if curve.diagnostic else 2,
                     "dash": "dot" if curve.diagnostic else "dash" if curve.dashed else "solid"},
        }
        for curve in figure.curves if curve.n
    ]  # fmt: skip
    marks = [
        {
            "type": "scatter", "mode": "markers", "name": f"paper, {mark.label}: {mark.paper.text}",
            "x": [mark.paper.display], "y": [100.0 * mark.share],
            "marker": {"symbol": f"{mark.shape}-open", "color": PAPER_INK, "size": 11},
        }
        for mark in figure.marks
    ]  # fmt: skip
    return traces + marks


def _line_traces(panel: Panel) -> list[Parts]:
    field = panel.image
    image = [] if field is None else [{
        "type": "heatmap", "x": packed_array(field.x), "y": packed_array(field.y), "z": packed_array(field.values),
        "zmin": field.low, "zmax": field.high, "colorscale": "Cividis", "colorbar": {"title": {"text": field.label}},
    }]  # fmt: skip
    return [*image, *(_line(line, panel) for line in panel.lines)]


def _line(line: Line, panel: Panel) -> Parts:
    points, paint = line.style in ("points", "ring", "faint"), series_colour(line.key)
    if line.style == "parts":
        return {
            "type": "bar", "orientation": "h", "name": line.label, "marker": {"color": paint},
            "x": packed_array(line.x, "f8"), "y": packed_array(line.y, "f8"),
        }  # fmt: skip
    error = {}
    if len(line.low):
        middle = line.x if panel.flat else line.y
        error = {"error_x" if panel.flat else "error_y": _whiskers(middle, line.low, line.high)}
    return {
        "type": "scatter", "name": line.label, "mode": "markers" if points else "lines",
        "x": packed_array(line.x, "f8"), "y": packed_array(line.y, "f8"),
        "line": {"color": paint, "shape": "hv" if line.style == "steps" else "linear",
                 "dash": _DASHES.get(line.style, "solid")},
        "marker": {"color": paint, "size": 8, "symbol": "diamond-open" if line.style == "ring" else "circle"},
    } | error  # fmt: skip


def _plot_axes(panel: Panel, y_label: str) -> tuple[Parts, Parts]:
    x: Parts = _titled(panel.x_label) | _scale("x" in panel.log, panel.x_range)
    y: Parts = _titled(y_label) | _scale("y" in panel.log, panel.y_range)
    if panel.places:
        at, names = zip(*panel.places, strict=True)
        x, y = (axis | {"tickvals": at, "ticktext": names} for axis in (x, y))
    if panel.ticks:
        count = len(panel.ticks)
        named = {"tickvals": list(range(count)), "ticktext": [tick.replace("\n", "<br>") for tick in panel.ticks]}
        if panel.flat:
            y |= named | {"range": [count - 0.5, -0.5]}
        else:
            x |= named | {"range": [-0.5, count - 0.5]}
    return x, y


def _scale(logarithmic: bool, ends: tuple[float, float] | None) -> Parts:
    if ends is not None and logarithmic:
        ends = (float(np.log10(ends[0])), float(np.log10(ends[1])))
    return ({"type": "log"} if logarithmic else {}) | ({} if ends is None else {"range": list(ends)})


def _whiskers(value: Floats, low: Floats, high: Floats) -> Parts:
    up, down = (np.maximum(0.0, np.nan_to_num(each)) for each in (high - value, value - low))
    return {"type": "data", "symmetric": False, "array": packed_array(up), "arrayminus": packed_array(down),
            "color": INK, "thickness": 1, "width": 3}  # fmt: skip


def _flat(words: str) -> str:
    return words.replace("\n", " ")
