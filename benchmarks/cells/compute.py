"""Simulate, detect, compare: the body of one cell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from time import perf_counter, process_time
from typing import Any

import numpy as np

from benchmarks.cells.association import Estimates, associate
from benchmarks.cells.channel import through_channel
from benchmarks.cells.detectors import detector_label
from benchmarks.cells.equipment import detector_for
from benchmarks.cells.interference import with_interferer
from benchmarks.cells.loud_echoes import loud_echo_ranges
from benchmarks.cells.outcome import distance_before, outcomes
from benchmarks.cells.probes.extremes import numerics_result
from benchmarks.cells.probes.fidelities import fidelity_result
from benchmarks.cells.probes.motions import motion_result
from benchmarks.cells.probes.signals import signal_result
from benchmarks.cells.probes.tessellations import tessellation_result
from benchmarks.cells.situations.approaching import approach_situation
from benchmarks.cells.situations.own_scene import scene_situation
from benchmarks.cells.situations.situation import Situation, rendered
from benchmarks.cells.situations.standing import standing_situation
from benchmarks.cells.situations.variation import varied
from benchmarks.cells.spec import Cell
from obstaclewatch import BeepDesign, NoBeepError
from obstaclewatch.recording import Recording
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
}

PROGRESS_STEP_S = 0.02
"""Spacing at which a walk is followed for the distance walked: a turn of 1 rad/s departs by 0.02 mm a step."""


def compute(cell: Cell) -> dict[str, Any]:
    """All numbers of one cell, ready for JSON: "truth", "detectors" (one entry each) and "cost" (times, s).

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
    return {"truth": _truth_entry(setting, truths), "detectors": found, "cost": cost} | echoes


def recording_of(cell: Cell) -> tuple[Situation, BeepDesign, Recording]:
    """What a walk or a standing measurement simulates, its beep, and the recording that the detectors run on."""
    setting, recorded = _simulated(simulated_part(cell).model_dump_json())
    beep = BeepDesign(**cell.beep.model_dump())
    return setting, beep, through_channel(with_interferer(recorded, setting, beep, cell.interferer), cell.recording)


def simulated_part(cell: Cell) -> Cell:
    """The cell with everything left out that changes nothing before the microphones: its simulation can be shared."""
    after_microphones = ("recording", "interferer", "knowledge", "settings", "scoring", "variant", "detector_sources")
    kept = cell.model_dump(mode="json", exclude=set(after_microphones))
    return Cell.model_validate(kept | {"detectors": ()})


@lru_cache(maxsize=1)
def _simulated(cell_json: str) -> tuple[Situation, Recording]:
    """What is rendered, kept for the next cell: the points of a sweep over detectors come one after another."""
    cell = Cell.model_validate_json(cell_json)
    setting = varied(SITUATIONS[cell.kind](cell), cell)
    return setting, rendered(setting, cell)


def truths_at_beeps(cell: Cell, setting: Situation, beep: BeepDesign, recording: Recording) -> list[GroundTruth]:
    """Ground truth of every target at the instants at which the beeps' centres meet it."""
    starts = beep.period_s * np.arange(math.floor(recording.duration_s / beep.period_s + 1e-9))
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
    """One detector on the recording: its first alert, the outcome, and its estimates of every target."""
    detector = detector_for(cell, name, setting, beep)
    begin, begin_cpu = perf_counter(), process_time()
    detections, no_beep = detections_of(detector, recording)
    cost = {"detect_s": perf_counter() - begin, "detect_cpu_s": process_time() - begin_cpu}
    alert = first_alert(detections)
    entry = {**alert, **_alert_scores(cell, alert, setting.walk, truths[0]), **cost, "no_beep": no_beep}
    entry["beeps"] = [_beep_table(cell, detections, truth) for truth in truths]
    return entry


def detections_of(detector: Any, recording: Recording) -> tuple[list[Any], bool]:
    """All detections, and whether the detector found no beep at all: a result, not a failure of the bench."""
    try:
        return list(detector.stream(recording)), False
    except NoBeepError:
        return [], True


def first_alert(detections: Sequence[Any]) -> dict[str, Any]:
    """Whether, when and at which range a detector first raised an alert."""
    for detection in detections:
        if detection.decision.alert:
            decision = detection.decision
            return {"alert": True, "alert_time_s": decision.time_s, "alert_range_m": decision.range_m}
    return {"alert": False, "alert_time_s": math.nan, "alert_range_m": math.nan}


def _alert_scores(cell: Cell, alert: Mapping[str, Any], walk: Walk, truth: GroundTruth) -> dict[str, Any]:
    distance = distance_before(_progress_m(walk, alert["alert_time_s"]), _progress_m(walk, truth.contact_time_s))
    judged = outcomes(alert["alert"], distance, truth.collides, truth.line_collides, cell.scoring)
    lead_s = float(np.subtract(truth.contact_time_s, alert["alert_time_s"]))
    return {"alert_distance_m": distance, "alert_lead_s": lead_s, **judged}


def _progress_m(walk: Walk, time_s: float) -> float:
    """How far the phone has come along its heading, which may turn; NaN at NaN."""
    if math.isnan(time_s):
        return math.nan
    pose = walk.pose(np.linspace(0.0, time_s, 2 + math.ceil(abs(time_s) / PROGRESS_STEP_S)))
    heading = pose.body_heading_rad()
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    step = np.diff(pose.position_m[:, :2], axis=0)
    return float(np.sum(step * 0.5 * (ahead[1:] + ahead[:-1])))


def echo_range_m(truth: GroundTruth) -> np.ndarray:
    """(T, 2) range of the target at each microphone: of low ones that of their foot on the ground."""
    range_m: np.ndarray = np.where(truth.by_ground[:, None], truth.mic_ground_range_m, truth.mic_range_m)
    return range_m


def _beep_table(cell: Cell, detections: Sequence[Any], truth: GroundTruth) -> dict[str, Any]:
    """Columns over the beeps with the target in range: truth beside estimates."""
    # Emission times are the detector's own; to the nearest period they count the beeps, also where it began late.
    index = np.rint([detection.time_s / cell.beep.period_s for detection in detections]).astype(np.int64)
    kept = (index >= 0) & (index < len(truth.time_s))
    rows = index[kept]
    within = [detection for detection, keep in zip(detections, kept, strict=True) if keep]
    path_m = echo_range_m(truth)
    estimates: Estimates = associate(within, path_m[rows, 0], cell.scoring.gate_m)
    inside = (truth.range_m[rows] <= cell.scoring.max_range_m) & ~(truth.time_s[rows] > truth.contact_time_s)
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


def _truth_entry(setting: Situation, truths: Sequence[GroundTruth]) -> dict[str, Any]:
    truth = truths[0]
    return {
        "targets": list(setting.targets),
        "collides": bool(truth.collides),
        "line_collides": bool(truth.line_collides),
        "contact_time_s": float(truth.contact_time_s),
        "miss_distance_m": float(truth.miss_distance_m),
        "clearance_m": float(truth.clearance_m),
        "radius_m": float(truth.radius_m[0]),
        "duration_s": float(setting.walk.duration_s),
    }
