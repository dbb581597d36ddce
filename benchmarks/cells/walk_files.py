"""One cell as files for people who train detectors of their own: a recording, its truth and its paths."""

from __future__ import annotations

import hashlib
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.cells.compute import after_microphones, situation_of, truth_entry, truths_at_beeps
from benchmarks.cells.situations.situation import Situation, rendered
from benchmarks.cells.spec import Cell
from obstaclewatch import BeepDesign, write_recording
from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.whole_file import whole_file
from scenes.truth.truth import GroundTruth
from simulator.paths import Paths

FOLDERS = {"recordings": "flac", "truth": "parquet", "paths": "parquet"}
TRANSDUCERS = ("speaker", "mic0", "mic1")


def walk_name(cell: Cell) -> str:
    """What a walk's files are called: the same for the same walk in any data set."""
    return cell.digest("")[:16]


def file_of(folder: Path, kind: str, name: str) -> Path:
    """Where a walk's recording, truth or paths lie."""
    return folder / kind / f"{name}.{FOLDERS[kind]}"


def write_walk(cell: Cell, folder: Path) -> dict[str, Any]:
    """Simulate a cell and write its three files, each complete or not at all; what is true of the walk as a whole.

    The result has the checksums of the files, by which a copy cut short or a changed one is found later.

    Raises:
        ValueError: as `benchmarks.cells.compute.compute`, or samples beyond full scale, which FLAC does not hold.
    """
    begin, name, blocks = perf_counter(), walk_name(cell), []
    setting, beep = situation_of(cell), cell.beep.design()
    recorded = rendered(setting, cell, lambda paths, first: blocks.append(_path_rows(paths, first)))
    recording = after_microphones(cell, setting, recorded)
    truths = truths_at_beeps(cell, setting, beep, recording)
    tables = {"paths": pd.concat(blocks, ignore_index=True), "truth": _truth_rows(setting, beep, truths)}
    for kind, table in tables.items():
        with whole_file(file_of(folder, kind, name), lasting=False) as partial:
            table.to_parquet(partial, index=False, compression="zstd")
    write_recording(recording, file_of(folder, "recordings", name))
    phone = {
        f"{part}_m": position.tolist()
        for part, position in zip(TRANSDUCERS, _points(setting), strict=True)
    }  # fmt: skip
    facts = truth_entry(cell, setting, beep, truths) | phone
    facts |= {"sound_speed_m_s": setting.scene.air.sound_speed_m_s, "beeps": len(truths[0].time_s)}
    sums = {kind: checksum(file_of(folder, kind, name)) for kind in FOLDERS}
    return {"truth": facts, "detectors": {}, "files": sums, "cost": {"total_s": perf_counter() - begin}}


def checksum(path: Path) -> str:
    """SHA-256 of a file, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _points(setting: Situation) -> Floats:
    """(3, 3) speaker and microphones in the phone's frame, m."""
    geometry = setting.phone.geometry
    return np.vstack([geometry.speaker_m, geometry.mics_m])


def _truth_rows(setting: Situation, beep: BeepDesign, truths: list[GroundTruth]) -> pd.DataFrame:
    """A row a target and beep: where it is when the beep's centre meets it, and where the phone is then."""
    parts = []
    for target, truth in zip(setting.targets, truths, strict=True):
        pose = setting.walk.pose(truth.time_s)
        world = np.stack([pose.to_world(point) for point in _points(setting)], axis=1)
        places = {
            f"{part}_{axis}_m": world[:, row, column]
            for row, part in enumerate(TRANSDUCERS)
            for column, axis in enumerate("xyz")
        }
        columns = {
            "target": target, "beep": np.arange(len(truth.time_s)),
            "emitted_s": beep.period_s * np.arange(len(truth.time_s)), "time_s": truth.time_s,
            "range_m": truth.range_m, "mic0_range_m": truth.mic_range_m[:, 0], "mic1_range_m": truth.mic_range_m[:, 1],
            "mic0_ground_range_m": truth.mic_ground_range_m[:, 0],
            "mic1_ground_range_m": truth.mic_ground_range_m[:, 1], "by_ground": truth.by_ground,
            "bearing_rad": truth.signed_bearing_rad, "radius_m": truth.radius_m,
            "heading_rad": pose.body_heading_rad(),
        }  # fmt: skip
        parts.append(pd.DataFrame(columns | places))
    return pd.concat(parts, ignore_index=True)


def _path_rows(paths: Paths, first_beep: int) -> pd.DataFrame:
    """A row a path: the direct sound, and every echo that was rendered."""
    return pd.DataFrame(
        {
            "beep": paths.pose + first_beep,
            "mic": paths.mic.astype(np.int8),
            "kind": pd.Categorical(paths.kind),
            "order": paths.order.astype(np.int8),
            "obstacle": pd.Series(paths.obstacle, dtype="str"),
            "delay_s": paths.delay_s,
            "gain_real": paths.gain.real.astype(np.float32),
            "gain_imag": paths.gain.imag.astype(np.float32),
        }
    )
