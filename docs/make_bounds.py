"""What the exact trajectory of a target's own echo allows: `python docs/make_bounds.py WALKS`, from the root.

The simulator's paths say from where the target's strongest echo comes in every beep. Its range and the cosine of its
cone about the phone's long axis, exact and without gait, up to 24 beeps back, are the most that two microphones can
receive. The posterior of bearing and collision is taken from the nearest beeps of all other walks: what that misses no
estimator of these walks undercuts by much; it falls a little with more walks.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from benchmarks.cells.equipment import mean_pitch_rad
from benchmarks.cells.situations.approaching import approach_situation
from benchmarks.cells.spec import Cell
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from obstaclewatch import BeepDesign
from scenes import ground_truth
from simulator import Fidelity
from simulator.render import trace_walk

Array = NDArray[np.float64]
BEEP = BeepDesign()
MEMORY_BEEPS, LEAST_BEEPS, MOST_LOST = 24, 6, 3
GATE_M, STEP_M = 0.1, 0.11
RANGE_M, LEFT_M = (0.9, 4.0), (1.0, 1.5)
NEIGHBORS = 40
SCALES = np.array([1.0, 2.5, 30.0, 12.0, 60.0, 90.0, 1.5])
"""Of `features`. The last is used with the walker's speed alone."""


@dataclass(frozen=True)
class Walked:
    """The target's echoes at microphone 0 on one walk, as a phone without gait would receive them.

    Attributes:
        echo: (E, 5) number of the beep, range, cosine of the cone, bearing in degrees, gain.
        left_m: (beeps,) to the first touch, or to the nearest point of what is not touched.
        collides: whether it is touched.
        pitch_rad, height_m, speed_m_s: pitch of the phone, microphone 0 above the ground, and walking speed.
    """

    echo: Array
    left_m: Array
    collides: bool
    pitch_rad: float
    height_m: float
    speed_m_s: float


def main(walks: int) -> None:
    """Trace, learn from all other walks, print."""
    cells = [cell for cell in plan_cells(load_suite("paper", ["split=dev"]), "full") if cell.kind == "approach"]
    chosen = np.random.default_rng(5).permutation(len(cells))[:walks]
    table = np.concatenate([rows_of(walked(cells[which]), number) for number, which in enumerate(tqdm(chosen))])
    number, bearing, collides, left_m, what = table[:, 0], table[:, 1], table[:, 2], table[:, 3], table[:, 4:]
    there = (left_m >= LEFT_M[0]) & (left_m < LEFT_M[1])
    for name, used in (("the exact trajectory", 6), ("and the walker's speed", 7)):
        near, weight = neighbors(what[:, :used] * SCALES[:used], number)
        error = np.abs(weighted_median(bearing[near], weight) - bearing)
        probability = np.sum(weight * collides[near], axis=1)
        print(f"{name}, {len(table)} beeps: {by_bearing(error, bearing)}")
        print(f"    {decided(probability[there], collides[there] > 0.5, number[there])}")


def walked(cell: Cell) -> Walked:
    """Trace one walk; what comes from the target alone, or from it and the ground, within 10 dB of the loudest."""
    found = approach_situation(cell)
    walk, phone, target = found.walk, found.phone, found.targets[0]
    paths, _, count = trace_walk(found.scene, phone, walk, BEEP, Fidelity(**cell.fidelity))
    middle_s = BEEP.period_s * np.arange(count) + 0.5 * BEEP.duration_s
    heading = np.array([np.cos(walk.heading_rad), np.sin(walk.heading_rad), 0.0])
    pitch_rad = mean_pitch_rad(walk)
    axis = np.cos(pitch_rad) * heading + [0.0, 0.0, np.sin(pitch_rad)]
    mic_m = walk.start_m + walk.speed_m_s * middle_s[:, None] * heading + phone.geometry.mics_m[0, 1] * axis
    echo, met = [], paths.obstacles_met()
    for row in np.flatnonzero((paths.mic == 0) & (paths.order > 0)):
        parts = met[row]
        if target in parts and set(parts) <= {target, "ground"}:
            point, beep = paths.points_m[row, 1 + parts.index(target)], paths.pose[row]
            echo.append([beep, *seen(point, mic_m[beep], axis, heading, "ground" in parts), abs(paths.gain[row])])
    truth = ground_truth(found.scene, walk, phone, middle_s, target=target)
    left_m = (truth.contact_time_s - middle_s) * walk.speed_m_s if truth.collides else truth.range_m - 0.1
    echoes = np.array(echo).reshape(-1, 5)
    loudest = np.array([echoes[echoes[:, 0] == beep, 4].max() for beep in echoes[:, 0]])
    return Walked(echoes[echoes[:, 4] > 0.3 * loudest], left_m, truth.collides, pitch_rad, mic_m[0, 2], walk.speed_m_s)


def seen(point: Array, mic_m: Array, axis: Array, heading: Array, by_ground: bool) -> tuple[float, float, float]:
    """Range, cosine and bearing, degrees; via the ground the means of the paths to the point and to its image."""
    sight = np.stack([point, point * [1.0, 1.0, -1.0 if by_ground else 1.0]]) - mic_m
    length = np.linalg.norm(sight, axis=1)
    ahead, aside = float(sight[0] @ heading), float(heading[0] * sight[0, 1] - heading[1] * sight[0, 0])
    return float(length.mean()), float(np.mean(sight @ axis / length)), float(np.rad2deg(np.arctan2(abs(aside), ahead)))


def rows_of(walk: Walked, number: int) -> Array:
    """(n, 11) number of the walk, bearing, whether it collides, what is left, `features`; of the beeps that echo."""
    rows = []
    for beep in np.unique(walk.echo[:, 0]):
        track = followed(walk.echo, beep)
        if len(track) >= LEAST_BEEPS and RANGE_M[0] < track[0, 1] < RANGE_M[1]:
            rows.append([number, track[0, 3], walk.collides, walk.left_m[int(beep)], *features(track, walk)])
    return np.array(rows).reshape(-1, 11)


def followed(echo: Array, beep: float) -> Array:
    """(k, 5) the beep's loudest echo and, back in time, in each beep what lies nearest to where it should have been."""
    here = echo[echo[:, 0] == beep]
    track, step_m, lost = [here[np.argmax(here[:, 4])]], STEP_M, 0
    for earlier in np.arange(beep - 1, beep - MEMORY_BEEPS, -1):
        there, gap = echo[echo[:, 0] == earlier], track[-1][0] - earlier
        off_m = np.abs(there[:, 1] - track[-1][1] - step_m * gap)
        if len(off_m) and off_m.min() < GATE_M + 0.03 * gap:
            found = there[np.argmin(off_m)]
            step_m, lost = 0.7 * step_m + 0.3 * (found[1] - track[-1][1]) / gap, 0
            track.append(found)
        elif (lost := lost + 1) > MOST_LOST:
            break
    return np.array(track)


def features(track: Array, walk: Walked) -> tuple[float, ...]:
    """Bearing if the echo comes from the phone's height, and from a corner with the ground; range, speed, and so on."""
    age_s = BEEP.period_s * (track[:, 0] - track[0, 0])
    _, fall, curve = np.polynomial.polynomial.polyfit(age_s, track[:, 1], 2)
    cosine, drift, _ = np.polynomial.polynomial.polyfit(age_s, track[:, 2], 2)
    range_m, height_m = track[0, 1], min(walk.height_m, 0.999 * track[0, 1])
    low = (cosine * range_m + height_m * np.sin(walk.pitch_rad)) / np.sqrt(range_m**2 - height_m**2)
    level, corner, speed = np.rad2deg(
        np.arccos(np.clip([*(np.array([cosine, low]) / np.cos(walk.pitch_rad)), -fall / walk.speed_m_s], -1.0, 1.0))
    )
    return level, corner, np.log(range_m), -fall, drift, np.clip(2.0 * curve, -2.0, 2.0), speed


def neighbors(what: Array, number: Array) -> tuple[NDArray[np.intp], Array]:
    """(n, K) the rows nearest to each among those of other walks, and their weights, which sum to 1."""
    near, weight = np.empty((len(what), NEIGHBORS), dtype=np.intp), np.empty((len(what), NEIGHBORS))
    for row in range(len(what)):
        distance2 = np.sum((what - what[row]) ** 2, axis=1)
        distance2[number == number[row]] = np.inf
        near[row] = np.argpartition(distance2, NEIGHBORS)[:NEIGHBORS]
        weight[row] = np.exp(-distance2[near[row]] / np.median(distance2[near[row]]))
    return near, weight / weight.sum(axis=1, keepdims=True)


def weighted_median(value: Array, weight: Array) -> Array:
    """(n,) medians of rows (n, K)."""
    order = np.argsort(value, axis=1)
    reached = np.cumsum(np.take_along_axis(weight, order, axis=1), axis=1) >= 0.5
    middle: Array = np.take_along_axis(np.take_along_axis(value, order, axis=1), reached.argmax(axis=1)[:, None], 1)[
        :, 0
    ]
    return middle


def by_bearing(error: Array, bearing: Array) -> str:
    """Median and 80 % of errors at true bearings of 0-10, 10-20, 20-30, 30-40 degrees."""
    parts = [error[(bearing >= low) & (bearing < low + 10.0)] for low in (0.0, 10.0, 20.0, 30.0)]
    return ", ".join(f"{np.median(part):.1f} / {np.quantile(part, 0.8):.1f}" for part in parts)


def decided(probability: Array, collides: NDArray[np.bool_], number: Array) -> str:
    """Area, and TPR at TNR 90 and 97 %, of walks by their mean probability."""
    walks = np.unique(number)
    mean = np.array([probability[number == walk].mean() for walk in walks])
    hit = np.array([collides[number == walk][0] for walk in walks])
    area = np.mean((mean[hit][:, None] > mean[~hit]) + 0.5 * (mean[hit][:, None] == mean[~hit]))
    true = [100.0 * np.mean(mean[hit] > np.quantile(mean[~hit], tnr)) for tnr in (0.9, 0.97)]
    return f"area {area:.2f}; TPR {true[0]:.0f}, {true[1]:.0f} %; {hit.sum()} of {len(hit)} walks collide"


if __name__ == "__main__":
    main(int(sys.argv[1]))
