"""Image paths in one room by this simulator, pyroomacoustics and acoustic-spaces, in one run.

acoustic-spaces runs as a program of its own: its licence is not ours.
"""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.cells.probes.speed.room import ARMS_M, PATHS, SIZE_M, SOUND_M_S, mirrors, paths_in, room, sources_m
from benchmarks.cells.probes.speed.timing import cpu_ms, require
from benchmarks.cells.spec import Cell
from obstaclewatch.support.arrays import Floats

TWINS_M, ROUNDING_M = 1e-4, 2e-5
"""pyroomacoustics computes in single precision, and counts a path past a corner once for each order of its walls."""
PLAN_M = SIZE_M[:2] * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])


def against_peers(cell: Cell, order: int = 2, places: int = 50) -> tuple[dict[str, float], list[str]]:
    """Time a pair of source and microphone: of a walk in one call, of places one by one, and of the peers there are."""
    scene, source, fidelity = room(), sources_m(places), mirrors(order)
    paths, pairs = paths_in(scene, source, fidelity), [(n, m) for n in range(places) for m in (0, 1)]
    ours = [paths.delay_s[(paths.pose == n) & (paths.mic == m)] * SOUND_M_S for n, m in pairs]
    require(all(len(each) == PATHS[order] for each in ours), f"a pair has not {PATHS[order]} paths")
    walk_ms = cpu_ms(lambda: paths_in(scene, source, fidelity)) / len(pairs)
    single_ms = cpu_ms(lambda: [paths_in(scene, here[None], fidelity) for here in source], 3) / len(pairs)
    found = {"walk_ms": walk_ms, "one_by_one_ms": single_ms, "one_by_one_ratio": single_ms / walk_ms}
    missing = sorted(name for name in PEERS if find_spec(name) is None)
    for name in sorted(set(PEERS) - set(missing)):
        lengths, pair_ms = PEERS[name](source, order)
        require([len(_distinct(a)) for a in ours] == [len(_distinct(b)) for b in lengths], f"{name} has other paths")
        error = max(np.abs(_distinct(a) - _distinct(b)).max() for a, b in zip(ours, lengths, strict=True))
        require(error < ROUNDING_M, f"paths of {name} and ours differ by {error:.2g} m")
        found |= {f"{name}_ms": pair_ms, f"{name}_ratio": pair_ms / walk_ms}
    return found, missing


def _distinct(length_m: Floats) -> Floats:
    """Sorted lengths, those of one path or of twins once."""
    length_m = np.sort(length_m)
    return length_m[np.diff(length_m, prepend=0.0) > TWINS_M]


def _pyroomacoustics(source: Floats, order: int) -> tuple[list[Floats], float]:
    """Lengths of each pair, and processor time a pair, ms."""
    import pyroomacoustics

    pyroomacoustics.constants.set("num_threads", 1)

    def walk() -> list[Floats]:
        lengths = []
        for here in source:
            walls = pyroomacoustics.Room.from_corners(PLAN_M.T, fs=192_000, max_order=order)
            walls.extrude(SIZE_M[2])
            walls.add_source(here)
            walls.add_microphone_array((here + ARMS_M).T)
            walls.image_source_model()
            seen = walls.visibility[0].astype(bool)
            images = walls.sources[0].images.T
            lengths += [np.linalg.norm(images[s] - m, axis=1) for s, m in zip(seen, here + ARMS_M, strict=True)]
        return lengths

    return walk(), cpu_ms(walk, 3) / (2 * len(source))


def acoustic_spaces(geometry: dict[str, Any], source: Floats, order: int) -> tuple[list[Floats], float]:
    """Lengths of each pair, and processor time a pair, ms, by acoustic-spaces in a geometry as its scenes have it."""
    asked = {
        "geometry": geometry, "order": order,
        "sources": source.tolist(), "receivers": (source[:, None] + ARMS_M).tolist(),
    }  # fmt: skip
    program = Path(__file__).with_name("acoustic_spaces_program.py")
    done = subprocess.run(
        [sys.executable, program], input=json.dumps(asked), capture_output=True, text=True, check=True
    )
    answer = json.loads(done.stdout)
    return [np.array(each) for each in answer["length_m"]], answer["pair_ms"]


def _acoustic_spaces(source: Floats, order: int) -> tuple[list[Floats], float]:
    """The same."""
    return acoustic_spaces({"floor_plan": PLAN_M.tolist(), "height": float(SIZE_M[2])}, source, order)


PEERS = {"acoustic_spaces": _acoustic_spaces, "pyroomacoustics": _pyroomacoustics}
