"""Draw docs/echo_levels.png and print its table: `python -m docs.make_echo_levels`, from the root of the project."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from docs.studies.echo_levels import EchoLevels, echo_levels
from simulator import Phone

CATEGORIES = ("wall", "sign", "car", "dustbin", "pedestrian", "clutter")
DISTANCES_M = (1.5, 3.0, 5.0)
COUNT = 24
COLORS = {1.5: "#08519c", 3.0: "#4292c6", 5.0: "#9ecae1"}

# Strongest line over the direct sound on the microphone that faces a large flat object, from eight hold phases of real
# walks (LibAcousticSensing, MIT): nominal distance m, level dB, phone.
REAL_TRACES = (
    (2.0, -26.4, "Nexus 6P"), (2.5, -25.7, "Nexus 6P"), (3.0, -31.2, "Nexus 6P"), (3.0, -34.5, "Nexus 6P"),
    (2.0, -24.9, "Galaxy S5"), (3.0, -27.9, "Galaxy S5"), (2.0, -35.8, "Galaxy S4"), (3.0, -28.0, "Galaxy S4"),
)  # fmt: skip


def main() -> None:
    """Compute, print, draw: the phone is ideal, its microphone 10 cm from the speaker."""
    phone = Phone.ideal(speaker_m=[0.0, 0.05, 0.0], mics_m=[[0.0, 0.15, 0.0], [0.0, -0.05, 0.0]])
    levels = {(c, d): echo_levels(c, d, phone, COUNT) for c in CATEGORIES for d in DISTANCES_M}
    print("| re direct sound, dB | " + " | ".join(f"{d:g} m" for d in DISTANCES_M) + " |")
    print("|---" * (1 + len(DISTANCES_M)) + "|")
    for category in CATEGORIES:
        print(f"| {category} | " + " | ".join(_cell(levels[category, d]) for d in DISTANCES_M) + " |")
    _draw(levels).savefig(Path(__file__).with_name("echo_levels.png"), dpi=110)


def _cell(levels: EchoLevels) -> str:
    low, middle, high = (levels.percentile_db(p) for p in (10.0, 50.0, 90.0))
    return f"{middle:.0f} ({low:.0f} to {high:.0f})"


def _draw(levels: dict[tuple[str, float], EchoLevels]) -> Figure:
    """Every level as a dot, medians as bars; the real traces beside the walls."""
    figure = Figure(figsize=(10, 5), layout="constrained")
    axes = figure.add_subplot()
    for number, category in enumerate(CATEGORIES):
        for k, distance in enumerate(DISTANCES_M):
            one = levels[category, distance]
            audible = one.level_db[np.isfinite(one.level_db)]
            middle = number + 1.0 + 0.26 * (k - 1)
            spread = 0.09 * np.linspace(-1.0, 1.0, len(audible))
            axes.scatter(middle + spread, audible, s=7, color=COLORS[distance], alpha=0.6, linewidths=0)
            axes.plot([middle - 0.11, middle + 0.11], [one.percentile_db(50.0)] * 2, color="black", linewidth=2)
    marks = {"Nexus 6P": "s", "Galaxy S5": "o", "Galaxy S4": "^"}
    for label, mark in marks.items():
        rows = np.array([(d, level) for d, level, name in REAL_TRACES if name == label])
        axes.scatter(0.1 * (rows[:, 0] - 2.5), rows[:, 1], marker=mark, s=42, color="#d94801", label=f"real {label}")
    for distance, color in COLORS.items():
        axes.scatter([], [], color=color, s=30, label=f"{distance:g} m, simulated")
    axes.plot([], [], color="black", linewidth=2, label="median")
    axes.set_xticks(range(7), ["real traces:\nlarge flat object\nat 2-3 m", *CATEGORIES])
    axes.set(ylabel="echo over direct sound (dB)", ylim=(-100.0, -15.0), xlim=(-0.5, 6.6))
    axes.grid(axis="y", alpha=0.3)
    axes.legend(ncols=4, fontsize=8, loc="lower left")
    axes.set_title("Echo over direct sound at 10 cm, phone at 1.2-1.4 m, 24 obstacles of each category")
    return figure


if __name__ == "__main__":
    main()
