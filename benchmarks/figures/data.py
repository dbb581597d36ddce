"""What a figure shows, apart from how it is drawn: the same numbers go to the picture, the csv and the report.

Numbers here are in the unit people read, which the figure names (%, cm or degrees). NaN is "no data".
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.scoring.paper_values import PaperValue
from obstaclewatch.support.arrays import Floats

Row = dict[str, str | int | float]

MOST_POINTS = 400
"""Points kept of a curve; each is a step of the full distribution."""


@dataclass(frozen=True)
class Bar:
    """One bar with its 95 % interval.

    Attributes:
        group, series: where it stands and what it measures.
        value, low, high: in the figure's unit; NaN without data.
        count: what is printed at its foot, "42/48" or "310".
        n: number of observations.
        paper: the paper's value of the same quantity, if it prints one.
    """

    group: str
    series: str
    value: float
    low: float
    high: float
    count: str
    n: int
    paper: PaperValue | None = None


@dataclass(frozen=True)
class BarPanel:
    """Bars side by side: series within groups, in order of first appearance.

    Attributes:
        title: the detector that the panel is about; empty if its groups are detectors.
    """

    title: str
    bars: tuple[Bar, ...]

    @property
    def groups(self) -> list[str]:
        """Names of the groups, in order."""
        return list(dict.fromkeys(bar.group for bar in self.bars))

    @property
    def series(self) -> list[str]:
        """Names of the series, in order."""
        return list(dict.fromkeys(bar.series for bar in self.bars))


@dataclass(frozen=True)
class BarFigure:
    """Grouped bars.

    Attributes:
        name: file stem.
        unit: of the values: "%", "cm" or "°".
        top: upper end of the axis; None fits the data.
        note: small print under the figure.
        reading: one sentence made from the numbers.
    """

    name: str
    title: str
    y_label: str
    unit: str
    panels: tuple[BarPanel, ...]
    reading: str
    note: str = ""
    top: float | None = None

    @property
    def empty(self) -> bool:
        """Whether nothing was measured."""
        return all(bar.n == 0 for panel in self.panels for bar in panel.bars)

    def rows(self) -> Iterator[Row]:
        """The csv, one row a bar."""
        for panel in self.panels:
            for bar in panel.bars:
                yield {
                    "panel": panel.title,
                    "group": bar.group.replace("\n", " "),
                    "series": bar.series,
                    "value": bar.value,
                    "low": bar.low,
                    "high": bar.high,
                    "unit": self.unit,
                    "count": bar.count,
                    "n": bar.n,
                    "paper": "" if bar.paper is None else bar.paper.short,
                }


@dataclass(frozen=True)
class Curve:
    """An empirical distribution function.

    Attributes:
        label: in the legend.
        key: colour: a detector's name.
        dashed: whether it is drawn dashed.
        value, share: (K,) steps: this share of the estimates has at most this error.
        n, total: estimates, and beeps that could have given one.
        summary: median and the like for the legend, parted by semicolons.
        diagnostic: drawn thin and dotted, its summary left to the figure's reading: not held against the paper.
    """

    label: str
    key: str
    dashed: bool
    value: Floats
    share: Floats
    n: int
    total: int
    summary: str
    diagnostic: bool = False


Shape = Literal["diamond", "circle", "square"]


@dataclass(frozen=True)
class Mark:
    """A point of the paper's own curve: this share of its errors is at most the value.

    Attributes:
        shape: by which the same quantity is known in figures beside each other.
    """

    label: str
    share: float
    paper: PaperValue
    shape: Shape


@dataclass(frozen=True)
class CurveFigure:
    """Distribution functions of an error over one axis, and the paper's points among them.

    Attributes:
        name: file stem.
        unit: of the errors: "cm" or "°".
        note: small print under the figure.
        reading: one sentence made from the numbers.
        reach: what the axis must hold besides, for figures that are compared.
    """

    name: str
    title: str
    x_label: str
    unit: str
    curves: tuple[Curve, ...]
    marks: tuple[Mark, ...]
    reading: str
    note: str = ""
    reach: float = 0.0

    @property
    def empty(self) -> bool:
        """Whether nothing was measured."""
        return all(curve.n == 0 for curve in self.curves)

    def rows(self) -> Iterator[Row]:
        """The csv, one row a step of a curve, and one a point of the paper."""
        for curve in self.curves:
            fixed: Row = {"curve": curve.label, "n": curve.n, "total": curve.total}
            for value, share in zip(curve.value.tolist(), curve.share.tolist(), strict=True):
                yield {**fixed, "error": value, "unit": self.unit, "share": share}
            if curve.n == 0:
                yield {**fixed, "error": float("nan"), "unit": self.unit, "share": float("nan")}
        for mark in self.marks:
            shown: Row = {"error": mark.paper.display, "unit": self.unit, "share": mark.share}
            yield {"curve": f"paper: {mark.label} {mark.paper.short}", "n": "", "total": "", **shown}


def distribution_steps(errors: ArrayLike) -> tuple[Floats, Floats]:
    """(K,) values and shares of the empirical distribution of the finite errors, at most `MOST_POINTS` of its steps.

    The first and the last step are always among them; without a finite error both are empty.
    """
    values = np.asarray(errors, dtype=np.float64)
    values = np.sort(values[np.isfinite(values)])
    if values.size == 0:
        return values, values
    kept = np.unique(np.linspace(0, values.size - 1, min(values.size, MOST_POINTS)).round().astype(int))
    return values[kept], (kept + 1.0) / values.size
