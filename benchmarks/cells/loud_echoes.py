"""Where a target's echoes come from, beside where it is: a diagnostic of standing measurements, never their truth.

The truth is the target's nearest point, from geometry alone. Of people and of bins that lean nothing near that point
echoes, and no estimator of ranges can know of it. How near an estimate comes to what does echo tells what noise and
method leave of its error. An error of the tracer would be in the recording and in these ranges alike and so stay hidden
here: only the truth can show it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from benchmarks.cells.detection_index import of_target_and_ground
from benchmarks.cells.situations.situation import Situation
from obstaclewatch.support.arrays import Floats
from simulator import Fidelity, Pose, trace_paths
from simulator.paths import Paths
from simulator.scene.pose import Walk

LOUD_DB = 6.0
"""Echoes so much weaker than the target's strongest at the same microphone, or less, are loud."""


def loud_echo_ranges(setting: Situation, fidelity: Fidelity) -> list[list[float]]:
    """Ranges, m, of the target's loud echoes at each microphone, nearest first; none if it has no echo.

    Echoes are those of paths that meet the first target and nothing else but the ground. Rays alone are asked: the
    cells of Kirchhoff's integral cancel but for a remainder, and none of them is an echo.
    """
    rays = replace(fidelity, mechanisms=tuple(name for name in fidelity.mechanisms if name != "kirchhoff"))
    pose = mean_pose(setting.walk)
    paths = trace_paths(setting.scene, setting.phone, pose, rays, time_s=0.5 * setting.walk.duration_s)
    grounds = [obstacle.name for obstacle in setting.scene.obstacles if obstacle.category == "ground"]
    mics_m = pose.to_world(setting.phone.geometry.mics_m)[0]
    return [_of_one(paths[paths.mic == k], setting.targets[0], grounds, mic_m) for k, mic_m in enumerate(mics_m)]


def mean_pose(walk: Walk) -> Pose:
    """The phone's mean place, and how it is held on average, at 101 instants of a walk."""
    poses = walk.pose(np.linspace(0.0, walk.duration_s, 101))
    heading = poses.body_heading_rad()
    facing = np.arctan2(np.sin(heading).mean(), np.cos(heading).mean())
    return Pose(poses.position_m.mean(axis=0), poses.rotation.mean(), facing)


def one_way_m(points_m: Floats, met: Sequence[str], target: str, mic_m: Floats) -> float:
    """Half the way from a microphone over a path's points on the target and back to it.

    To a single point it is the distance. Where the path goes out or comes back by the ground, z = 0, so does the way:
    of the corner that target and ground make it is the mean of both distances, as in `GroundTruth.mic_ground_range_m`.

    Args:
        points_m: (R, 3) points of reflection, world frame.
        met: R names of the obstacles there, the target's among them.
        target: its name.
        mic_m: (3,) the microphone.
    """
    own = [k for k, name in enumerate(met) if name == target]
    first, last = own[0], own[-1]
    start = mic_m * ([1.0, 1.0, -1.0] if first > 0 else 1.0)
    end = mic_m * ([1.0, 1.0, -1.0] if last < len(met) - 1 else 1.0)
    way = np.vstack([start, points_m[first : last + 1], end])
    return 0.5 * float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())


def _of_one(paths: Paths, target: str, grounds: Collection[str], mic_m: Floats) -> list[float]:
    """Ascending ranges of the loud echoes among one microphone's paths."""
    met = paths.obstacles_met()
    own = of_target_and_ground(paths, target, grounds)
    level = np.where(own, np.abs(paths.gain), 0.0)
    loud = np.flatnonzero(own & (level >= level.max(initial=0.0) * 10.0 ** (-LOUD_DB / 20.0)))
    return sorted(one_way_m(paths.points_m[k, 1 : len(met[k]) + 1], met[k], target, mic_m) for k in loud)
