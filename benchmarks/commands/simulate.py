"""`obstaclewatch simulate`: one walk to an audio file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from benchmarks.commands import OF_APPROACH, SOUNDS, Real, check_output, check_pitch, given, refuse_given

if TYPE_CHECKING:
    from scenes import Encounter
    from simulator.paths import Paths

STRAIGHT: tuple[str, ...] = ("start", "heading", "speed", "duration", "pitch")
"""Options of a straight walk."""


@click.command()
@click.argument("scene")
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="a .wav or .flac file")
@click.option(
    "--phone", default="galaxy-s5", show_default=True, help="a name of `obstaclewatch ls phones`, instead of a file's"
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="of scene, walk and noise")
@click.option("--category", help="an approach to a wall, dustbin, car, sign or pedestrian of a named scene")
@click.option(
    "--index", type=click.IntRange(min=0), default=0, show_default=True, help="which approach of the category"
)
@click.option("--collision/--no-collision", default=True, show_default=True, help="whether the approach ends in one")
@click.option("--start", default="0,0,1.3", show_default=True, metavar="X,Y,Z", help="start of a walk, m")
@click.option("--heading", type=Real(), default=0.0, show_default=True, help="direction of a walk, degrees from +x")
@click.option("--speed", type=Real(), default=1.3, show_default=True, help="of a walk, m/s")
@click.option("--duration", type=Real(), default=4.5, show_default=True, help="of a walk, s")
@click.option("--pitch", type=Real(), default=30.0, show_default=True, help="pitch of the phone's top edge, degrees")
@click.option("--paths", type=click.Path(path_type=Path), help="also write the traced paths as JSON")
def simulate(
    scene: str, output: Path, phone: str, seed: int, category: str | None, index: int, collision: bool,
    start: str, heading: float, speed: float, duration: float, pitch: float, paths: Path | None,
) -> None:  # fmt: skip
    """Render what the phone records in SCENE (a name or a YAML file).

    On the walk and with the phone of the file if it has a walk, else on a straight walk, or on an approach.
    """
    from benchmarks.cells.memory import check_file, check_workers
    from benchmarks.runs.store import write_atomically
    from obstaclewatch import BeepDesign, write_recording
    from scenes import Encounter, GaitWalk, load_scene, make_approach, walker_body
    from scenes.files.encounter import has_walk
    from simulator import Fidelity, Phone, render_pieces
    from simulator.render import beep_count, trace_walk

    check_output(output, "--output", SOUNDS, [Path(scene)])
    if paths is not None:
        check_output(paths, "--paths", (".json",), [Path(scene), output])
    beep, fidelity = BeepDesign(), Fidelity()
    _check_given(category, has_walk(scene))
    check_pitch(pitch)
    if category is not None:
        approach = make_approach(scene, category, index, phone, seed, collision)
        met = Encounter(approach.scene, approach.walk, approach.phone, (approach.target,))
    elif has_walk(scene):
        met = _of_file(scene, seed, phone)
    else:
        walk = GaitWalk(_point(start), np.deg2rad(heading), speed, duration, np.deg2rad(pitch))
        held = Phone.named(phone).held_by(walker_body(phone_height_m=float(_point(start)[2])))
        met = Encounter(load_scene(scene, seed), walk, held, ())
    duration_s = beep_count(met.walk, beep) * beep.period_s
    check_workers(1, 0.0 if paths is None else duration_s, beep.sample_rate_hz)
    check_file(output, duration_s, beep.sample_rate_hz)
    write_recording(render_pieces(met.scene, met.phone, met.walk, beep, fidelity, seed), output)
    if paths is not None:
        traced = trace_walk(met.scene, met.phone, met.walk, beep, fidelity)[0]
        write_atomically(paths, _paths_json(traced))
    click.echo(f"{output}: {duration_s:.2f} s, 2 microphones, {beep.sample_rate_hz:.0f} Hz")


def _of_file(scene: str, seed: int, phone: str) -> Encounter:
    """The file's own walk, with its phone unless another is asked for."""
    from scenes import load_encounter

    return load_encounter(scene, seed, phone if "phone" in given() else None)


def _check_given(category: str | None, own_walk: bool) -> None:
    """No option may be given that does nothing.

    Raises:
        ValueError: options of a straight walk beside another walk, or of an approach without one.
    """
    if category is not None:
        useless, reason = STRAIGHT, "--category draws a walk of its own"
    elif own_walk:
        useless, reason = STRAIGHT + OF_APPROACH, "the scene has a walk of its own"
    else:
        useless, reason = OF_APPROACH, "there is no --category"
    refuse_given(useless, reason)


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
