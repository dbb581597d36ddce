"""Simulate, detect, compare: the body of one cell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from time import perf_counter, process_time
from typing import Any, Literal
from zlib import crc32

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.cells.association import Estimates, associate
from benchmarks.cells.channel import through_channel
from benchmarks.cells.detection_index import detection_index_db
from benchmarks.cells.detectors import detector_label
from benchmarks.cells.equipment import detector_for
from benchmarks.cells.interference import with_interferer
from benchmarks.cells.loud_echoes import loud_echo_ranges
from benchmarks.cells.probes.extremes import numerics_result
from benchmarks.cells.probes.fidelities import fidelity_result
from benchmarks.cells.probes.motions import motion_result
from benchmarks.cells.probes.signals import signal_result
from benchmarks.cells.probes.speed import speed_result
from benchmarks.cells.probes.tessellations import tessellation_result
from benchmarks.cells.situations.approaching import approach_situation
from benchmarks.cells.situations.own_scene import scene_situation
from benchmarks.cells.situations.situation import Situation, rendered
from benchmarks.cells.situations.standing import standing_situation
from benchmarks.cells.situations.variation import varied
from benchmarks.cells.spec import Cell
from benchmarks.cells.stream_contract import detections_of
from obstaclewatch import BeepDesign
from obstaclewatch.recording import Recording
from obstaclewatch.support.arrays import Flags, Floats
from scenes import ground_truth
from scenes.truth.truth import GroundTruth, target_range_m
from simulator import Fidelity
from simulator.scene.pose import Walk

SITUATIONS = {"approach": approach_situation, "standing": standing_situation, "scene": scene_situation}
PROBES = {
    "signal": signal_result,
    "numerics": numerics_result,
    "fidelity": fidelity_result,
    "tessellation": tessellation_result,
    "motion": motion_result,
    "speed": speed_result,
}

BEFORE_S = 1.0
"""Before the recording's start, from which on an alert is none of its own."""

PROGRESS_STEP_S = 0.02
"""Spacing at which a walk is followed for the distance walked: a turn of 1 rad/s departs by 0.02 mm a step."""


def compute(cell: Cell) -> dict[str, Any]:
    """All numbers of one cell, ready for JSON: "truth", "detectors" (one entry each) and "cost" (times, s).

    Of a detector: its first alert and how far and long before contact it comes; "decisions", the probability of a
    collision that it stated at each beep, if it does, beside the distance left; and its estimates of every target.
    Standing measurements add "loud_echoes_m", of each microphone; see `benchmarks.cells.loud_echoes`.

    Raises:
        ValueError: the cell names something unknown or out of range.
    """
    if cell.kind in PROBES:
        return PROBES[cell.kind](cell)
    if cell.kind not in SITUATIONS:
        raise ValueError(f"a cell's kind must be one of {sorted(SITUATIONS | PROBES)}, got '{cell.kind}'")
    begin = perf_counter()
    setting, beep, recording = recording_of(cell)
    simulated = perf_counter()
    truths = truths_at_beeps(cell, setting, beep, recording)
    found = {detector_label(name): _judged(cell, name, setting, beep, recording, truths) for name in cell.detectors}
    cost = {
        "simulate_s": simulated - begin,
        "detect_s": {name: entry.pop("detect_s") for name, entry in found.items()},
        "detect_cpu_s": {name: entry.pop("detect_cpu_s") for name, entry in found.items()},
        "recording_s": recording.duration_s,
        "beeps": len(truths[0].time_s),
        "total_s": perf_counter() - begin,
    }
    echoes = {"loud_echoes_m": loud_echo_ranges(setting, Fidelity(**cell.fidelity))} if cell.kind == "standing" else {}
    return {"truth": truth_entry(cell, setting, beep, truths), "detectors": found, "cost": cost} | echoes


def recording_of(cell: Cell) -> tuple[Situation, BeepDesign, Recording]:
    """What a walk or a standing measurement simulates, its beep, and the recording that the detectors run on."""
    setting, recorded = _simulated(simulated_part(cell).model_dump_json())
    return setting, cell.beep.design(), after_microphones(cell, setting, recorded)


def after_microphones(cell: Cell, setting: Situation, recorded: Recording) -> Recording:
    """What the detector gets of what was recorded: with the second phone's beeps, through the cell's channel."""
    return through_channel(with_interferer(recorded, setting, cell.beep.design(), cell.interferer), cell.recording)


def simulated_part(cell: Cell) -> Cell:
    """The cell with everything left out that changes nothing before the microphones: its simulation can be shared."""
    later = ("recording", "interferer", "knowledge", "settings", "scoring", "variant", "detector_sources")
    kept = cell.model_dump(mode="json", exclude=set(later))
    return Cell.model_validate(kept | {"detectors": ()})


@lru_cache(maxsize=1)
def _simulated(cell_json: str) -> tuple[Situation, Recording]:
    """What is rendered, kept for the next cell: the points of a sweep over detectors come one after another."""
    cell = Cell.model_validate_json(cell_json)
    setting = situation_of(cell)
    return setting, rendered(setting, cell)


def situation_of(cell: Cell) -> Situation:
    """What a cell of a walk or of a standing measurement is about."""
    return varied(SITUATIONS[cell.kind](cell), cell)


def truths_at_beeps(cell: Cell, setting: Situation, beep: BeepDesign, recording: Recording) -> list[GroundTruth]:
    """Ground truth of every target at the instants at which the beeps' centres meet it."""
    starts = beep.period_s * np.arange(beep.beeps_in(recording.duration_s))
    middles = starts + 0.5 * beep.duration_s

    def told(target: str) -> GroundTruth:
        asked = (setting.scene, setting.walk, setting.phone)
        # Sound to the target takes range / c; one correction leaves less than 0.1 mm at walking speed.
        met = middles + target_range_m(*asked, middles, target) / setting.scene.air.sound_speed_m_s
        return ground_truth(*asked, met, target=target, half_width_m=cell.scoring.half_width_m)

    return [told(name) for name in setting.targets]


def _judged(
    cell: Cell, name: str, setting: Situation, beep: BeepDesign, recording: Recording, truths: Sequence[GroundTruth]
) -> dict[str, Any]:
    """One detector on the recording: its first alert, what it decided by, and its estimates of every target."""
    detector = detector_for(cell, name, setting, beep)
    before = crc32(recording.samples.data)
    begin, begin_cpu = perf_counter(), process_time()
    detections, no_beep = detections_of(detector, beep, recording)
    cost = {"detect_s": perf_counter() - begin, "detect_cpu_s": process_time() - begin_cpu}
    if crc32(recording.samples.data) != before:
        _simulated.cache_clear()
        raise ValueError(f"a detector must leave the recording as it is: others receive it too; '{name}' wrote into it")
    alert, contact_s = first_alert(detections, recording.duration_s), truths[0].contact_time_s
    entry = {**alert, **cost, "no_beep": no_beep, "decisions": _decisions(detections, setting.walk, contact_s)}
    entry["alert_distance_m"] = float(distance_left_m(setting.walk, alert["alert_time_s"], contact_s))
    entry["alert_lead_s"] = float(np.subtract(contact_s, alert["alert_time_s"]))
    entry["outcome"] = outcome(alert["alert"], entry["alert_distance_m"], truths[0].collides)
    entry["beeps"] = [_beep_table(cell, detections, truth) for truth in truths]
    return entry


def first_alert(detections: Sequence[Any], duration_s: float) -> dict[str, Any]:
    """Whether, when and at which range a detector first raised an alert on a recording of such a duration."""
    for detection in detections:
        if detection.decision.alert:
            time_s, range_m = float(detection.decision.time_s), float(detection.decision.range_m)
            if not -BEFORE_S <= time_s <= duration_s:
                raise ValueError(f"time_s of a decision must be within the recording's {duration_s:g} s, got {time_s}")
            return {"alert": True, "alert_time_s": time_s, "alert_range_m": range_m}
    return {"alert": False, "alert_time_s": math.nan, "alert_range_m": math.nan}


def outcome(alert: bool, alert_distance_m: float, collides: bool) -> Literal["TP", "FN", "TN", "FP"]:
    """By the paper's rule: a true alert comes before contact; any alert on a walk without a collision is false."""
    if not collides:
        return "FP" if alert else "TN"
    return "TP" if alert and alert_distance_m > 0.0 else "FN"


def _decisions(detections: Sequence[Any], walk: Walk, contact_s: float) -> dict[str, list[float]]:
    """By beep, the probability of a collision that the detector states, and the distance left; none without any."""
    stated = [d.decision for d in detections if math.isfinite(getattr(d.decision, "collision_probability", math.nan))]
    left_m = distance_left_m(walk, [decision.time_s for decision in stated], contact_s)
    probability = [float(each.collision_probability) for each in stated]
    odd = [p for p in probability if not 0.0 <= p <= 1.0]
    if odd:
        raise ValueError(f"collision_probability of a decision must be 0 to 1, got {odd[0]}")
    return {"left_m": left_m.tolist(), "probability": probability}


def distance_left_m(walk: Walk, time_s: ArrayLike, contact_s: float) -> Floats:
    """Distance walked along the heading, which may change, from instants to contact; NaN without either."""
    grid_s = np.linspace(0.0, walk.duration_s, 2 + math.ceil(walk.duration_s / PROGRESS_STEP_S))
    pose = walk.pose(grid_s)
    heading = pose.body_heading_rad()
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    step = np.diff(pose.position_m[:, :2], axis=0)
    walked_m = np.cumsum(np.append(0.0, np.sum(step * 0.5 * (ahead[1:] + ahead[:-1]), axis=1)))
    left: Floats = np.interp(contact_s, grid_s, walked_m) - np.interp(np.asarray(time_s, np.float64), grid_s, walked_m)
    return left


def echo_range_m(truth: GroundTruth) -> np.ndarray:
    """(T, 2) range of the target at each microphone: of low ones that of their foot on the ground."""
    range_m: np.ndarray = np.where(truth.by_ground[:, None], truth.mic_ground_range_m, truth.mic_range_m)
    return range_m


def scored(cell: Cell, truth: GroundTruth) -> Flags:
    """(T,) beeps with the target in range, before contact."""
    inside: Flags = (truth.range_m <= cell.scoring.max_range_m) & ~(truth.time_s > truth.contact_time_s)
    return inside


def _beep_table(cell: Cell, detections: Sequence[Any], truth: GroundTruth) -> dict[str, Any]:
    """Columns over the beeps with the target in range: truth beside estimates."""
    # Emission times are the detector's own; to the nearest period they count the beeps, also where it began late.
    index = np.rint([detection.time_s / cell.beep.period_s for detection in detections]).astype(np.int64)
    kept = (index >= 0) & (index < len(truth.time_s))
    rows = index[kept]
    within = [detection for detection, keep in zip(detections, kept, strict=True) if keep]
    path_m = echo_range_m(truth)
    estimates: Estimates = associate(within, path_m[rows, 0], cell.scoring.gate_m)
    inside = scored(cell, truth)[rows]
    columns = {
        "beep": rows,
        "time_s": truth.time_s[rows],
        "true_range_m": path_m[rows, 0],
        "true_range2_m": path_m[rows, 1],
        "low": truth.by_ground[rows],
        "true_bearing_rad": truth.bearing_rad[rows],
        "true_signed_bearing_rad": truth.signed_bearing_rad[rows],
        "true_radius_m": truth.radius_m[rows],
        **estimates.columns,
        "candidates": estimates.candidates,
    }
    return {name: column[inside].tolist() for name, column in columns.items()}


def truth_entry(cell: Cell, setting: Situation, beep: BeepDesign, truths: Sequence[GroundTruth]) -> dict[str, Any]:
    """What is true of the walk as a whole: numbers by name, of the first target."""
    truth, target = truths[0], setting.scene.obstacle(setting.targets[0])
    walked = cell.kind != "standing"
    index = detection_index_db(setting, truth, beep, Fidelity(**cell.fidelity)) if walked else math.nan
    return {
        "targets": list(setting.targets),
        "collides": bool(truth.collides),
        "line_collides": bool(truth.line_collides),
        "contact_time_s": float(truth.contact_time_s),
        "miss_distance_m": float(truth.miss_distance_m),
        "clearance_m": float(truth.clearance_m),
        "overlap_m": max(0.0, cell.scoring.half_width_m - truth.miss_distance_m) if truth.collides else math.nan,
        "detection_index_db": index,
        "moving": bool(target.moves),
        "radius_m": float(truth.radius_m[0]),
        "duration_s": float(setting.walk.duration_s),
    }
