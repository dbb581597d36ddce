"""What a figure of curves, images, drawings or cells shows, apart from how it is drawn; see `data` for bars.

Numbers are in the unit people read, which the axis names. NaN is a gap.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures.data import BarFigure, CurveFigure, Row

Floats = NDArray[np.floating]
Style = Literal["line", "dashed", "dotted", "points", "steps", "ring", "faint", "parts"]
NOTHING = np.zeros(0)


@dataclass(frozen=True)
class Line:
    """One series.

    Attributes:
        label: in the legend; lines of one label share an entry, an empty one has none.
        key: colour: the name of a detector or a category, "paper", "muted", or a digit for the palette.
        x, y: (n,) values.
        style: how it is drawn; "parts" are bars across a flat panel, each after those of the lines before it.
        low, high: (n,) ends of the whiskers; empty without.
    """

    label: str
    key: str
    x: Floats
    y: Floats
    style: Style = "line"
    low: Floats = field(default_factory=lambda: NOTHING)
    high: Floats = field(default_factory=lambda: NOTHING)


@dataclass(frozen=True)
class Guide:
    """A straight line for the eye, across ("y") or up ("x") at a value, and its words."""

    axis: Literal["x", "y"]
    at: float
    text: str
    key: str = "muted"


@dataclass(frozen=True)
class Image:
    """A field over both axes: (n + 1,) edges in x, (m + 1,) in y, (m, n) values and what they are."""

    x: Floats
    y: Floats
    values: Floats
    label: str
    low: float
    high: float


@dataclass(frozen=True)
class Panel:
    """One pair of axes.

    Attributes:
        lines, guides, image: what is in them.
        log: "x", "y", "xy" or "".
        x_range, y_range: ends of the axes; None fits the data.
        ticks: names at 0, 1, 2 ... of the x axis, for what is not a number; empty for numbers.
        places: places on both axes and their names, for scales that are not linear in what they show.
        flat: ticks name the y axis instead, from the top down.
        width_in: inches.
    """

    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    guides: tuple[Guide, ...] = ()
    image: Image | None = None
    log: Literal["", "x", "y", "xy"] = ""
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    ticks: tuple[str, ...] = ()
    places: tuple[tuple[float, str], ...] = ()
    flat: bool = False
    width_in: float = 3.4


@dataclass(frozen=True)
class PlotFigure:
    """Panels of lines and images side by side.

    Attributes:
        name: file stem.
        reading: a sentence or two made from the numbers.
        note: small print under the figure.
        height_in: of the axes, inches.
    """

    name: str
    title: str
    panels: tuple[Panel, ...]
    reading: str
    note: str = ""
    height_in: float = 2.7

    @property
    def empty(self) -> bool:
        """Whether nothing was measured; muted lines are for the eye."""
        lines = [line for panel in self.panels for line in panel.lines if line.key != "muted"]
        return not any(np.isfinite(line.y).any() for line in lines)

    def rows(self) -> Iterator[Row]:
        """The csv, one row a point of a line, and one a cell of an image."""
        for panel in self.panels:
            for line in panel.lines:
                ends = zip(line.low, line.high, strict=True) if len(line.low) else ((np.nan, np.nan) for _ in line.x)
                for x, y, (low, high) in zip(line.x.tolist(), line.y.tolist(), ends, strict=True):
                    name = _tick(panel, y if panel.flat else x)
                    yield _row(panel, line.label, x, y, float(low), float(high), name)
            if panel.image is not None:
                middle = [0.5 * (edge[1:] + edge[:-1]) for edge in (panel.image.x, panel.image.y)]
                for x, column in zip(middle[0].tolist(), panel.image.values.T, strict=True):
                    for y, value in zip(middle[1].tolist(), column.tolist(), strict=True):
                        yield _row(panel, panel.image.label, x, y, float(value), float(value), "")


Role = Literal["thing", "phone", "person", "sound", "walk", "axis", "angle", "hit", "safe", "text"]


@dataclass(frozen=True)
class Shape:
    """A part of a drawing, its points in metres (or in units of a box for a flow chart).

    Attributes:
        kind: "polygon", "line", "arrow", "dot", "box" (first point is its middle) or "text".
        points: (n, 2).
        role: what it stands for, which gives its colour.
        text: words at its first point.
    """

    kind: Literal["polygon", "line", "arrow", "dot", "box", "text"]
    points: Floats
    role: Role
    text: str = ""


@dataclass(frozen=True)
class Drawing:
    """Shapes on a common scale; `axes` shows a scale in metres."""

    title: str
    shapes: tuple[Shape, ...]
    axes: bool = True
    width_in: float = 3.6
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None


@dataclass(frozen=True)
class DrawingFigure:
    """Drawings side by side, made from the objects of the bench themselves."""

    name: str
    title: str
    panels: tuple[Drawing, ...]
    reading: str
    note: str = ""
    height_in: float = 3.0

    @property
    def empty(self) -> bool:
        """Whether nothing is drawn."""
        return not any(panel.shapes for panel in self.panels)

    def rows(self) -> Iterator[Row]:
        """The csv, one row a point."""
        for panel in self.panels:
            for number, shape in enumerate(panel.shapes):
                for x, y in shape.points.tolist():
                    yield {"panel": panel.title, "shape": number, "kind": shape.kind, "role": shape.role,
                           "text": shape.text.replace("\n", " "), "x_m": x, "y_m": y}  # fmt: skip


@dataclass(frozen=True)
class TableFigure:
    """Words and numbers in rows.

    Attributes:
        columns: heads.
        cells: (rows, columns) text.
        widths: relative widths of the columns.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    widths: tuple[float, ...]
    reading: str
    note: str = ""

    @property
    def empty(self) -> bool:
        """Whether there is no row."""
        return not self.cells

    def rows(self) -> Iterator[Row]:
        """The csv: the table itself."""
        for cells in self.cells:
            yield dict(zip(self.columns, cells, strict=True))


Figure = BarFigure | CurveFigure | PlotFigure | DrawingFigure | TableFigure
"""Whatever a builder makes."""


def _tick(panel: Panel, place: float) -> str:
    return panel.ticks[round(place)].replace("\n", " ") if panel.ticks else ""


def _row(panel: Panel, series: str, x: float, y: float, low: float, high: float, name: str) -> Row:
    return {"panel": panel.title.replace("\n", " "), "series": series, "x": x, "y": y, "low": low, "high": high,
            "name": name}  # fmt: skip
