"""Ground truth of walks past a box and at it, against plain arithmetic: what all other gates are judged by."""

from __future__ import annotations

import numpy as np
import trimesh

from benchmarks.gates.physics.measured import Measured
from scenes import ground_truth
from scenes.truth.swept import Body
from simulator import Material, Obstacle, Phone, Scene, StraightWalk

WALKS = 12
BODY = Body()
SPEAKER_M, MICS_M = np.array([0.0, 0.05, 0.0]), np.array([[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])


def truth_error_m(seed: int) -> Measured:
    """Greatest error of ranges, clearance and place at contact over walks along +x, the phone level, at boxes ahead.

    The nearest point of a box that spans the phone's height is its corner or the foot of a perpendicular in plan, and
    what is touched first, if anything, is the box's front.
    """
    rng, worst, compared = np.random.default_rng(seed), [], 0
    for k in range(WALKS):
        front, speed = float(rng.uniform(3.0, 5.0)), float(rng.uniform(0.8, 1.6))
        aside = float(rng.uniform(-0.15, 0.15) if k % 2 else rng.uniform(0.6, 1.2))  # edge beside the line, or past it
        low, high = (-1.0, 1.0) if k % 2 else (aside, aside + 1.0)
        box = trimesh.creation.box(bounds=[[front, low, 0.0], [front + 0.5, high, 2.0]])
        walk = StraightWalk(np.array([0.0, 0.0, 1.3]), 0.0, speed, 7.0)
        time = np.linspace(0.0, 2.0 / speed, 5)
        scene = Scene([Obstacle(box, Material.rigid(), "box")])
        found = ground_truth(scene, walk, Phone.ideal(SPEAKER_M, MICS_M), time, body=BODY)
        place = speed * time
        phone = place + 0.5 * (SPEAKER_M[1] + MICS_M[0, 1])
        nearest = front, max(low, min(0.0, high))
        errors = [found.range_m - np.hypot(nearest[0] - phone, nearest[1])]
        errors += [found.mic_range_m[:, m] - np.hypot(nearest[0] - place - MICS_M[m, 1], nearest[1]) for m in (0, 1)]
        errors.append(np.array([0.0 if found.collides == bool(k % 2) else np.inf]))
        errors.append(np.array([found.clearance_m - (0.0 if k % 2 else low - BODY.half_width_m)]))
        if k % 2 and found.collides:
            errors.append(np.array([speed * found.contact_time_s - (front - BODY.front_m)]))
        worst += [np.abs(error).max() for error in errors]
        compared += sum(len(error) for error in errors)
    return Measured(min(float(np.max(worst)), 1e9), "m", compared)
