"""What all generated approaches are like: distance, angle, offset, speed and size, beside the paper's.

The paper gives the number of cases, the distances at which it detects, judges and alerts, and nothing of the speeds,
angles, offsets and sizes that its walkers met: there ours stand alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from obstaclewatch.support.arrays import Flags, Floats, Ints, Strings
from scenes.preview.pictures import COLORS
from scenes.streets.approaches import DATA_COLLECTION, Approach, make_approach
from scenes.truth.truth import ground_truth

PAPER_DISTANCES_M = {"detects\nto 7 m": 7.0, "judges\nfrom 5 m": 5.0, "alerts\nwithin 3 m": 3.0}
"""Sections 3.5, 3.6 and 3.2."""

MET, MISSED, PAPER = "#2c5f8a", "#d08a2e", "#b4432f"


@dataclass(frozen=True)
class ApproachStatistics:
    """One entry an approach.

    Attributes:
        scene, category: (N,) of the target.
        collision: (N,) whether the walker's body meets it.
        start_range_m: (N,) from the phone to the nearest point of the target as the walk begins.
        start_bearing_rad: (N,) the paper's walking angle to that point, 0 to pi.
        miss_distance_m: (N,) between the target and the line of the phone; 0 where the line meets it.
        clearance_m: (N,) smallest gap between body and target; 0 where they touch.
        speed_m_s, duration_s: (N,) of the walk.
        radius_m: (N,) half the target's width across the walk.
        obstacles: (N,) in the scene, the ground and the target included.
    """

    scene: Strings
    category: Strings
    collision: Flags
    start_range_m: Floats
    start_bearing_rad: Floats
    miss_distance_m: Floats
    clearance_m: Floats
    speed_m_s: Floats
    duration_s: Floats
    radius_m: Floats
    obstacles: Ints

    def __len__(self) -> int:
        return len(self.scene)


def approach_statistics(share: float = 1.0, seed: int = 0) -> ApproachStatistics:
    """Of the paper's 1299 cases, or of a share of every stratum, at least two of each; every second one a collision.

    Raises:
        ValueError: a share that is not above 0 and at most 1.
    """
    if not 0.0 < share <= 1.0:
        raise ValueError(f"share must lie above 0 and at most at 1, got {share}")
    rows = [_row(approach) for approach in _approaches(share, seed)]
    return ApproachStatistics(**{name: np.array([row[name] for row in rows]) for name in rows[0]})


def _approaches(share: float, seed: int) -> Iterator[Approach]:
    index = 0
    for scene_name, collected in DATA_COLLECTION.items():
        for category, cases in collected.cases.items():
            for number in range(max(2, round(share * cases))):
                yield make_approach(scene_name, category, index, seed=seed, collision=number % 2 == 0)
                index += 1


def _row(approach: Approach) -> dict[str, Any]:
    truth = ground_truth(approach.scene, approach.walk, approach.phone, [0.0], approach.target)
    return {
        "scene": approach.scene_name,
        "category": approach.category,
        "collision": truth.collides,
        "start_range_m": truth.range_m[0],
        "start_bearing_rad": truth.bearing_rad[0],
        "miss_distance_m": truth.miss_distance_m,
        "clearance_m": truth.clearance_m,
        "speed_m_s": approach.walk.speed_m_s,
        "duration_s": approach.walk.duration_s,
        "radius_m": truth.radius_m[0],
        "obstacles": len(approach.scene.obstacles),
    }


def statistics_table(found: ApproachStatistics) -> list[dict[str, Any]]:
    """Median and 5th and 95th percentile of every quantity, a row each; angles in degrees."""
    quantities: Mapping[str, Floats] = {
        "distance at the start (m)": found.start_range_m,
        "walking angle at the start (degrees)": np.rad2deg(found.start_bearing_rad),
        "offset of the phone's line, without a collision (m)": found.miss_distance_m[~found.collision],
        "gap to the body, without a collision (m)": found.clearance_m[~found.collision],
        "speed (m/s)": found.speed_m_s,
        "duration (s)": found.duration_s,
        "radius of the target (m)": found.radius_m,
        "obstacles in the scene": found.obstacles.astype(np.float64),
    }
    return [
        {"quantity": name, **dict(zip(("p5", "median", "p95"), np.percentile(values, [5, 50, 95]), strict=True))}
        for name, values in quantities.items()
    ]


def plot_statistics(found: ApproachStatistics, path: str | Path) -> Path:
    """Six panels as a PNG: cases, distance, angle, offset, speed and size."""
    figure = Figure(figsize=(11.5, 6.6), layout="constrained")
    panels = figure.subplots(2, 3).ravel()
    _cases(panels[0], found)
    _halves(panels[1], found, found.start_range_m, "distance at the start (m)", np.arange(0.0, 9.1, 0.5))
    for text, distance in PAPER_DISTANCES_M.items():
        panels[1].axvline(distance, color=PAPER, linewidth=1.2)
        above = panels[1].get_xaxis_transform()
        panels[1].text(distance, 1.01, text, color=PAPER, transform=above, ha="center", va="bottom", fontsize=8)
    angle = np.rad2deg(found.start_bearing_rad)
    _halves(panels[2], found, angle, "walking angle at the start (°)", np.arange(0.0, 91.0, 5.0))
    _halves(panels[3], found, found.miss_distance_m, "offset of the phone's line (m)", np.arange(0.0, 1.51, 0.1))
    _halves(panels[4], found, found.speed_m_s, "walking speed (m/s)", np.arange(0.75, 1.66, 0.05))
    _sizes(panels[5], found)
    panels[2].legend(frameon=False, loc="upper right")
    for panel in panels:
        panel.spines[["top", "right"]].set_visible(False)
        panel.grid(axis="y", color="#d5d9e0", linewidth=0.7)
        panel.set_axisbelow(True)
    figure.suptitle(f"{len(found)} generated approaches; red: the paper's values where it gives them", ha="center")
    figure.savefig(path, dpi=120, metadata={"Software": None})
    return Path(path)


def _cases(axes: Axes, found: ApproachStatistics) -> None:
    """Bars of ours, and the paper's counts as marks."""
    names = [(scene, category) for scene, one in DATA_COLLECTION.items() for category in one.cases]
    at = np.arange(len(names), dtype=np.float64)
    ours = [int(((found.scene == scene) & (found.category == category)).sum()) for scene, category in names]
    paper = [DATA_COLLECTION[scene].cases[category] for scene, category in names]
    axes.bar(at, ours, color=[COLORS[category] for _, category in names], width=0.7, alpha=0.75)
    axes.scatter(at, paper, marker="D", s=28, facecolor="white", edgecolor=PAPER, linewidth=1.4, zorder=3)
    axes.set_xticks(at, [f"{category}, {scene}" for scene, category in names], rotation=38, ha="right", fontsize=8)
    axes.set_ylabel("cases")


def _halves(axes: Axes, found: ApproachStatistics, values: Floats, label: str, edges: Floats) -> None:
    """Histograms of the walks that meet their target, and of those that miss it."""
    held = np.clip(values, edges[0], edges[-1])
    parts = [held[found.collision], held[~found.collision]]
    axes.hist(parts, edges.tolist(), stacked=True, color=[MET, MISSED], label=["collision", "no collision"])
    axes.set(xlabel=label, ylabel="walks")
    if (values > edges[-1]).any():
        axes.set_xlabel(f"{label} (last bar: or more)")


def _sizes(axes: Axes, found: ApproachStatistics) -> None:
    """Boxes over the radius by category, on a logarithmic scale."""
    names = list(dict.fromkeys(found.category.tolist()))
    boxes = axes.boxplot(
        [found.radius_m[found.category == name] for name in names], whis=(5, 95), sym="", patch_artist=True
    )
    for box, name in zip(boxes["boxes"], names, strict=True):
        box.set_facecolor(COLORS[name])
    for line in boxes["medians"]:
        line.set_color("black")
    axes.set_yscale("log")
    axes.set_xticks(np.arange(1, len(names) + 1), names)
    axes.set_ylabel("radius (m), 5 to 95 %")
    ticks = [0.2, 0.5, 1.0, 2.0, 5.0]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
