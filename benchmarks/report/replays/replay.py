"""One walk as plain numbers that a page draws: plan, echogram, truth, and what every detector made of it.

Lengths in the plan are whole centimetres, in the frame of the walk's start: x ahead, y to the left.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.cells.compute import echo_range_m, first_alert, recording_of, truths_at_beeps
from benchmarks.cells.detectors import detector_label
from benchmarks.cells.equipment import detector_for
from benchmarks.cells.situations.situation import Situation
from benchmarks.cells.spec import Cell
from benchmarks.cells.stream_contract import detections_of
from benchmarks.echogram import LEVELS_DB, beep_levels
from benchmarks.report.replays.outline import PlanFrame, Window, outline
from obstaclewatch import BeepDesign, Detection
from obstaclewatch.recording import Recording
from obstaclewatch.support.arrays import Floats
from scenes.truth.swept import Body
from scenes.truth.truth import NOT_IN_THE_WAY, GroundTruth
from simulator import Fidelity, trace_paths
from simulator.paths import Paths

FRAMES_A_BEEP = 2
MARGIN_M = 1.6
"""What is shown around the walk and the target's nearest points."""
BIN_M = 0.02
"""Range cells of the packed echogram; the highest level within one is kept."""
TRACED_EVERY = 3
"""Beeps from one instant with drawn echoes to the next: tracing them all costs as much as the walk did."""
DRAWN_ECHOES = 10
SHORTEST_M = 0.3
"""Echoes whose path reaches less far in plan than this (the ground below, the walker) would be a dot."""


def replay(cell: Cell) -> dict[str, Any]:
    """Compute a walk again and pack it, ready for JSON.

    Raises:
        ValueError: the cell is no walk, or its detectors, scene or phone are no longer what they were.
    """
    if cell.kind not in ("approach", "scene"):
        raise ValueError(f"only walks can be replayed, kinds 'approach' and 'scene', got '{cell.kind}'")
    setting, beep, recording = recording_of(cell)
    truths = truths_at_beeps(cell, setting, beep, recording)
    start = setting.walk.pose([0.0])
    frame = PlanFrame(start.position_m[0, :2], float(start.body_heading_rad()[0]))
    window = _window(setting, truths, frame)
    return {
        "window": _cm([window.left, window.right, window.bottom, window.top]),
        "walk": _walk(setting, frame, beep.period_s / FRAMES_A_BEEP),
        "body": _body(cell),
        "obstacles": _obstacles(setting, frame, window),
        "echoes": _echoes(cell, setting, beep, len(truths[0].time_s), frame),
        "echogram": _echogram(recording, beep, len(truths[0].time_s)),
        "truths": [_truth(name, truth) for name, truth in zip(setting.targets, truths, strict=True)],
        "detectors": [_judged(cell, name, setting, beep, recording) for name in cell.detectors],
    }


def _window(setting: Situation, truths: Sequence[GroundTruth], frame: PlanFrame) -> Window:
    places = setting.walk.pose(np.linspace(0.0, setting.walk.duration_s, 50)).position_m
    points = frame.of_world(np.concatenate([places, *(truth.nearest_point_m for truth in truths)]))
    (left, bottom), (right, top) = points.min(axis=0) - MARGIN_M, points.max(axis=0) + MARGIN_M
    return Window(left, right, bottom, top)


def _walk(setting: Situation, frame: PlanFrame, step_s: float) -> dict[str, Any]:
    """Places and headings of the phone, a frame a column, from 0 s on."""
    pose = setting.walk.pose(np.arange(0.0, setting.walk.duration_s, step_s))
    places = frame.of_world(pose.position_m)
    turn = np.unwrap(pose.body_heading_rad()) - frame.heading_rad
    return {"step_s": step_s, "x": _cm(places[:, 0]), "y": _cm(places[:, 1]), "mrad": _whole(1e3 * turn)}


def _body(cell: Cell) -> dict[str, Any]:
    """The walker's stadium around the phone: ends of its core along the heading, and half its width."""
    body = Body(half_width_m=cell.scoring.half_width_m)
    ends = body.core(np.zeros((1, 3)), np.zeros(1))[0, :, 0]
    return {"front": float(ends[0]), "back": float(ends[1]), "half": body.half_width_m}


def _obstacles(setting: Situation, frame: PlanFrame, window: Window) -> list[dict[str, Any]]:
    found = []
    for obstacle in setting.scene.obstacles:
        if obstacle.category in NOT_IN_THE_WAY:
            continue
        velocity = frame.turned(np.asarray(obstacle.velocity_m_s)[:2])
        reach = np.abs(velocity) * setting.walk.duration_s
        seen = Window(window.left - reach[0], window.right + reach[0], window.bottom - reach[1], window.top + reach[1])
        rings = outline(obstacle, frame, seen)
        if rings:
            found.append({
                "name": obstacle.name, "category": obstacle.category, "target": obstacle.name in setting.targets,
                "velocity": [round(float(v), 3) for v in velocity], "rings": [_cm(ring.ravel()) for ring in rings],
            })  # fmt: skip
    return found


def _echoes(cell: Cell, setting: Situation, beep: BeepDesign, beeps: int, frame: PlanFrame) -> list[dict[str, Any]]:
    """The strongest paths to microphone 0 at the middle of every so many beeps."""
    time = np.arange(0, beeps, TRACED_EVERY) * beep.period_s + 0.5 * beep.duration_s
    paths = trace_paths(setting.scene, setting.phone, setting.walk.pose(time), Fidelity(**cell.fidelity), time)
    return [
        {"time_s": round(float(instant), 4), "paths": _strongest(paths, number, frame)}
        for number, instant in enumerate(time)
    ]


def _strongest(paths: Paths, pose: int, frame: PlanFrame) -> list[dict[str, Any]]:
    """Kind, level in dB re the free field at 1 m, and corners in plan, the loudest first."""
    rows = np.flatnonzero((paths.pose == pose) & (paths.mic == 0) & (paths.order > 0))
    plan = frame.of_world(paths.points_m[rows])
    long = np.ptp(plan, axis=1).max(axis=1, initial=0.0) > SHORTEST_M
    order = np.argsort(-np.abs(paths.gain[rows[long]]), kind="stable")[:DRAWN_ECHOES]
    return [
        {"kind": str(paths.kind[row]), "level_db": round(float(20.0 * np.log10(np.abs(paths.gain[row]))), 1),
         "points": _cm(points[: paths.order[row] + 2].ravel())}
        for row, points in zip(rows[long][order], plan[long][order], strict=True)
    ]  # fmt: skip


def _echogram(recording: Recording, beep: BeepDesign, beeps: int) -> dict[str, Any]:
    """Levels in bytes over `LEVELS_DB`, range by range within a beep, beep by beep."""
    level, edges = beep_levels([recording], beep, (beep.period_s * np.arange(beeps)).tolist())
    first = np.arange(0.0, edges[-1] - BIN_M, BIN_M)
    binned = np.maximum.reduceat(level, np.searchsorted(edges[:-1], first), axis=0)
    low, high = LEVELS_DB
    byte = np.clip(np.rint(255.0 * (binned - low) / (high - low)), 0, 255).astype(np.uint8)
    return {
        "period_s": beep.period_s, "bin_m": BIN_M, "bins": len(byte), "beeps": beeps,
        "low_db": low, "high_db": high,
        "bytes": base64.b64encode(np.ascontiguousarray(byte.T).tobytes()).decode("ascii"),
    }  # fmt: skip


def _truth(name: str, truth: GroundTruth) -> dict[str, Any]:
    contact = truth.contact_time_s
    return {
        "name": name,
        "time_s": [round(float(t), 4) for t in truth.time_s],
        "cm": _cm(echo_range_m(truth)[:, 0]),
        "mrad": _whole(1e3 * truth.signed_bearing_rad),
        "contact_s": round(float(contact), 3) if np.isfinite(contact) else None,
        "miss_m": round(float(truth.miss_distance_m), 3),
    }


def _judged(cell: Cell, name: str, setting: Situation, beep: BeepDesign, recording: Recording) -> dict[str, Any]:
    detections, no_beep = detections_of(detector_for(cell, name, setting, beep), beep, recording)
    alert = first_alert(detections, recording.duration_s)
    return {
        "name": detector_label(name),
        "no_beep": no_beep,
        "alert_s": alert["alert_time_s"] if alert["alert"] else None,
        "beeps": [_beep(detection) for detection in detections],
    }


def _beep(detection: Detection) -> dict[str, Any]:
    """Candidates of one beep: ranges, unsigned bearings (null: none), votes; and what was decided."""
    decision = detection.decision
    return {
        "time_s": round(float(detection.time_s), 4),
        "cm": _cm(detection.range_m),
        "mrad": _whole(1e3 * detection.bearing_rad),
        "course": [int(hit) for hit in detection.collides],
        "decided_cm": _cm([decision.range_m])[0],
        "alert": bool(decision.alert),
    }


def _cm(values_m: Any) -> list[int | None]:
    return _whole(100.0 * np.asarray(values_m, dtype=np.float64))


def _whole(values: Floats) -> list[int | None]:
    """Rounded; None where there is no number."""
    return [round(value) if np.isfinite(value) else None for value in values.tolist()]
