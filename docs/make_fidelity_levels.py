"""Draw docs/fidelity_levels.png: `python docs/make_fidelity_levels.py`, from the root of the project.

The echo of a person, a car and a sign on the ground, over distance and over its yaw, at two levels of
fidelity: where they differ, and by how much.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from scenes.obstacles import ground, random_obstacle
from scenes.streets.placing import placed
from simulator import Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

LEVELS = {"standard": ("#1b9e77", "--"), "reference": ("#333333", "-")}
CATEGORIES = ("pedestrian", "car", "sign")
SEED = 3
DISTANCES_M = np.linspace(1.0, 6.0, 26)
YAWS_RAD = np.deg2rad(np.arange(-90.0, 91.0, 6.0))
YAWED_AT_M = 2.5
FREQUENCY_HZ = np.arange(18_000.0, 23_000.0, 20.0)


def main() -> None:
    """Compute and draw."""
    figure = Figure(figsize=(10.5, 6.4), layout="constrained")
    axes = figure.subplots(2, 3)
    for column, category in enumerate(CATEGORIES):
        away, about = axes[0, column], axes[1, column]
        for level, (color, style) in LEVELS.items():
            near = over_distance(category, Fidelity(level=level))
            away.plot(DISTANCES_M, near, style, color=color, label=level)
            about.plot(np.rad2deg(YAWS_RAD), over_yaw(category, Fidelity(level=level)), style, color=color)
        away.set(title=category, xlabel="distance (m)")
        about.set(xlabel=f"yaw (°), at {YAWED_AT_M:g} m", xticks=np.arange(-90, 91, 30))
    for row in axes:
        row[0].set_ylabel("echo (dB re 1 m from the speaker)")
    for panel in axes.ravel():
        panel.set_ylim(-85, -5)
        panel.grid(alpha=0.3)
    axes[0, 0].legend()
    figure.savefig(Path(__file__).with_name("fidelity_levels.png"), dpi=110)


def over_distance(category: str, fidelity: Fidelity) -> NDArray[np.float64]:
    """(D,) echo levels of an obstacle that faces the phone, dB; its nearest point is at the distance."""
    target = _drawn(category, 0.0)
    front = float(target.mesh.vertices[:, 0].min())
    place = np.column_stack([front - DISTANCES_M, np.zeros(len(DISTANCES_M)), np.full(len(DISTANCES_M), 1.3)])
    return _levels(target, place, fidelity)


def over_yaw(category: str, fidelity: Fidelity) -> NDArray[np.float64]:
    """(T,) echo levels of an obstacle rotated about its middle, dB."""
    place = np.array([[-YAWED_AT_M, 0.0, 1.3]])
    return np.concatenate([_levels(_drawn(category, yaw), place, fidelity) for yaw in YAWS_RAD])


def _drawn(category: str, yaw_rad: float) -> Obstacle:
    return placed(random_obstacle(category, np.random.default_rng(SEED), category), np.zeros(2), yaw_rad)


def _levels(target: Obstacle, place: NDArray[np.float64], fidelity: Fidelity) -> NDArray[np.float64]:
    phone = Phone.ideal([0.0, 0.05, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
    scene = Scene([Obstacle(ground(), Material.named("asphalt"), "ground"), target])
    number = len(place)
    pose = Pose(place, held_rotation(np.zeros(number), np.full(number, np.deg2rad(30.0)), np.zeros(number)))
    paths = trace_paths(scene, phone, pose, fidelity)
    mine = paths[np.array([target.name in name for name in paths.obstacle], dtype=bool) & (paths.mic == 0)]
    terms = mine.gain_at(FREQUENCY_HZ) * np.exp(-2j * np.pi * FREQUENCY_HZ * mine.delay_s[:, None])
    total = np.zeros((number, len(FREQUENCY_HZ)), dtype=np.complex128)
    np.add.at(total, mine.pose, terms)
    window = np.hanning(len(FREQUENCY_HZ))
    peak = np.abs(np.fft.ifft(total * window / window.sum(), n=8192, axis=1)).max(axis=1) * 8192
    return 20.0 * np.log10(np.maximum(peak, 1e-12))


if __name__ == "__main__":
    main()
