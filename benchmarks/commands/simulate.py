"""`obstaclewatch simulate`: one walk to an audio file."""

from __future__ import annotations

import json
from pathlib import Path

import click
import numpy as np

from obstaclewatch import BeepDesign, write_recording
from scenes import GaitWalk, load_scene, make_approach, walker_body
from simulator import Fidelity, Phone, Scene, Walk, render_walk
from simulator.paths import Paths
from simulator.render import trace_walk

SUFFIXES = (".wav", ".flac")


@click.command()
@click.argument("scene")
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="a .wav or .flac file")
@click.option("--phone", default="galaxy-s5", show_default=True, help="a name of `obstaclewatch ls phones`")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="of scene, walk and noise")
@click.option("--category", help="an approach to a wall, dustbin, car, sign or pedestrian of a named scene")
@click.option("--index", default=0, show_default=True, help="which approach of the category")
@click.option("--collision/--no-collision", default=True, show_default=True, help="whether the approach ends in one")
@click.option("--start", default="0,0,1.3", show_default=True, metavar="X,Y,Z", help="start of a walk, m")
@click.option("--heading", default=0.0, show_default=True, help="direction of a walk, degrees from +x")
@click.option("--speed", default=1.3, show_default=True, help="of a walk, m/s")
@click.option("--duration", default=4.5, show_default=True, help="of a walk, s")
@click.option("--pitch", default=30.0, show_default=True, help="lift of the phone's top edge, degrees")
@click.option("--paths", type=click.Path(path_type=Path), help="also write the traced paths as JSON")
def simulate(
    scene: str, output: Path, phone: str, seed: int, category: str | None, index: int, collision: bool,
    start: str, heading: float, speed: float, duration: float, pitch: float, paths: Path | None,
) -> None:  # fmt: skip
    """Render what the phone records in SCENE (a name or a YAML file), on a straight walk or an approach."""
    if output.suffix.lower() not in SUFFIXES:
        raise ValueError(f"output must end in .wav or .flac, got '{output}'")
    for path in (output, paths):
        if path is not None and not path.parent.is_dir():
            raise ValueError(f"the folder of '{path}' must exist")
    beep, fidelity = BeepDesign(), Fidelity()
    if category is None:
        walk: Walk = GaitWalk(_point(start), np.deg2rad(heading), speed, duration, np.deg2rad(pitch))
        world: Scene = load_scene(scene, seed)
        held = Phone.named(phone).held_by(walker_body(phone_height_m=float(_point(start)[2])))
    else:
        approach = make_approach(scene, category, index, phone, seed, collision)
        walk, world, held = approach.walk, approach.scene, approach.phone
    recording = render_walk(world, held, walk, beep, fidelity, seed)
    write_recording(recording, output)
    if paths is not None:
        paths.write_text(_paths_json(trace_walk(world, held, walk, beep, fidelity)[0]), encoding="utf-8")
    click.echo(f"{output}: {recording.duration_s:.2f} s, 2 microphones, {recording.sample_rate_hz:.0f} Hz")


def _point(text: str) -> np.ndarray:
    try:
        point = np.array([float(part) for part in text.split(",")])
    except ValueError:
        point = np.zeros(0)
    if point.shape != (3,):
        raise ValueError(f"start must be three numbers X,Y,Z, got '{text}'")
    return point


def _paths_json(found: Paths) -> str:
    """One entry a path, m and dB, for reading and plotting elsewhere."""
    rows = [
        {
            "beep": int(found.pose[k]), "mic": int(found.mic[k]), "kind": str(found.kind[k]),
            "order": int(found.order[k]), "obstacle": str(found.obstacle[k]), "delay_s": float(found.delay_s[k]),
            "level_db": float(20.0 * np.log10(np.abs(found.gain[k]))),
            "points_m": found.points_m[k, : found.order[k] + 2].tolist(),
        }
        for k in range(len(found))
    ]  # fmt: skip
    return json.dumps({"explain": found.explain().splitlines(), "paths": rows}, indent=1)
