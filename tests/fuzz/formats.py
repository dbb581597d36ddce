"""What is read from files and words of others: a good example of each, and the reading that must end clearly."""

from __future__ import annotations

import base64
import io
import json
import os
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import click
import numpy as np
import soundfile
import trimesh
import yaml

from benchmarks.cli import cli
from benchmarks.gates.baseline import baseline_walks, load_baseline
from benchmarks.gates.config import load_gates
from benchmarks.history import history
from benchmarks.own_phone import load_phone
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.runs.results import RunData, load_run
from benchmarks.runs.store import cell_path, to_json, write_cell
from benchmarks.scoring.frames import write_frames
from benchmarks.scoring.scores import approach_table, beep_table, summary
from obstaclewatch import read_recording
from scenes import load_encounter
from scenes.files.mesh_file import FORMATS as MESHES
from scenes.files.mesh_file import read_mesh
from tests.benchmarks.synthetic_run import made_up_run, walk
from tests.fuzz.mutations import changed_bytes, changed_data

DIGEST = "ab" + 62 * "0"
MANIFEST = {
    "argv": ["run"], "suite": "a", "tier": "b", "split": "test", "seed": 0, "plan": [DIGEST], "versions": {"a": "1"},
}  # fmt: skip
SCENE: dict[str, Any] = {
    "name": "yard", "air": {"temperature_c": 12, "relative_humidity": 0.7}, "ground": {"material": "asphalt"},
    "obstacles": [
        {"kind": "box", "name": "block", "at_m": [6, 0], "parameters": {"size_m": [1, 1, 1]}, "material": "brick"},
        {"kind": "bollard", "name": "post", "at_m": [3, 1], "yaw_deg": 5, "velocity_m_s": [0, 0, 0]},
    ],
    "walk": {"start_m": [0, 0], "heading_deg": 0, "duration_s": 4, "stops": [{"at_s": 1, "for_s": 1.5}]},
    "phone": {"preset": "galaxy-s5"}, "target": "post",
}  # fmt: skip
SUITE: dict[str, Any] = {
    "name": "mine", "title": "Mine", "seed": 1, "tiers": {"smoke": {"fraction": 1.0}},
    "detectors": ["PaperDetector(votes_needed=3)"], "figures": ["extremes"], "air": {"temperature_c": 10.0},
    "probes": [{"kind": "numerics", "name": "slivers", "over": {"aspect": [1.0, 2.0]}}],
    "sweep": {"over": {"beep.start_hz": {"low": 17000, "high": 18000, "count": 2}}},
    "standing": {"phones": ["ideal"], "counts": {"wall": 1}, "range_m": [1.5]},
}  # fmt: skip
GATES: dict[str, Any] = {
    "title": "Mine", "baseline": "b.json", "claimed": "TrackingDetector", "physics": {"wall_level": 0.01},
    "claims": [{"rate": "TP", "at_least": 0.9, "scene": "campus"}, {"quantity": "snr", "at_most": 3.0}],
    "regression": [{"detector": "PaperDetector", "approach": {"snr": 0.3}, "rates": ["TP"]}],
}  # fmt: skip
PHONE: dict[str, Any] = {
    "name": "mine", "speaker_m": [0.0, 0.05, 0.0], "mics_m": [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]],
    "direct_delay_s": 5e-5, "mic_phase_rad": 0.5,
}  # fmt: skip
WORDS = (
    "run", "status", "figures", "report", "gate", "baseline", "compare", "ls", "validate", "doctor", "detect", "scene",
    "check", "preview", "update", "history", "paper", "suites", "checks", "-n", "-k", "--tier", "smoke", "--set",
    "--only", "--seed", "--limit", "-o", "--json", "--reason", "--detector", "a=b", "0", "-1", "9" * 400, "nan", " ",
    "\u00fc", "", "../..", "(", "not", "supermarket", "x.yaml", "--band", "1-2", "--help", "-h", "--phone", "ideal",
    "\x00", "a" * 5000, "*", "[", "{a: &a [*a]}",
)  # fmt: skip
SLOW = {("doctor",), ("scene", "check")}
"""What takes seconds by right is not asked for."""


@dataclass(frozen=True)
class Format:
    """One kind of input.

    Attributes:
        make: from a random stream to an input, bytes or words.
        read: reads it within an empty folder; returns, or raises what a user is told.
        good: what the inputs are made from, as it is: accepted, or else no change of it could be.
    """

    make: Callable[[np.random.Generator], bytes]
    read: Callable[[bytes, Path], object]
    good: Callable[[], list[bytes]]


def _changed_yaml(good: dict[str, Any]) -> Callable[[np.random.Generator], bytes]:
    text = yaml.safe_dump(good, sort_keys=False).encode()

    def make(rng: np.random.Generator) -> bytes:
        if rng.random() < 0.4:
            return changed_bytes(text, rng)
        return yaml.safe_dump(changed_data(good, rng), sort_keys=False, allow_unicode=True).encode("utf-8", "replace")

    return make


def _changed_json(good: dict[str, Any]) -> Callable[[np.random.Generator], bytes]:
    text = json.dumps(good).encode()
    return lambda rng: changed_bytes(text, rng) if rng.random() < 0.4 else json.dumps(changed_data(good, rng)).encode()


def _written(name: str, read: Callable[[Path], object]) -> Callable[[bytes, Path], object]:
    def reading(data: bytes, folder: Path) -> object:
        (folder / name).write_bytes(data)
        return read(folder / name)

    return reading


def _suite(path: Path) -> object:
    return plan_cells(load_suite(str(path)), "smoke")


def _setting(data: bytes, folder: Path) -> object:
    (folder / "suite.yaml").write_text(yaml.safe_dump(SUITE), encoding="utf-8")
    text = data.decode("utf-8", "surrogateescape")
    return plan_cells(load_suite(str(folder / "suite.yaml"), [text]), "smoke")


KEYS = (
    "seed", "detectors", "tiers", "air.temperature_c", "beep.start_hz", "probes", "sweep", "scoring.gate_m", "", "a.b",
    "groups", "fidelity.max_order", "settings.errata", "name", "figures", "recording.mic_delay_samples",
)  # fmt: skip


def _settings(rng: np.random.Generator) -> bytes:
    value = yaml.safe_dump(changed_data({"a": [1, {"b": "PaperDetector"}]}, rng), default_flow_style=True).strip()
    text = f"{KEYS[int(rng.integers(len(KEYS)))]}={value}".encode("utf-8", "replace")
    return changed_bytes(text, rng) if rng.random() < 0.5 else text


@cache
def _meshes() -> dict[str, bytes]:
    box = trimesh.creation.box()
    made = {suffix: box.export(file_type=suffix[1:]) for suffix in MESHES if suffix != ".gltf"}
    files = box.export(file_type="gltf")
    whole = json.loads(files["model.gltf"])
    for buffer in whole["buffers"]:
        buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(files[buffer["uri"]]).decode()
    made[".gltf"] = json.dumps(whole)
    return {suffix: data if isinstance(data, bytes) else data.encode() for suffix, data in made.items()}


def _mesh(rng: np.random.Generator) -> bytes:
    suffix = MESHES[int(rng.integers(len(MESHES)))]
    return suffix.encode() + b"\n" + changed_bytes(_meshes()[suffix], rng)


def _read_mesh(data: bytes, folder: Path) -> object:
    suffix, _, body = data.partition(b"\n")
    path = folder / f"mesh{suffix.decode()}"
    path.write_bytes(body)
    return read_mesh(path, 1.0, "z")


@cache
def _sounds() -> dict[str, bytes]:
    samples, made = np.random.default_rng(0).uniform(-0.5, 0.5, (200, 2)), {}
    for form, subtype in (("WAV", "PCM_16"), ("WAV", "FLOAT"), ("FLAC", "PCM_16"), ("WAVEX", "PCM_24")):
        stream = io.BytesIO()
        soundfile.write(stream, samples, 48_000, subtype=subtype, format=form)
        made[f"{form} {subtype}"] = stream.getvalue()
    return made


def _sound(rng: np.random.Generator) -> bytes:
    names = sorted(_sounds())
    data = _sounds()[names[int(rng.integers(len(names)))]]
    head = int(rng.choice([60, 120, len(data)]))  # mostly the header: of the samples any are right
    return changed_bytes(data[:head], rng) + data[head:]


def _cell(data: bytes, folder: Path) -> object:
    (folder / "manifest.json").write_text(json.dumps(MANIFEST))
    path = cell_path(folder, DIGEST)
    path.parent.mkdir(parents=True, exist_ok=True)
    if data[:1] == b"{" and data[-2:] == b"}\n":
        write_cell(path, data.decode("utf-8", "replace"))  # sealed, as a stranger could
    else:
        path.write_bytes(data)
    return _tables(folder)


def _manifest(data: bytes, folder: Path) -> object:
    write_cell(cell_path(folder, DIGEST), to_json(walk() | {"digest": DIGEST}))
    (folder / "manifest.json").write_bytes(data)
    return _tables(folder)


def _tables(folder: Path) -> object:
    run = load_run(folder)
    return write_frames(run), [table(run) for table in TABLES]


TABLES: tuple[Callable[[RunData], object], ...] = (
    lambda run: approach_table(run, "PaperDetector"),
    lambda run: beep_table(run, "PaperDetector", "approach"),
)


def _cells(rng: np.random.Generator) -> bytes:
    good = json.loads(to_json(walk(detectors=("PaperDetector",)) | {"digest": DIGEST}))
    text = json.dumps(changed_data(good, rng)).encode() + b"\n"
    return text if rng.random() < 0.7 else changed_bytes(text, rng)


def _phone(path: Path) -> object:
    return load_phone(path).geometry.speaker_to_mic_m


@cache
def _summary() -> dict[str, Any]:
    return json.loads(to_json(summary(made_up_run(Path("nowhere"), [walk()]), {})))


def _summaries(rng: np.random.Generator) -> bytes:
    return _changed_json(_summary())(rng)


def _history(data: bytes, folder: Path) -> object:
    """Of one run, whose summary is a stranger's."""
    began = {"started": "2026-01-01", "source_sha256": DIGEST, "git_revision": None, "git_dirty": False}
    (folder / "manifest.json").write_text(json.dumps(MANIFEST | began))
    (folder / "summary.json").write_bytes(data)
    frame, silent = history(folder)
    if silent:
        raise ValueError(f"left out: {silent}")
    return frame


def _baseline(path: Path) -> object:
    return [baseline_walks(run, name) for run in load_baseline(path).runs.values() for name in run.values]


BASELINE = {
    "format": 1, "history": [{"date": "2026-11-21", "reason": "x", "runs": {"a": {"D": "TP 1/1"}}}],
    "runs": {"a/b/test/0": {
        "source": "0", "walks": ["a", "b"], "collides": "10", "right": {"D": "11"},
        "values": {"D": {"approach": {"labels": ["a", "b"], "columns": {"snr": [1.0, None]}}}},
    }},
}  # fmt: skip


def _arguments(rng: np.random.Generator) -> bytes:
    words = [WORDS[int(rng.integers(len(WORDS)))] for _ in range(int(rng.integers(1, 6)))]
    if words[0] == "run":
        words.append("-n")
    return "\n".join(words).encode("utf-8")


def _command(data: bytes, folder: Path) -> object:
    words = data.decode().split("\n")
    if any(tuple(words[: len(slow)]) == slow for slow in SLOW):
        return None
    before = Path.cwd()
    os.chdir(folder)
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            return _invoked(words)
    finally:
        os.chdir(before)


def _invoked(words: Sequence[str]) -> object:
    try:
        return cli(list(words), standalone_mode=False)
    except SystemExit as ended:
        if ended.code:
            raise click.ClickException(f"exit code {ended.code}") from ended
        return 0


def _yaml(good: dict[str, Any]) -> Callable[[], list[bytes]]:
    return lambda: [yaml.safe_dump(good, sort_keys=False).encode()]


def _json(good: dict[str, Any]) -> Callable[[], list[bytes]]:
    return lambda: [json.dumps(good).encode()]


def _good_meshes() -> list[bytes]:
    return [suffix.encode() + b"\n" + data for suffix, data in _meshes().items()]


def _good_cell() -> list[bytes]:
    return [to_json(walk(detectors=("PaperDetector",)) | {"digest": DIGEST}).encode() + b"\n"]


FORMATS: dict[str, Format] = {
    "scene": Format(_changed_yaml(SCENE), _written("scene.yaml", load_encounter), _yaml(SCENE)),
    "suite": Format(_changed_yaml(SUITE), _written("suite.yaml", _suite), _yaml(SUITE)),
    "gates": Format(_changed_yaml(GATES), _written("gates.yaml", load_gates), _yaml(GATES)),
    "setting": Format(_settings, _setting, lambda: [b"seed=3", b"air.temperature_c=5", b"name=yours"]),
    "mesh": Format(_mesh, _read_mesh, _good_meshes),
    "sound": Format(_sound, _written("sound.wav", read_recording), lambda: list(_sounds().values())),
    "cell": Format(_cells, _cell, _good_cell),
    "manifest": Format(_changed_json(MANIFEST), _manifest, _json(MANIFEST)),
    "summary": Format(_summaries, _history, lambda: [json.dumps(_summary()).encode()]),
    "phone": Format(_changed_yaml(PHONE), _written("phone.yaml", _phone), _yaml(PHONE)),
    "baseline": Format(_changed_json(BASELINE), _written("baseline.json", _baseline), _json(BASELINE)),
    "arguments": Format(_arguments, _command, lambda: [b"ls\nsuites", b"run\npaper\n--tier\nsmoke\n-n"]),
}
